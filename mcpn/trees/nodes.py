"""A behaviour tree as its file says it: nodes with their ports, and the trees of a file with its includes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from mcpn.errors import Source

PRECONDITIONS = ("_failureIf", "_successIf", "_skipIf", "_while")
"""Attributes that may decide what a node returns without its being ticked, in the order of evaluation."""
SCRIPTS = ("_onSuccess", "_onFailure", "_onHalted", "_post")
"""Attributes that write the blackboard."""


@dataclass(frozen=True, slots=True)
class TreeNode:
    """A node of a tree.

    Args:
        id: The registered name: Sequence, FollowPath, ...
        category: What the explicit form or a model says it is: Action, Condition, Control, Decorator, SubTree
            or nothing.
        name: The name of the instance, or ``None``.
        ports: Its ports and remappings, without attributes that begin with ``_``.
        rules: Attributes that begin with ``_``: pre- and post-conditions, ``_autoremap``.
        children: The nodes inside.
        source: File and line.
    """

    id: str
    category: str
    name: str | None
    ports: Mapping[str, str]
    rules: Mapping[str, str]
    children: tuple[TreeNode, ...]
    source: Source

    @property
    def title(self) -> str:
        """What people call it: its registered name, and the name of the instance."""
        return self.id if self.name in (None, self.id) else f"{self.id} {self.name}"

    def walk(self) -> Iterator[TreeNode]:
        """The node and all below, parents first."""
        stack = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children))


@dataclass(frozen=True, slots=True)
class Tree:
    """A tree with its identifier and its root."""

    id: str
    root: TreeNode
    source: Source


@dataclass(frozen=True, slots=True)
class Forest:
    """All trees of a file and of those that it includes.

    Args:
        trees: By identifier.
        main: The one that is executed.
        categories: What ``TreeNodesModel`` says of registered names.
    """

    trees: dict[str, Tree]
    main: Tree
    categories: dict[str, str] = field(default_factory=dict)
