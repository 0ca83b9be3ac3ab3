"""All trees of a file and of those that it includes, and the versions of libraries that they are for."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcpn.errors import Problem
from mcpn.trees.nodes.choosing import DIALECTS, VersionChoice
from mcpn.trees.nodes.node import Tree, TreeNode
from mcpn.trees.nodes.row import NodeRow
from mcpn.trees.nodes.versions import between


def _any_version() -> VersionChoice:
    return VersionChoice(DIALECTS[0], {library: between(library) for library in DIALECTS[0]})


@dataclass(frozen=True, slots=True)
class Forest:
    """All trees of a file and of those that it includes.

    Args:
        trees: By identifier.
        main: The one that is executed.
        categories: What ``TreeNodesModel`` says of registered names.
        choice: As which versions of which libraries they are read.
        warnings: What is read though it is not as XML has it, and attributes that nothing reads.
    """

    trees: dict[str, Tree]
    main: Tree
    categories: dict[str, str] = field(default_factory=dict)
    choice: VersionChoice = field(default_factory=_any_version)
    warnings: tuple[Problem, ...] = ()

    def row(self, node: TreeNode) -> NodeRow | None:
        """What the table says of a node; ``None`` for one that no library has, or that uses a tree."""
        return None if tree_of(self, node) is not None else self.choice.row(node)

    def rule(self, node: TreeNode) -> str:
        """How a node is translated, by the table; empty where it says nothing of it."""
        row = self.row(node)
        return "" if row is None else row.rule


def tree_of(forest: Forest, node: TreeNode) -> Tree | None:
    """The tree that a node runs: a ``<SubTree>``, or, as some write it, an element of the tree's name."""
    if node.category == "SubTree" or (not node.children and node.category == ""):
        return forest.trees.get(node.id)
    return None
