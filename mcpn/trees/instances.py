"""The nodes of a tree as BehaviorTree.CPP makes them: subtrees written out, each node with its path.

A substitution rule of the library is for the nodes whose name or registered name it says, or whose path
matches it. The path of a node is its name behind the names of the subtrees around it; a node without a name
of its own has its registered name and a number, in the order in which nodes are made.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from mcpn.errors import InputError
from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.reading import MAX_NODES
from mcpn.trees.translator import RUNNING_ON

Place = tuple[int, ...]
"""A node by what leads to it: the nodes that use trees around it, the outermost first, and itself."""
ASKING = frozenset({"reactive_sequence", "reactive_fallback", "while_do_else", "pipeline"})
"""Rules of nodes that tick earlier children again while a later one runs."""
TOGETHER = frozenset({"parallel", "parallel_all", "parallel_by_policy", "pipeline"})
"""Rules of nodes of which several children run at the same time."""
NOT_RESETTING = frozenset({"while_do_else", "pipeline"})
"""Those of them that do not reset a child that has answered before they tick it again."""


@dataclass(frozen=True, slots=True)
class Instance:
    """A leaf of the tree as it is executed.

    Args:
        node: The node, as it is written.
        place: Where it is.
        path: Its path in the library.
        asked: Whether it is ticked again after it has answered, while something behind it runs.
        kept: Whether the library keeps its answer then: a node that is not reset is not asked anew.
        rounds: Whether a node around it returns between its rounds or children, and is ticked again then.
        beside: Whether something may run at the same time as it does.
    """

    node: TreeNode
    place: Place
    path: str
    asked: bool
    kept: bool
    rounds: bool = False
    beside: bool = False


def place_of(chain: tuple[TreeNode, ...], leaf: TreeNode) -> Place:
    """The place of a leaf behind nodes that use trees."""
    return tuple(id(node) for node in (*chain, leaf))


def instances(forest: Forest) -> list[Instance]:
    """The leaves of the tree that is executed, in the order of the library; none that always answer the same.

    Raises:
        InputError: With its subtrees written out it has too many nodes.
    """
    return list(_Expansion(forest).leaves(forest.main.root, (), "", _Around()))


class _Around(NamedTuple):
    """What is so of all leaves in a node: as of :class:`Instance`."""

    asked: bool = False
    kept: bool = False
    rounds: bool = False
    beside: bool = False


class _Expansion:
    def __init__(self, forest: Forest) -> None:
        self.forest = forest
        self.made = 0

    def leaves(self, node: TreeNode, around: Place, prefix: str, at: _Around) -> Iterator[Instance]:
        self.made += 1
        if self.made > MAX_NODES:
            raise InputError.at(
                node.source, f"with subtrees written out there are more than {MAX_NODES} nodes"
            )
        path = prefix + (node.name if node.name not in (None, node.id) else f"{node.id}::{self.made}")
        place = (*around, id(node))
        rule = self.forest.rule(node)
        if (tree := tree_of(self.forest, node)) is not None:
            inner = f"{prefix}{node.name or f'{node.id}::{self.made}'}/"
            yield from self.leaves(tree.root, place, inner, at)
        elif not node.children and rule not in ("succeeds", "fails"):
            yield Instance(node, place, path, *at)
        beside = at.beside or rule in TOGETHER
        turns = at.rounds or (at.asked and rule in RUNNING_ON)
        for number, child in enumerate(node.children):
            earlier = number + 1 < len(node.children) if rule != "while_do_else" else number == 0
            again = rule in ASKING and earlier
            kept = again and rule in NOT_RESETTING
            yield from self.leaves(child, around, prefix, _Around(at.asked or again, kept, turns, beside))


def filters(forest: Forest, found: list[Instance]) -> dict[Place, str]:
    """By leaf, the filter of a substitution rule that is for it; none where there is none.

    A path without a number may be the name of another node, too: its first letter is left open then, which no
    name is. Leaves of one path are told apart by their registered names, where these are theirs alone; where
    never two of them run at once, and none is asked again, one rule is for all of them, each in its turn.
    """
    paths = Counter(each.path for each in found)
    names = Counter(n.name for each in found if (n := each.node).name)
    nodes = [node for tree in forest.trees.values() for node in tree.root.walk()]
    ids, registered = {node.id for node in nodes}, Counter(each.node.id for each in found)
    taken = {*paths, *(node.name for node in nodes if node.name)}
    chosen: dict[Place, str] = {}
    for each in found:
        path, id_ = each.path, each.node.id
        alone = registered[id_] == 1 and id_ not in taken
        if "*" in path or "?" in path:
            continue
        if paths[path] > 1 and alone:
            chosen[each.place] = id_
        elif paths[path] > 1 and any(o.beside or o.asked for o in found if o.path == path):
            continue
        elif ((names[path] > 1 and paths[path] == 1) or path in ids) and "::" not in path:
            opened = f"?{path[1:]}"
            if not any(other != path and other[1:] == path[1:] and other for other in paths):
                chosen[each.place] = opened
        else:
            chosen[each.place] = path
    # A rule for all leaves of a path would be for those, too, that have one of their own.
    own = {each.path for each in found if paths[each.path] > 1 and chosen.get(each.place) == each.node.id}
    return {place: rule for place, rule in chosen.items() if rule not in own}
