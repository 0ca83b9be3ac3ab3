"""A behaviour tree as its file says it: nodes with their ports, and the attributes that any may have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mcpn.errors import Source

PRECONDITIONS = ("_failureIf", "_successIf", "_skipIf", "_while")
"""Attributes that may decide what a node returns without its being ticked, in the order of evaluation."""
POSTCONDITIONS = ("_onSuccess", "_onFailure", "_onHalted", "_post")
"""Attributes that write the blackboard, which is not modelled."""
OF_EDITORS = ("_description", "_fullpath", "_uid", "_collapsed")
"""Attributes that editors write, and no library reads."""
OF_SUBTREES = ("_autoremap", "__autoremap", "__shared_blackboard")
"""Attributes of uses of trees that say which data they share."""
ATTRIBUTES = (*PRECONDITIONS, *POSTCONDITIONS, *OF_EDITORS, *OF_SUBTREES)
"""Attributes of nodes that are no ports. Others that begin with ``_`` libraries ignore: a warning says so."""


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
