"""Who changes and who reads which fact: static knowledge of a mission's facts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property

from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, Section
from mcpn.mission.fact_conditions import Condition, all_flags, flags, resolved
from mcpn.mission.model import Mission, walk
from mcpn.mission.robot import Fact


class FactUsage:
    """Who changes and who reads which fact.

    Args:
        core: The core mission.

    Attributes:
        facts: Its facts by name, those of objectives that something reads among them.
        changing: By declared event that changes facts, for each of them by value the one that it has then.
    """

    def __init__(self, core: Mission) -> None:
        self.core = core
        self.facts: Mapping[str, Fact] = {fact.name: fact for fact in core.every_fact}
        self.changing: Mapping[str, Mapping[str, Mapping[str, str]]] = {
            event.name: {
                change.fact: dict.fromkeys(self.facts[change.fact].values, change.to) for change in event.sets
            }
            for event in core.events
            if event.changes_facts
        }

    @cached_property
    def turning(self) -> Mapping[str, tuple[frozenset[str], frozenset[str]]]:
        """By declared event that changes facts, the flags (:func:`flags`) that it makes true, and false."""
        found = {}
        for event, changes in self.changing.items():
            every = frozenset(flag for fact in changes for flag in all_flags(self.facts[fact]))
            values = ((self.facts[fact], value) for fact, to in changes.items() for value in {*to.values()})
            true = frozenset(flag for fact, value in values for flag in flags(fact)[value])
            found[event] = true, every - true
        return found

    @cached_property
    def watched(self) -> frozenset[tuple[str, str]]:
        """Values of facts that blocks may be left for, when facts become so."""
        texts = (self.core.blocks, *(protocol.blocks for protocol in self.core.protocols))
        every = (handler.when for blocks in texts for block in walk(blocks) for handler in block.handlers)
        return frozenset(said for when in every for said in resolved(when, self.facts))

    @cached_property
    def _requires(self) -> Mapping[tuple[str, int], Condition]:
        return {
            (activity.name, i): resolved((*activity.requires, *way.requires), self.facts)
            for activity in self.core.activities
            for i, way in enumerate(activity.alternatives)
            if activity.requires or way.requires
        }

    def requires(self, activity: str, alternative: int) -> Condition:
        """What facts must be for an alternative to be possible, its activity's own condition included."""
        return self._requires.get((activity, alternative), ())

    def read_by(self, activity: str) -> Iterator[str]:
        """Facts that some alternative of an activity requires to be so."""
        if self._requires:
            alternatives = next(a.alternatives for a in self.core.activities if a.name == activity)
            for i in range(len(alternatives)):
                yield from (fact for fact, _ in self.requires(activity, i))

    @cached_property
    def requiring(self) -> frozenset[str]:
        """Activities with an alternative that requires facts to be so."""
        return frozenset(activity for activity, _ in self._requires)

    def closed(self, names: Iterable[str]) -> tuple[Fact, ...]:
        """Some facts, and all facts that events change together with them, in the order of the search."""
        found, stack = dict[str, None](), [*names][::-1]
        while stack:
            name = stack.pop()
            if name not in found:
                found[name] = None
                together = (facts for facts in self.changing.values() if name in facts)
                stack.extend(other for facts in together for other in facts)
        return tuple(self.facts[name] for name in found)


def touched_by(graph: ObjectivesGraph) -> Iterator[str]:
    """Facts that the sections of a graph change or read by themselves, at any depth, in their order."""
    for section in graph.all_sections():
        yield from _of_section(section)


def _of_section(section: Section) -> Iterator[str]:
    if isinstance(section, ElementarySection):
        yield from (setting.fact for setting in section.sets)
    for case in section.all_cases:
        yield from (fact for fact, _ in case.when)
