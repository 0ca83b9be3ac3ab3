"""What activities stand on: their suppliers at any depth, and the hardware whose failure reaches them.

Everything here is decided on the structure of the mission, before any marking is explored.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from itertools import combinations

from mcpn.mission.core.objectives_graph import ObjectivesGraph, ParallelSection
from mcpn.mission.fact_conditions import FACTS
from mcpn.mission.fact_usage import FactUsage
from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Hardware


class Suppliers:
    """The activities and resources of a mission, by what they stand on.

    Args:
        mission: A valid mission.
        graph: Its objectives graph, of the whole mission.

    Attributes:
        core: The core mission: what its hardware and its activities are, common causes written out.
    """

    def __init__(self, mission: Mission, graph: ObjectivesGraph) -> None:
        assert graph.core is not None, "the graph of a whole mission"
        self.mission = mission
        self.core = core = graph.core
        self.graph = graph
        self.world = FactUsage(core)
        self.hardware: Mapping[str, Hardware] = {h.name: h for h in core.hardware}
        self.activities: Mapping[str, Activity] = {a.name: a for a in core.activities}
        self.producer: Mapping[str, str] = {s: a.name for a in core.activities for s in a.produces}
        self._software = {s.name: s for s in core.software}
        self._closures: dict[str, frozenset[str]] = {}
        self._heights: dict[str, int] = {}
        self._hardware_under: dict[str, frozenset[str]] = {}
        # Suppliers first, so that no recursion below goes deeper than one step, however long the chains are.
        for name in self.suppliers_first():
            self.closure(name)
            for resource in self.activities[name].produces:
                self.hardware_under(resource)

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

        :data:`mcpn.mission.fact_conditions.FACTS` is among it where a change of facts may.
        """
        if resource in self.hardware:
            return frozenset({resource}) if self.hardware[resource].faulty else frozenset()
        if resource not in self._hardware_under:
            activity = self.producer[resource]
            under = frozenset[str]()
            if self.refusable(activity):
                under = self.evaluated_after(activity)
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

    def evaluated_after(self, activity: str) -> frozenset[str]:
        """The hardware whose failure may make the activity evaluate its alternatives again."""
        consumed = {k for alternative in self.activities[activity].alternatives for k in alternative.consumes}
        facts = [{FACTS}] if activity in self.world.requiring else []
        return frozenset[str]().union(*facts, *(self.hardware_under(k) for k in consumed))

    def is_exclusive(self, resource: str) -> bool:
        """Whether one activity at most may use the resource at a time."""
        if resource in self.hardware:
            return not self.hardware[resource].shared
        return self._software[resource].exclusive

    def resources_of(self, activities: Iterable[str]) -> frozenset[str]:
        """Resources that some alternative of some activities consumes."""
        ways = (way for a in activities for way in self.activities[a].alternatives)
        return frozenset(k for way in ways for k in way.consumes)

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
