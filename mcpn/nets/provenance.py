"""Provenance: which element of what a net was composed from made a place, and what part that has in it.

What knows nets alone asks for the part: the kinds of elements are said here and nowhere else in it.
"""

from __future__ import annotations

from dataclasses import field
from typing import Literal, TypeAlias

from mcpn.errors import Source
from mcpn.records import record

COMPLEMENT = "complement"
"""The kind of element that makes the complement of a place."""

Part: TypeAlias = Literal["whole", "block", "step", "worker", "resource"]
"""What an element is to others: steps in blocks of the whole start workers, which use resources."""

PARTS: dict[str, Part] = {
    "mission": "whole",
    "parallel": "block",
    "objective": "step",
    "activity": "worker",
    "hardware": "resource",
}
CONTROL: frozenset[Part | None] = frozenset({"whole", "block", "step"})
"""Parts that say what runs next."""


@record(frozen=True, slots=True)
class Provenance:
    """The element that made a place or a transition.

    Args:
        kind: ``hardware``, ``software``, ``activity``, ``alternative``, ``objective``, ``parallel``,
            ``fact``, ``once`` (a handler that happens once), ``exit`` (of a part) or ``mission``;
            ``complement``, of a place, which stands for inhibitor arcs.
        name: The element's name, qualified where a use of a protocol qualifies it.
        source: Its file and line, if it has any.
    """

    kind: str
    name: str
    source: Source | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return f"{self.kind} {self.name}"

    @property
    def part(self) -> Part | None:
        """What part the element has, where orders of places ask for it."""
        return PARTS.get(self.kind)
