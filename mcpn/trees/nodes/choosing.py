"""Which versions of which libraries a tree is for: by what is asked, what its file says, nodes and ports."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from mcpn.errors import Problem
from mcpn.trees.nodes.node import PRECONDITIONS, TreeNode
from mcpn.trees.nodes.row import LEGAL, NodeRow
from mcpn.trees.nodes.table import TABLE, rows_of
from mcpn.trees.nodes.versions import (
    BTCPP,
    NAMES,
    NAV2,
    PLANSYS2,
    PY_TREES,
    VERSIONS,
    Allowed,
    between,
    built_together,
    told,
)

DIALECTS = ((BTCPP, NAV2, PLANSYS2), (PY_TREES,))
"""Libraries whose nodes may stand in one tree."""
_SIGNS = {"sequence": "memory", "fallback": "memory", "selector": "memory", "parallel": "policy"}
"""Ports of py_trees by node: who uses one of them writes for it."""
MOST_REASONS = 3


@dataclass(frozen=True)
class VersionChoice:
    """The libraries and versions as which a tree is read.

    Args:
        libraries: Those whose nodes may stand in it.
        allowed: By library, the versions that are left.
        used: Libraries whose nodes it uses, or that were asked for.
        why: By library, what has decided.
    """

    libraries: tuple[str, ...]
    allowed: Mapping[str, frozenset[str]]
    used: tuple[str, ...] = ()
    why: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def rows(self, node: TreeNode) -> tuple[NodeRow, ...]:
        """What a node may be in the versions that are left, the oldest first."""
        rows = rows_of(node.id, self.libraries)
        return tuple(r for r in rows if r.versions & self.allowed[r.library] and r.fits(node.ports))

    def row(self, node: TreeNode) -> NodeRow | None:
        """The newest of them, or ``None`` for a node that no library has."""
        return next(reversed(self.rows(node)), None)

    def value(self, node: TreeNode, port: str) -> str:
        """What a tree gives for a port, or what holds by default; empty where there is neither."""
        row = self.row(node)
        known = None if row is None or row.ports is None else row.ports.get(port)
        return node.ports.get(port, known.default or "" if known else "")

    def __str__(self) -> str:
        said = []
        for library in self.used:
            reasons = self.why.get(library, ())
            more = f", {len(reasons) - MOST_REASONS} more" if len(reasons) > MOST_REASONS else ""
            why = f" ({', '.join(reasons[:MOST_REASONS])}{more})" if reasons else ""
            said.append(told(library, self.allowed[library]) + why)
        return "; ".join(said)


def choose(
    nodes: Iterable[TreeNode], trees: frozenset[str], formats: Iterable[str | None], asked: Allowed
) -> tuple[VersionChoice, list[Problem]]:
    """Chooses versions, and checks the nodes that libraries have against them.

    Args:
        nodes: All nodes of all trees.
        trees: The names of trees: a leaf of such a name is a use of it.
        formats: What the files say of their format: 3, 4 or nothing.
        asked: Versions that were asked for.

    Returns:
        The choice, and what is wrong: ports that no version has, and those that no one version has together.
    """
    return _Choosing(list(nodes), trees, formats, asked).chosen()


class _Choosing:
    def __init__(
        self, nodes: list[TreeNode], trees: frozenset[str], formats: Iterable[str | None], asked: Allowed
    ) -> None:
        self.nodes = [n for n in nodes if n.category != "SubTree" and not (n.id in trees and not n.children)]
        self.said = sorted({each for each in formats if each is not None})
        self.asked = asked
        own = PY_TREES in asked or (not self.said and any(map(_for_py_trees, self.nodes)))
        self.libraries = DIALECTS[own]
        self.allowed: Allowed = {library: between(library) for library in self.libraries}
        self.why: dict[str, list[str]] = {library: [] for library in self.libraries}
        self.used: list[str] = [library for library in self.libraries if library in asked]
        self.problems: list[Problem] = []

    def chosen(self) -> tuple[VersionChoice, list[Problem]]:
        for library, versions in self.asked.items():
            if library in self.allowed:
                self.allowed[library] &= versions
                self.why[library].append("asked for")
        if self.said and BTCPP in self.allowed:
            majors = tuple(f"{each}." for each in self.said)
            self.narrow(
                BTCPP,
                frozenset(v for v in VERSIONS[BTCPP] if v.startswith(majors)),
                f"BTCPP_format {' and '.join(self.said)}",
            )
        self.allowed = self.together()
        for node in self.nodes:
            self.take(node)
        self.allowed = self.together()
        if BTCPP in self.libraries and BTCPP not in self.used:
            self.used.insert(0, BTCPP)
        for node in self.nodes:
            self.problems += [*_counted(node, self.libraries), *self.values(node)]
        why = {library: tuple(dict.fromkeys(reasons)) for library, reasons in self.why.items()}
        return VersionChoice(self.libraries, self.allowed, tuple(self.used), why), self.problems

    def together(self) -> Allowed:
        """Versions without those that are built on others, where both libraries are used."""
        if NAV2 not in self.used:
            return self.allowed
        return built_together(self.allowed)

    def narrow(self, library: str, versions: frozenset[str], why: str) -> bool:
        """Keeps some versions of a library; whether any is left."""
        left = self.allowed[library] & versions
        if not left:
            return False
        if left != self.allowed[library]:
            self.why[library].append(why)
        self.allowed[library] = left
        return True

    def take(self, node: TreeNode) -> None:
        """Narrows versions to those that have a node with its ports, or says why there are none."""
        rules = [rule for rule in PRECONDITIONS if rule in node.rules]
        since = between(BTCPP, "4.0")
        if rules and not (BTCPP in self.allowed and self.narrow(BTCPP, since, rules[0])):
            library = BTCPP if BTCPP in self.allowed else PY_TREES
            said = f"{node.title} has {rules[0]} of BehaviorTree.CPP 4"
            self.wrong(node, f"{said}, the tree is for {self.is_for(library)}")
        rows = rows_of(node.id, self.libraries)
        if not rows:
            self.of_other(node)
            return
        for library in dict.fromkeys(row.library for row in rows):
            if library not in self.used:
                self.used.append(library)
                self.allowed = self.together()
        fitting = [row for row in rows if row.fits(node.ports)]
        if not fitting:
            self.wrong(node, self.why_none_fits(node, rows))
            return
        library = fitting[0].library
        versions = frozenset[str]().union(*(row.versions for row in fitting))
        ports = " ".join(
            port
            for port in node.ports
            if not all(row.ports is not None and port in row.ports for row in rows)
        )
        why = (
            f"{ports} of {node.id}, line {node.source.line}"
            if ports
            else f"{node.id}, line {node.source.line}"
        )
        if not self.narrow(library, versions, why):
            what = f"{ports} of {node.id} is a port" if ports else f"{node.id} is a node"
            there = told(library, versions)
            here = {port for row in rows if row.versions & self.allowed[library] for port in row.ports or ()}
            has = f": there it has {', '.join(sorted(here))}" if ports and here else ""
            self.wrong(node, f"{what} of {there}, and this tree is for {self.is_for(library)}{has}")

    def of_other(self, node: TreeNode) -> None:
        """Refuses a node that py_trees does not have and others do: what it does there is not known."""
        elsewhere = [row for row in TABLE if row.node == node.id and row.role in ("Control", "Decorator")]
        if PY_TREES in self.libraries and elsewhere and node.children:
            there, here = elsewhere[-1].where, self.is_for(PY_TREES)
            self.wrong(node, f"{node.id} is a node of {there}, and this tree is for {here}")

    def is_for(self, library: str) -> str:
        """The versions that are left, with what has decided."""
        why = ", ".join(self.why[library][:MOST_REASONS])
        return told(library, self.allowed[library]) + (f" ({why})" if why else "")

    def why_none_fits(self, node: TreeNode, rows: tuple[NodeRow, ...]) -> str:
        """Why no version has a node with these ports."""
        known = {port for row in rows for port in row.ports or {}}
        for port in node.ports:
            if port in known:
                continue
            elsewhere = [
                row
                for row in TABLE
                if row.node.lower() == node.id.lower() and row.ports and port in row.ports and row not in rows
            ]
            expected = f"expected {', '.join(sorted(known))}" if known else "it has none"
            other = (
                f"; it is one of {elsewhere[0].where}: --library {elsewhere[0].library}" if elsewhere else ""
            )
            return f"{node.title} has no port {port!r}, {expected}{other}"
        least = min(
            rows,
            key=lambda row: (
                len(set(node.ports) - set(row.ports or ())),
                len(row.required - set(node.ports)),
            ),
        )
        missing = sorted(least.required - set(node.ports))
        if set(node.ports) <= set(least.ports or ()):
            return f"{node.title} lacks {' and '.join(missing)}, which {least.where} requires"
        apart = "; ".join(f"{', '.join(row.ports or ())}: {row.where}" for row in rows)
        return f"{node.title} has ports of different versions ({apart})"

    def values(self, node: TreeNode) -> Iterator[Problem]:
        """Literal values that a port does not take."""
        row = next((r for r in reversed(rows_of(node.id, self.libraries)) if r.fits(node.ports)), None)
        for name, value in node.ports.items() if row is not None and row.ports is not None else ():
            pattern, expected = LEGAL[row.ports[name].kind]  # type: ignore[union-attr, index]
            if not is_entry(value) and re.fullmatch(pattern, value) is None:
                yield Problem(node.source, f"{node.title}: {name} is {value!r}, expected {expected}")

    def wrong(self, node: TreeNode, message: str) -> None:
        self.problems.append(Problem(node.source, message))


def _for_py_trees(node: TreeNode) -> bool:
    sign = _SIGNS.get(node.id.lower())
    return bool(node.children) and (node.id.lower() == "selector" or sign in node.ports)


def is_entry(value: str) -> bool:
    """Whether a value names an entry of the blackboard."""
    text = value.strip()
    return text.startswith(("{", "${")) and text.endswith("}")


def _counted(node: TreeNode, libraries: tuple[str, ...]) -> Iterator[Problem]:
    """What is wrong with the number of children of a node."""
    rows = rows_of(node.id, libraries)
    by_category = {"Decorator": (1, 1), "Action": (0, 0), "Condition": (0, 0)}
    least, most = rows[0].children if rows else by_category.get(node.category, (0, len(node.children)))
    if not least <= len(node.children) <= most:
        wanted = str(least) if least == most else f"{least} to {most}" if most < 10 else f"at least {least}"
        yield Problem(node.source, f"{node.title} has {len(node.children)} children, expected {wanted}")


__all__ = ["NAMES", "VersionChoice", "choose"]
