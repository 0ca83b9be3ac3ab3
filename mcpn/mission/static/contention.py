"""Rivals: activities that may want what serves one at a time at the same moment, and the warnings of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from mcpn.errors import Problem, Source
from mcpn.mission.core.copies import grouped
from mcpn.mission.core.objectives_graph import ObjectivesGraph


class Contention(NamedTuple):
    """Two rivals that may run together and both need one resource or activity that serves one at a time.

    Args:
        wanted: An exclusive resource, or ``activity NAME``.
        rivals: Two activities that consume the resource, or two branches that start the activity; sorted.
        context: Where they run together, in words ("parallel block census").
        source: The line of that context.
    """

    wanted: str
    rivals: tuple[str, str]
    context: str
    source: Source | None = None

    def __str__(self) -> str:
        first, second = self.rivals
        return f"{first} and {second}, both in {self.context}, both need {self.wanted}"

    @property
    def where(self) -> tuple[str, str]:
        """What sort of thing the context is, and its name."""
        kind, _, name = self.context.rpartition(" ")
        return kind, name

    @property
    def of_branches(self) -> bool:
        """Whether the rivals are branches, not activities."""
        return self.wanted.startswith("activity ")


def contention_warnings(contentions: Iterable[Contention], graph: ObjectivesGraph) -> Iterator[Problem]:
    """One warning for each pair of rivals, however many copies of a block are their context.

    Args:
        contentions: Those of the mission.
        graph: Its objectives graph.
    """
    copies = graph.copies

    def alike(one: Contention) -> object:
        kind, name = one.where
        rivals = tuple(map(copies.written, one.rivals)) if one.of_branches else one.rivals
        return one.wanted, rivals, kind, name if kind == "activity" else copies.written(name)

    for one, *others in grouped(contentions, alike).values():
        if others:
            (kind, _), names = one.where, [each.where[1] for each in (one, *others)]
            context, _ = copies.subject(kind, names, [section.name for section in graph.all_sections()])
            rivals = one.rivals
            if one.of_branches:
                rivals = copies.written(rivals[0])[1], copies.written(rivals[1])[1]
            one = one._replace(rivals=rivals, context=context)
        yield Problem(one.source, str(one))
