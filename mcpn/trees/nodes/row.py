"""A row of the table of nodes: what a node is from one version of its library to another, with its ports."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

from mcpn.trees.nodes.versions import between, told

ANY = 200_000
"""As many children as a tree may have."""
ONE, NONE, SOME = (1, 1), (0, 0), (1, ANY)


class Port(NamedTuple):
    """A port of a node.

    Args:
        name: Its name.
        kind: The values that it takes, by :data:`LEGAL`.
        default: What holds where a tree does not give it; ``None`` where it must.
    """

    name: str
    kind: str
    default: str | None

    def __str__(self) -> str:
        given = (
            "required" if self.default is None else (self.default and f"default {self.default}") or "optional"
        )
        return f"{self.name} ({self.kind}, {given})"


_NUMBER = r"-?(\d++(\.\d*+)?|\.\d++)([eE][+-]?\d++)?"
_TRUTH = r"(true|TRUE|True|false|FALSE|False|0|1)"
LEGAL = MappingProxyType(
    {
        "int": (r"-?\d{1,9}", "a whole number"),
        "unsigned": (r"\d{1,9}", "a whole number, not below 0"),
        "bool": (_TRUTH, "true or false"),
        "number": (_NUMBER, "a number"),
        "status": (r"(SUCCESS|FAILURE|SKIPPED)", "SUCCESS, FAILURE or SKIPPED"),
        "policy": (r"success_on_(all|one|selected)", "success_on_all, success_on_one or success_on_selected"),
        "ints": (r"json:.*|-?\d{1,9}(;-?\d{1,9})*+|", "whole numbers, with ; between them"),
        "bools": (rf"json:.*|{_TRUTH}(;{_TRUTH})*+|", "true or false, with ; between them"),
        "numbers": (rf"json:.*|{_NUMBER}(;{_NUMBER})*+|", "numbers, with ; between them"),
        "text": (r"(?s:.*+)", "a text"),
    }
)
"""By kind of port, the literal values that it takes, and what they are called. ``{entry}`` fits all."""


@dataclass(frozen=True)
class NodeRow:
    """What a node is in some versions of a library.

    Args:
        node: The name under which it is registered.
        library: The library.
        versions: The versions.
        role: Control, Decorator, Action or Condition.
        children: The least and the largest number of its children.
        ports: Its ports; ``None`` where they are not checked, since no answer depends on them.
        rule: How it is translated: a name that the translator knows.
        outcome: What it returns, in words.
        exact: How faithful the translation is, in words.
    """

    node: str
    library: str
    versions: frozenset[str]
    role: str
    children: tuple[int, int]
    ports: Mapping[str, Port] | None
    rule: str
    outcome: str
    exact: str

    @cached_property
    def required(self) -> frozenset[str]:
        """Ports without a default."""
        return frozenset(port.name for port in (self.ports or {}).values() if port.default is None)

    def fits(self, given: Iterable[str]) -> bool:
        """Whether it has all ports that are given, and those are given that it needs."""
        return self.ports is None or (self.required <= set(given) <= set(self.ports))

    @property
    def where(self) -> str:
        """The library and its versions, as people read them."""
        return told(self.library, self.versions)


def _ports(text: str) -> Mapping[str, Port]:
    """Ports as rows say them: ``name:kind``, ``name:kind=default``, ``name:kind?`` for one that may lack."""
    found = {}
    for each in text.split():
        name, kind, mark, default = re.fullmatch(r"(\w+):(\w+)(\?|=)?(.*)", each).groups()  # type: ignore[union-attr]
        found[name] = Port(name, kind, default if mark else None)
    return MappingProxyType(found)


class NodeRows:
    """Rows of one library, by name."""

    def __init__(self, library: str) -> None:
        self.library = library
        self.rows: list[NodeRow] = []

    def add(
        self,
        names: str,
        versions: str,
        role: str,
        ports: str | None,
        rule: str,
        outcome: str,
        exact: str = "exact",
        children: tuple[int, int] | None = None,
    ) -> None:
        """Adds a row for each of some names, from one version to another (``4.2``, ``3.0-3.5``)."""
        first, _, last = versions.partition("-")
        span = between(self.library, first, last or "")
        usual = {"Control": SOME, "Decorator": ONE}.get(role, NONE)
        given = None if ports is None else _ports(ports)
        for name in names.split():
            self.rows.append(
                NodeRow(
                    node=name,
                    library=self.library,
                    versions=span,
                    role=role,
                    children=children or usual,
                    ports=given,
                    rule=rule,
                    outcome=outcome,
                    exact=exact,
                )
            )
