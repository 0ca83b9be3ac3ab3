"""Who demands what together with whom, what contends, and who may wait for whom.

It errs on the side of *may*: what is called contended may be so in some run, what is not called so never is.

Words: a *demand* is one alternative of one activity with the resources that it consumes. Two demands are
*concurrent* where their activities may run together: in branches of one parallel block, in one objective, or
one inside the chain of resources that the other consumes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

from mcpn.errors import Source
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph
from mcpn.mission.fact_conditions import FACTS
from mcpn.mission.model import Mission
from mcpn.mission.static.contention import Contention
from mcpn.mission.static.occasions import Occasions, occasions
from mcpn.mission.static.suppliers import Suppliers
from mcpn.mission.static.switching import Switching

Demand: TypeAlias = tuple[str, int]
"""An activity's name and the index of one of its alternatives, from 0."""

Needs: TypeAlias = dict[str, set[Demand]]
"""Demands by the resource that they consume."""


class ConcurrentDemands(Suppliers):
    """What the activities of a mission demand, together with which others.

    Args:
        mission: A valid mission.
        graph: Its objectives graph.
    """

    def __init__(self, mission: Mission, graph: ObjectivesGraph) -> None:
        super().__init__(mission, graph)
        self._needs: dict[str, Needs] = {}
        self._inner: dict[str, frozenset[tuple[str, Demand, Demand]]] = {}
        for name in self.suppliers_first():
            self._inside(name)

    @cached_property
    def switching(self) -> Switching:
        """Which activities return to a better alternative, and when."""
        return Switching(self)

    @cached_property
    def occasions(self) -> Occasions:
        """What makes activities ask, release, or leave an alternative."""
        return Occasions(self, self.switching)

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
            if FACTS in self.evaluated_after(name)
            or occasions(self.evaluated_after(name), self.switching.returns(name))
            & self.occasions.affecting([a for a in self.started if s in self.resources_of({a})], name)
        )

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
                    if occasions(self.evaluated_after(q), self.switching.returns(q))
                    & self.occasions.ending(activity, i, q)
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
