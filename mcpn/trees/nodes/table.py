"""The table of nodes: by library and versions, ports with their defaults, outcomes, and what is exact.

A row says what a node is from one version of its library to another. Sources, read for what nodes do when
they are ticked, of which nothing is copied: BehaviorTree.CPP 4.10.0, its changelog, and the headers of 3.5;
Nav2's plugins of 1.1, 1.4.2, 1.5.0, 1.5.1 (``nav2_behavior_tree``; ``wrap_around`` is of its pull request
5308); py_trees 2.6.0 (``parsers/behaviour_tree_xml.py``, ``composites.py``, ``decorators.py``).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from mcpn.trees.nodes.btcpp import BTCPP_ROWS
from mcpn.trees.nodes.others import OTHER_ROWS
from mcpn.trees.nodes.row import NodeRow
from mcpn.trees.nodes.versions import PY_TREES

TABLE = (*BTCPP_ROWS, *OTHER_ROWS)
"""All rows, by library."""


def _by_name() -> Mapping[tuple[str, str], tuple[NodeRow, ...]]:
    found: dict[tuple[str, str], list[NodeRow]] = {}
    for row in TABLE:
        found.setdefault((row.library, row.node.lower() if row.library == PY_TREES else row.node), []).append(
            row
        )
    return MappingProxyType({key: tuple(rows) for key, rows in found.items()})


BY_NAME = _by_name()
"""Rows by library and name; py_trees does not tell small letters from capitals."""


def rows_of(node: str, libraries: Iterable[str]) -> tuple[NodeRow, ...]:
    """All rows of a name in some libraries."""
    keys = ((library, node.lower() if library == PY_TREES else node) for library in libraries)
    return tuple(row for key in keys for row in BY_NAME.get(key, ()))
