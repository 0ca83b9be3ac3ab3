"""Who uses what, together with whom: the static analysis that the net's composition rests on.

Everything here is decided on the structure of the mission, before any marking is explored, and errs on the
side of *may*: what is called contended may be so in some run, what is not called so never is.

Words: a *demand* is one alternative of one activity with the resources that it consumes. Two demands are
*concurrent* where their activities may run together: in branches of one parallel block, in one objective, or
one inside the chain of resources that the other consumes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

from mcpn.errors import Source
from mcpn.mission.conditions import FACTS, FactUsage
from mcpn.mission.flatten import ElementarySection, ObjectivesGraph, ParallelSection
from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Hardware
from mcpn.mission.static.handover import Handover
from mcpn.mission.static.sharing import Contention, Sharing, occasions
from mcpn.mission.static.switching import Switching

Demand: TypeAlias = tuple[str, int]
"""An activity's name and the index of one of its alternatives, from 0."""

Needs: TypeAlias = dict[str, set[Demand]]
"""Demands by the resource that they consume."""


class Usage:
    """The static analysis of a mission; computed once, read by templates, checks and the composition.

    Args:
        mission: A valid mission.
        graph: Its objectives graph.
    """

    def __init__(self, mission: Mission, graph: ObjectivesGraph) -> None:
        self.mission = mission
        self.graph = graph
        self.world = FactUsage(mission)
        self.hardware: Mapping[str, Hardware] = {h.name: h for h in mission.hardware}
        self.activities: Mapping[str, Activity] = {a.name: a for a in mission.activities}
        self.producer: Mapping[str, str] = {s: a.name for a in mission.activities for s in a.produces}
        self._software = {s.name: s for s in mission.software}
        self._closures: dict[str, frozenset[str]] = {}
        self._heights: dict[str, int] = {}
        self._hardware_under: dict[str, frozenset[str]] = {}
        self._needs: dict[str, Needs] = {}
        self._inner: dict[str, frozenset[tuple[str, Demand, Demand]]] = {}
        # Suppliers first, so that no recursion below goes deeper than one step, however long the chains are.
        for name in self.suppliers_first():
            self.closure(name)
            for resource in self.activities[name].produces:
                self.hardware_under(resource)
        for name in self.suppliers_first():
            self._inside(name)

    # --- suppliers and the hardware below them ---------------------------------------------------------

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

    def height(self, activity: str) -> int:
        """The length of the longest chain of suppliers below the activity; 0 where it has none."""
        if not self._heights:
            for name in self.suppliers_first():
                alternatives = range(len(self.activities[name].alternatives))
                below = (self._heights[p] for i in alternatives for p in self.suppliers(name, i))
                self._heights[name] = max(below, default=-1) + 1
        return self._heights[activity]

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

    @cached_property
    def requiring(self) -> frozenset[str]:
        """Activities that some objective starts and that require facts to be so."""
        return self.world.requiring & {*self.started}

    def hardware_under(self, resource: str) -> frozenset[str]:
        """The faulty hardware whose failure may end in an error of the resource, itself included.

        :data:`mcpn.mission.conditions.FACTS` is among it where a change of facts may.
        """
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
            self.world.requires(activity, i) or any(self.can_fail(k) for k in alternative.consumes)
            for i, alternative in enumerate(self.activities[activity].alternatives)
        )

    def fail_together(self, activity: str, alternative: int) -> frozenset[tuple[str, ...]]:
        """Consumed resources that one hardware failure may put in error in one internal run, in order.

        Any of them may be in error, and not all need be.
        """
        consumed = self.activities[activity].alternatives[alternative].consumes
        under = [(k, self.hardware_under(k)) for k in consumed]
        hardware = frozenset[str]().union(*(below for _, below in under))
        return frozenset(tuple(k for k, below in under if h in below) for h in hardware)

    def released_unasked(self, resource: str) -> bool:
        """Whether a consumer may release the resource while its producer is still evaluating.

        There are two cases: one failure, or one return, makes the producer evaluate again and, by another
        way, a consumer release the resource; or the producer may wait for another activity's release.
        """
        return resource in self._released_unasked or self.may_wait(self.producer[resource])

    @cached_property
    def _released_unasked(self) -> frozenset[str]:
        return frozenset(
            s
            for name in self.started
            for s in self.activities[name].produces
            # An objective that ends may change facts: in one reaction its activities release resources, and
            # the change makes others evaluate again.
            if FACTS in self._evaluated_after(name)
            or occasions(self._evaluated_after(name), self.switching.returns(name))
            & self.sharing.affecting([a for a in self.started if s in self.resources_of({a})], name)
        )

    def _evaluated_after(self, activity: str) -> frozenset[str]:
        """The hardware whose failure may make the activity evaluate its alternatives again."""
        consumed = {k for alternative in self.activities[activity].alternatives for k in alternative.consumes}
        facts = [{FACTS}] if activity in self.world.requiring else []
        return frozenset[str]().union(*facts, *(self.hardware_under(k) for k in consumed))

    # --- who may run together --------------------------------------------------------------------------

    @cached_property
    def contentions(self) -> tuple[Contention, ...]:
        """Every contention, each pair of activities once per resource and context; context by context."""
        pairs: dict[Contention, None] = {}
        for resource, (a, _), (b, _), context, source in self._concurrent_demands():
            pair = (a, b) if a < b else (b, a)
            pairs.setdefault(Contention(resource, pair, context, source))
        for section, first, second, activity in self.started_twice():
            context = f"parallel block {section.name}"
            pairs.setdefault(Contention(f"activity {activity}", (first, second), context, section.source))
        contexts = {context: number for number, context in enumerate(dict.fromkeys(c.context for c in pairs))}
        return tuple(sorted(pairs, key=lambda c: (contexts[c.context], c.rivals, c.wanted)))

    @cached_property
    def _contended(self) -> frozenset[Demand]:
        return frozenset(d for _, c, e, _, _ in self._concurrent_demands() for d in (c, e))

    @cached_property
    def wanted_together(self) -> frozenset[str]:
        """Resources that two activities may want at the same time, whether they share them or contend."""
        return frozenset(resource for resource, *_ in self._graph_demands(self.graph))

    @cached_property
    def wanted_again(self) -> frozenset[str]:
        """Software that is wanted together, or that one reaction may give back and ask for again.

        The latter has two demands within one objective: when one is given up, the other may follow.
        """
        again = set[str]()
        for section in self.graph.walk():
            needs = _merge(self.tree_needs(a) for a in section.activities)
            again.update(k for k, demands in needs.items() if len(demands) > 1)
        return frozenset(again | self.wanted_together) & self.producer.keys()

    def is_exclusive(self, resource: str) -> bool:
        """Whether one activity at most may use the resource at a time."""
        if resource in self.hardware:
            return not self.hardware[resource].shared
        return self._software[resource].exclusive

    def resources_of(self, activities: Iterable[str]) -> frozenset[str]:
        """Resources that some alternative of some activities consumes."""
        ways = (way for a in activities for way in self.activities[a].alternatives)
        return frozenset(k for way in ways for k in way.consumes)

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
        """Demands that contend: for a resource that is not shared."""
        return (found for found in self._graph_demands(self.graph) if self.is_exclusive(found[0]))

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
                    for resource, c, d in _both(self.tree_needs(a), self.tree_needs(b)):
                        yield resource, c, d, context, section.source
            else:
                context = f"parallel block {section.name}"
                needs = [self._graph_needs(branch.graph) for branch in section.branches]
                for first, second in combinations(needs, 2):
                    for resource, c, d in _both(first, second):
                        yield resource, c, d, context, section.source
                for inner in section.graphs:
                    yield from self._graph_demands(inner)

    def _inside(self, activity: str) -> frozenset[tuple[str, Demand, Demand]]:
        """Pairs of demands for one resource that one running activity, with its suppliers, may make at once.

        Two demands contend if they belong to one alternative. They also contend if the activity changes its
        alternative: suppliers of the old one may still be choosing an alternative of their own when the new
        one makes its demands.
        """
        if activity not in self._inner:
            demands: set[tuple[str, Demand, Demand]] = set()
            for i, alternative in enumerate(self.activities[activity].alternatives):
                own: Needs = {k: {(activity, i)} for k in alternative.consumes}
                below = self.suppliers(activity, i)
                for p in below:
                    demands |= self._inside(p)
                    demands.update(_both(own, self.tree_needs(p)))
                for p, q in combinations(below, 2):
                    demands.update(_both(self.tree_needs(p), self.tree_needs(q)))
                under = frozenset[str]().union(*(self.closure(p) for p in below))
                still_choosing = [
                    q
                    for q in under
                    if occasions(self._evaluated_after(q), self.switching.returns(q))
                    & self.sharing.ending(activity, i, q)
                ]
                for j, other in enumerate(self.activities[activity].alternatives if still_choosing else ()):
                    if i != j:
                        its: Needs = {k: {(activity, j)} for k in other.consumes}
                        its = _merge([its, *(self.tree_needs(p) for p in self.suppliers(activity, j))])
                        for q in still_choosing:
                            demands.update(_both(its, self.tree_needs(q)))
            self._inner[activity] = frozenset(demands)
        return self._inner[activity]

    def tree_needs(self, activity: str) -> Needs:
        """Demands of the activity and of all that it may start, by resource."""
        if activity not in self._needs:
            self._needs[activity] = _merge(
                {k: {(a, i)} for k in alternative.consumes}
                for a in self.closure(activity)
                for i, alternative in enumerate(self.activities[a].alternatives)
            )
        return self._needs[activity]

    def _graph_needs(self, graph: ObjectivesGraph) -> Needs:
        return _merge(self.tree_needs(a) for section in graph.walk() for a in section.activities)

    @cached_property
    def sharing(self) -> Sharing:
        """Which resources several activities may use at a time."""
        return Sharing(self)

    @cached_property
    def switching(self) -> Switching:
        """Which activities return to a better alternative, and when."""
        return Switching(self)

    @cached_property
    def handover(self) -> Handover:
        """What an objective must wait for before it begins."""
        return Handover(self)

    def started_twice(self) -> Iterator[tuple[ParallelSection, str, str, str]]:
        """Parallel blocks of which two branches start the same activity: block, branches, activity."""
        for graph in self.graphs():
            for section in graph.sections:
                if isinstance(section, ParallelSection):
                    for first, second in combinations(section.branches, 2):
                        shared = _named(first.graph) & _named(second.graph)
                        for activity in sorted(shared):
                            yield section, first.name, second.name, activity

    def graphs(self) -> Iterator[ObjectivesGraph]:
        """The mission's graph and those of branches, at any depth."""
        stack = [self.graph]
        while stack:
            graph = stack.pop()
            yield graph
            for section in graph.sections:
                if isinstance(section, ParallelSection):
                    stack.extend(section.graphs)


def _named(graph: ObjectivesGraph) -> set[str]:
    """Activities that the objectives of a graph start."""
    return {activity for section in graph.walk() for activity in section.activities}


def _both(first: Needs, second: Needs) -> Iterator[tuple[str, Demand, Demand]]:
    """Pairs of demands of different activities for one resource, one demand from each side."""
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
