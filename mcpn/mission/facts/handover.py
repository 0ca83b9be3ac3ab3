"""From one objective to the next: what the next one waits for before it begins.

An event that ends an objective stops its activities, and they release what they hold; that wave passes while
the next objective already begins. The two do not compete where the wave only gives back: what is asked for
is waited for until it is available. They may compete in some cases, and there the next is entered only
when the activities before it are *idle* and what they produced is gone: where an activity may still be
evaluating when its objective ends, because it was found waiting for another's release, or because it
evaluates again when a consumer leaves; where both need a producer that serves several interfaces, so that one
is released while another is asked for; and where an activity is started again at once. The argument stands in
``papers/composition.md``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from mcpn.mission.flatten import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED

if TYPE_CHECKING:
    from mcpn.mission.facts.usage import Usage


@dataclass(frozen=True, slots=True)
class Awaited:
    """What a section waits for at its entry, in document order.

    Args:
        activities: Activities that must be idle: those that objectives start, and producers of several
            or shared resources, which may still be refusing when all of these are back.
        interfaces: Software resources that must be available, nobody asks for them or holds them, each with
            the owner of the interface (``None`` where it has one for all).
    """

    activities: tuple[str, ...] = ()
    interfaces: tuple[tuple[str, str | None], ...] = ()


class Handover:
    """What must be over before a section begins.

    Args:
        usage: Static facts of the mission.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage

    @cached_property
    def with_idle(self) -> frozenset[str]:
        """Activities that need a place that says that they are idle.

        So it is where one edge of the objectives graph stops and starts the same activity (a retry, a
        protocol used twice in a row), where two branches of a parallel block start the same one, and where
        a section waits for the activity.
        """
        found = {a for awaited in self.awaited.values() for a in awaited.activities}
        for graph in self.usage.graphs():
            for section in graph.sections:
                for ending, target in _onward(graph, section):
                    found |= ending & {a for first in entries(target) for a in first.activities}
        return frozenset(found).union(activity for *_, activity in self.usage.started_twice())

    @cached_property
    def awaited(self) -> Mapping[str, Awaited]:
        """By section at any depth, what it waits for; sections that wait for nothing are left out.

        What a parallel branch beside the section may use is not waited for: it may be held for long.
        """
        usage = self.usage
        activities: dict[str, set[str]] = {}
        interfaces: dict[str, set[tuple[str, str | None]]] = {}
        for graph, beside in self._graphs():
            for section in graph.sections:
                for ending, target in _onward(graph, section):
                    before = self._reached(ending)
                    after = self._reached({a for first in entries(target) for a in first.activities})
                    if self._may_compete(before, after):
                        waits = activities.setdefault(target.name, set())
                        waits |= ending - beside
                        waits |= {a for a in before - beside if usage.sharing.serves(a)}
                        found = interfaces.setdefault(target.name, set())
                        found |= {
                            (s, owner)
                            for a in before
                            for s in usage.activities[a].produces
                            for owner in usage.sharing.owners(s)
                            if (a not in beside if owner is None else owner in before - beside)
                        }
        return {
            name: Awaited(
                tuple(a for a in usage.activities if a in waits),
                tuple((s, o) for s in usage.producer for o in usage.sharing.owners(s) if (s, o) in back),
            )
            for (name, waits), back in zip(activities.items(), interfaces.values(), strict=True)
            if waits or back
        }

    def _may_compete(self, before: frozenset[str], after: frozenset[str]) -> bool:
        """Whether what some activities do while they stop may compete with what others begin with."""
        usage = self.usage
        if any(usage.sharing.serves(a) for a in before & after):
            return True
        if not any(usage.may_wait(a) or usage.sharing.order_matters(a) for a in before):
            return False
        shared = usage.resources_of(before) & usage.resources_of(after)
        return bool(shared) or not before.isdisjoint(after)

    def _reached(self, activities: Iterable[str]) -> frozenset[str]:
        return frozenset[str]().union(*(self.usage.closure(a) for a in activities))

    def _graphs(self) -> Iterator[tuple[ObjectivesGraph, frozenset[str]]]:
        """Every graph with the activities that may run beside it, in other branches."""
        stack = [(self.usage.graph, frozenset[str]())]
        while stack:
            graph, beside = stack.pop()
            yield graph, beside
            for section in graph.sections:
                if isinstance(section, ParallelSection):
                    reached = [
                        self._reached({a for inner in branch.graph.walk() for a in inner.activities})
                        for branch in section.branches
                    ]
                    for i, branch in enumerate(section.branches):
                        others = beside.union(*(r for j, r in enumerate(reached) if j != i))
                        stack.append((branch.graph, others))


def entries(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that start when a section is entered."""
    if isinstance(section, ElementarySection):
        return (section,)
    return tuple(
        first for branch in section.branches for first in entries(branch.graph.section(branch.graph.entry))
    )


def _onward(graph: ObjectivesGraph, section: Section) -> Iterator[tuple[frozenset[str], Section]]:
    """Sections that one leads to, each with the activities that may be stopped as it is entered.

    The end of a section stops its last objectives, an interruption all that run.
    """
    ending = frozenset(a for last in _endings(section) for a in last.activities)
    running = frozenset(a for inner in section.walk() for a in inner.activities)
    yield from ((ending, target) for target in graph.targets(section))
    yield from ((running, target) for target in graph.interrupted(section))


def _endings(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that may be the last of a section, of a branch for a parallel block."""
    if isinstance(section, ElementarySection):
        return (section,)
    return tuple(
        last
        for branch in section.branches
        for inner in branch.graph.sections
        if any(route in (SUCCEED, FAIL) for route in inner.routes)
        for last in _endings(inner)
    )
