"""Who uses what, together with whom: the static facts that the net's composition rests on.

Everything here is decided on the structure of the mission, before any marking is explored, and errs on the
side of *may*: what is called contended may be so in some run, what is not called so never is.

Words: a *demand* is one alternative of one activity with the resources that it consumes. Two demands are
*concurrent* where their activities may run together: in branches of one parallel block, in one objective, or
one inside the chain of resources that the other consumes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

from mcpn.errors import Source
from mcpn.mission.flatten import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import Activity, Hardware, Mission

Demand: TypeAlias = tuple[str, int]
"""An activity's name and the index of one of its alternatives, from 0."""

Needs: TypeAlias = dict[str, set[Demand]]
"""Demands by the resource that they consume."""


@dataclass(frozen=True, slots=True)
class Contention:
    """Two that may run together and both want one exclusive thing.

    Args:
        wanted: A resource, or an activity.
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


class Usage:
    """Static facts of a mission; computed once, read by templates, checks and the composition.

    Args:
        mission: A valid mission.
        graph: Its objectives graph.
    """

    def __init__(self, mission: Mission, graph: ObjectivesGraph) -> None:
        self.mission = mission
        self.graph = graph
        self.hardware: Mapping[str, Hardware] = {h.name: h for h in mission.hardware}
        self.activities: Mapping[str, Activity] = {a.name: a for a in mission.activities}
        self.producer: Mapping[str, str] = {s: a.name for a in mission.activities for s in a.produces}
        self._closures: dict[str, frozenset[str]] = {}
        self._hardware_under: dict[str, frozenset[str]] = {}
        self._needs: dict[str, Needs] = {}
        self._inner: dict[str, frozenset[tuple[str, Demand, Demand]]] = {}
        # Suppliers first: what follows asks only one step down a chain of activities, however long it is.
        for name in self.suppliers_first():
            self.closure(name)
            for resource in self.activities[name].produces:
                self.hardware_under(resource)
            self._inside(name)

    # --- what stands on what ---------------------------------------------------------------------------

    def suppliers(self, activity: str, alternative: int) -> list[str]:
        """The activities that produce what an alternative consumes, each once, in order of consumption."""
        consumed = self.activities[activity].alternatives[alternative].consumes
        return list(dict.fromkeys(self.producer[k] for k in consumed if k in self.producer))

    def suppliers_first(self) -> Iterator[str]:
        """Every activity after those that it may start through resources."""
        done: set[str] = set()
        for root in self.activities:
            stack = [root]
            while stack:
                name = stack[-1]
                alternatives = range(len(self.activities[name].alternatives))
                below = [p for i in alternatives for p in self.suppliers(name, i) if p not in done]
                stack.extend(below)
                if not below:
                    stack.pop()
                    if name not in done:
                        done.add(name)
                        yield name

    def closure(self, activity: str) -> frozenset[str]:
        """The activity with all that it may start, at any depth, through the resources that it consumes."""
        if activity not in self._closures:
            alternatives = range(len(self.activities[activity].alternatives))
            below = [self.closure(p) for i in alternatives for p in self.suppliers(activity, i)]
            self._closures[activity] = frozenset({activity}).union(*below)
        return self._closures[activity]

    @cached_property
    def started(self) -> tuple[str, ...]:
        """Activities that some objective starts, itself or through resources, in document order."""
        named = {a for section in self.graph.walk() for a in section.activities}
        reached = frozenset[str]().union(*(self.closure(a) for a in named))
        return tuple(a for a in self.activities if a in reached)

    def by_request(self, activity: str) -> bool:
        """Whether the activity is started by a request for what it produces, not by an objective."""
        return bool(self.activities[activity].produces)

    def hardware_under(self, resource: str) -> frozenset[str]:
        """The faulty hardware whose failure may end in an error of the resource, itself included."""
        if resource in self.hardware:
            return frozenset({resource}) if self.hardware[resource].faulty else frozenset()
        if resource not in self._hardware_under:
            activity = self.producer[resource]
            under = frozenset[str]()
            if self.refusable(activity):
                under = self._evaluated_after(activity)
            self._hardware_under[resource] = under
        return self._hardware_under[resource]

    def can_fail(self, resource: str) -> bool:
        """Whether the resource may ever answer with an error."""
        return bool(self.hardware_under(resource))

    def refusable(self, activity: str) -> bool:
        """Whether there may be no way to perform the activity: each alternative needs what can fail."""
        return all(
            any(self.can_fail(k) for k in alternative.consumes)
            for alternative in self.activities[activity].alternatives
        )

    def fail_together(self, activity: str, alternative: int) -> list[tuple[str, ...]]:
        """Sets of consumed resources that one hardware failure may put in error in one internal run.

        Returns:
            Every non-empty set, in order of size, then of consumption.
        """
        consumed = self.activities[activity].alternatives[alternative].consumes
        groups = {
            tuple(k for k in consumed if h in self.hardware_under(k))
            for h in frozenset[str]().union(*(self.hardware_under(k) for k in consumed))
        }
        sets = {e for group in groups for size in range(1, len(group) + 1) for e in combinations(group, size)}
        return sorted(sets, key=lambda e: (len(e), [consumed.index(k) for k in e]))

    def released_unasked(self, resource: str) -> bool:
        """Whether the resource may be released while its producer, evaluating, still brings or takes it.

        So it is where some activity consumes it beside another that fails with what makes the producer
        evaluate again, and where the producer may have waited for another activity's release.
        """
        return resource in self._released_unasked or self.may_wait(self.producer[resource])

    @cached_property
    def _released_unasked(self) -> frozenset[str]:
        found: set[str] = set()
        for activity in self.started:
            for alternative in self.activities[activity].alternatives:
                for s in alternative.consumes:
                    if s in self.producer:
                        beside = (self.hardware_under(k) for k in alternative.consumes if k != s)
                        if self._evaluated_after(self.producer[s]) & frozenset[str]().union(*beside):
                            found.add(s)
        return frozenset(found)

    def _evaluated_after(self, activity: str) -> frozenset[str]:
        """The hardware whose failure may make the activity evaluate its alternatives again."""
        consumed = {k for alternative in self.activities[activity].alternatives for k in alternative.consumes}
        return frozenset[str]().union(*(self.hardware_under(k) for k in consumed))

    # --- who may run together --------------------------------------------------------------------------

    @cached_property
    def contentions(self) -> tuple[Contention, ...]:
        """Every contention, each pair of activities once per resource and context."""
        found: dict[Contention, None] = {}
        for resource, (a, _), (b, _), context, source in self._concurrent_demands():
            pair = (a, b) if a < b else (b, a)
            found.setdefault(Contention(resource, pair, context, source))
        for section, first, second, activity in self._started_twice():
            context = f"parallel block {section.name}"
            found.setdefault(Contention(f"activity {activity}", (first, second), context, section.source))
        return tuple(found)

    @cached_property
    def _contended(self) -> frozenset[Demand]:
        return frozenset(d for _, c, e, _, _ in self._concurrent_demands() for d in (c, e))

    @cached_property
    def contended_resources(self) -> frozenset[str]:
        """Resources that two activities may want at the same time."""
        return frozenset(resource for resource, *_ in self._concurrent_demands())

    def waits_for_release(self, activity: str, alternative: int) -> bool:
        """Whether the alternative may wait in its evaluation place until another activity releases."""
        return (activity, alternative) in self._contended

    def waits_for_answer(self, activity: str, alternative: int) -> bool:
        """Whether the alternative may wait, selected, because a producer that it asked waits itself."""
        return any(self.may_wait(p) for p in self.suppliers(activity, alternative))

    def may_wait(self, activity: str) -> bool:
        """Whether the activity may be neither running nor refused in a stable marking."""
        return activity in self._waiting

    @cached_property
    def _waiting(self) -> frozenset[str]:
        waiting: set[str] = set()
        for name in self.suppliers_first():
            for i in range(len(self.activities[name].alternatives)):
                below = self.suppliers(name, i)
                if self.waits_for_release(name, i) or not waiting.isdisjoint(below):
                    waiting.add(name)
        return frozenset(waiting)

    def _concurrent_demands(self) -> Iterator[tuple[str, Demand, Demand, str, Source | None]]:
        yield from self._graph_demands(self.graph)

    def _graph_demands(
        self, graph: ObjectivesGraph
    ) -> Iterator[tuple[str, Demand, Demand, str, Source | None]]:
        for section in graph.sections:
            if isinstance(section, ElementarySection):
                context = f"objective {section.name}"
                for activity in section.activities:
                    for resource, c, d in self._inside(activity):
                        yield resource, c, d, f"activity {activity}", self.activities[activity].source
                for a, b in combinations(section.activities, 2):
                    for resource, c, d in _both(self._tree_needs(a), self._tree_needs(b)):
                        yield resource, c, d, context, section.source
            else:
                context = f"parallel block {section.name}"
                needs = [self._graph_needs(branch.graph) for branch in section.branches]
                for first, second in combinations(needs, 2):
                    for resource, c, d in _both(first, second):
                        yield resource, c, d, context, section.source
                for branch in section.branches:
                    yield from self._graph_demands(branch.graph)

    def _inside(self, activity: str) -> frozenset[tuple[str, Demand, Demand]]:
        """Concurrent demands for one resource within the chain under one running activity."""
        if activity not in self._inner:
            found: set[tuple[str, Demand, Demand]] = set()
            for i, alternative in enumerate(self.activities[activity].alternatives):
                own: Needs = {k: {(activity, i)} for k in alternative.consumes}
                below = self.suppliers(activity, i)
                for p in below:
                    found |= self._inside(p)
                    found.update(_both(own, self._tree_needs(p)))
                for p, q in combinations(below, 2):
                    found.update(_both(self._tree_needs(p), self._tree_needs(q)))
            self._inner[activity] = frozenset(found)
        return self._inner[activity]

    def _tree_needs(self, activity: str) -> Needs:
        if activity not in self._needs:
            self._needs[activity] = _merge(
                {k: {(a, i)} for k in alternative.consumes}
                for a in self.closure(activity)
                for i, alternative in enumerate(self.activities[a].alternatives)
            )
        return self._needs[activity]

    def _graph_needs(self, graph: ObjectivesGraph) -> Needs:
        return _merge(self._tree_needs(a) for section in graph.walk() for a in section.activities)

    # --- what follows what at once ---------------------------------------------------------------------

    @cached_property
    def restarted(self) -> frozenset[str]:
        """Activities that an objective may start while their last stop is still on its way.

        So it is where one edge of the objectives graph stops and starts the same activity (a retry, a
        protocol used twice in a row), and where two branches of a parallel block start the same one.
        """
        found: set[str] = set()
        for graph in self._graphs():
            for section in graph.sections:
                ending = {a for last in _endings(section) for a in last.activities}
                for target in graph.targets(section):
                    found |= ending & {a for first in entries(target) for a in first.activities}
        return frozenset(found).union(activity for *_, activity in self._started_twice())

    @cached_property
    def exchanges(self) -> tuple[Contention, ...]:
        """Producers of several resources of which one may be released as another is asked for.

        Whether the producer then goes on, or stops and evaluates its alternatives anew, depends on which
        comes first. With one alternative, or where each consumer takes all its resources, it makes no
        difference.
        """
        found = []
        for name in self.started:
            activity = self.activities[name]
            takers = {
                (a, i): consumed
                for a in self.started
                for i, alternative in enumerate(self.activities[a].alternatives)
                if (consumed := frozenset(alternative.consumes) & frozenset(activity.produces))
            }
            if len(activity.alternatives) > 1 and len(set(takers.values())) > 1:
                one, other = sorted({s for consumed in takers.values() for s in consumed})[:2]
                found.append(Contention(f"activity {name}", (one, other), "its resources", activity.source))
        return tuple(found)

    def _started_twice(self) -> Iterator[tuple[ParallelSection, str, str, str]]:
        """Parallel blocks of which two branches start the same activity: block, branches, activity."""
        for graph in self._graphs():
            for section in graph.sections:
                if isinstance(section, ParallelSection):
                    for first, second in combinations(section.branches, 2):
                        shared = _named(first.graph) & _named(second.graph)
                        for activity in sorted(shared):
                            yield section, first.name, second.name, activity

    @cached_property
    def settled_before(self) -> Mapping[str, tuple[str, ...]]:
        """Software resources that must be back before an objective is entered.

        Two consumers of a producer that serves several resources may stop at the same moment; whether the
        producer stops with them must not depend on how quickly the next objective asks again.

        Returns:
            Qualified name of an elementary objective to the resources to be awaited, in document order.
        """
        awaited: dict[str, set[str]] = {}
        for graph in self._graphs():
            for section in graph.sections:
                released = self._released_apart(section)
                for target in graph.targets(section) if released else ():
                    for first in entries(target):
                        needs = _merge(self._tree_needs(a) for a in first.activities)
                        producers = {self.producer[s] for s in needs if s in self.producer}
                        # What enters beside it may take a resource at once, and must not be waited for.
                        beside = [a for e in entries(target) if e is not first for a in e.activities]
                        taken = _merge(self._tree_needs(a) for a in beside)
                        again = {s for s in released if self.producer[s] in producers and s not in taken}
                        if again:
                            awaited.setdefault(first.name, set()).update(again)
        order = {software: number for number, software in enumerate(self.producer)}
        return {name: tuple(sorted(found, key=order.__getitem__)) for name, found in awaited.items()}

    def _released_apart(self, section: Section) -> set[str]:
        released: set[str] = set()
        needs = _merge(self._tree_needs(a) for last in _endings(section) for a in last.activities)
        for activity in {self.producer[s] for s in needs if s in self.producer}:
            outputs = [s for s in self.activities[activity].produces if s in needs]
            if len({c for s in outputs for c, _ in needs[s]}) > 1 and len(outputs) > 1:
                released.update(s for s in outputs if s not in self.contended_resources)
        return released

    def _graphs(self) -> Iterator[ObjectivesGraph]:
        stack = [self.graph]
        while stack:
            graph = stack.pop()
            yield graph
            for section in graph.sections:
                if isinstance(section, ParallelSection):
                    stack.extend(branch.graph for branch in section.branches)


def entries(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that start when a section is entered."""
    if isinstance(section, ElementarySection):
        return (section,)
    return tuple(
        first for branch in section.branches for first in entries(branch.graph.section(branch.graph.entry))
    )


def _endings(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that may be the last of a section, of a branch for a parallel block."""
    if isinstance(section, ElementarySection):
        return (section,)
    return tuple(
        last
        for branch in section.branches
        for inner in branch.graph.sections
        if len(branch.graph.targets(inner)) < 2
        for last in _endings(inner)
    )


def _named(graph: ObjectivesGraph) -> set[str]:
    """Activities that the objectives of a graph start."""
    return {activity for section in graph.walk() for activity in section.activities}


def _both(first: Needs, second: Needs) -> Iterator[tuple[str, Demand, Demand]]:
    for resource in first.keys() & second.keys():
        for c in first[resource]:
            for d in second[resource]:
                if c[0] != d[0]:
                    yield resource, c, d


def _merge(parts: Iterable[Needs]) -> Needs:
    merged: Needs = {}
    for part in parts:
        for resource, demands in part.items():
            merged.setdefault(resource, set()).update(demands)
    return merged
