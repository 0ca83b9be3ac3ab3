"""What success needs, read from the mission's text alone: loss functions without a state space.

An activity is possible where one of its alternatives has all its resources, a software resource where its
producer is possible, hardware where it is in service. So the loss of an objective is a monotone function of
the hardware that is out of service, made of conjunctions over alternatives and disjunctions over resources;
the loss of the mission follows on the objectives graph as a greatest fixpoint, section by section. No state
is explored: the cost is that of the diagrams, which keep shared parts shared.

This holds where nothing contends: then an activity whose resources can all be had runs, whatever else does.
The state spaces are the truth, and the tests hold this against them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property, reduce
from operator import and_, or_

from mcpn._kernel import Zdd
from mcpn.mission.facts.usage import Usage
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.images import ImageStore


class Losses:
    """Loss functions of sections and of the mission: sets of elements, with all sets that contain them.

    Args:
        usage: The mission's static facts.
        elements: What may be lost: the mission's elementary objectives, each on its own.
    """

    def __init__(self, usage: Usage, elements: Iterable[str]) -> None:
        self.usage = usage
        self.elements = tuple(elements)
        self.images = ImageStore(len(self.elements))
        self.never, self.always = self.images.nothing, self.images.everything
        self._single = {
            name: self.images.upward(self.images.store.singleton([number]))
            for number, name in enumerate(self.elements)
        }

    def objective(self, section: ElementarySection) -> Zdd:
        """When an objective cannot succeed."""
        return self._single[section.name]

    def either(self, functions: Iterable[Zdd]) -> Zdd:
        """Lost where one is."""
        return reduce(or_, functions, self.never)

    def both(self, functions: Iterable[Zdd]) -> Zdd:
        """Lost where all are."""
        return reduce(and_, functions, self.always)

    def minimal(self, function: Zdd) -> list[tuple[str, ...]]:
        """The minimal sets of elements where a function is true, smaller ones first."""
        found = sorted(self.images.minimal(function), key=lambda members: (len(members), members))
        return [tuple(self.elements[member] for member in members) for members in found]

    @cached_property
    def mission_from(self) -> Mapping[str, Zdd]:
        """When the mission cannot succeed any more from the entry of each section of the mission's graph."""
        return self._sections(self.usage.graph, SUCCEED)

    @property
    def mission(self) -> Zdd:
        """When the mission cannot succeed from its start."""
        return self.mission_from[self.usage.graph.entry]

    def _sections(self, graph: ObjectivesGraph, *wanted: str) -> Mapping[str, Zdd]:
        """When no run from the entry of each section of a graph leads to an exit that is wanted.

        It is the greatest solution of *lost here = (success is impossible, or lost behind it) and (failure is
        impossible, or lost behind it)*.
        """
        ways = {s.name: (self._succeeding(s), self._failing(s)) for s in graph.sections}
        lost = dict.fromkeys((*ways, SUCCEED, FAIL), self.always) | dict.fromkeys(wanted, self.never)
        changed = True
        while changed:
            changed = False
            for section in reversed(graph.sections):
                well, badly = ways[section.name]
                now = (well | lost[section.success]) & (badly | lost[section.failure])
                changed |= now != lost[section.name]
                lost[section.name] = now
        return lost

    def _branch(self, branch: Branch, *wanted: str) -> Zdd:
        return self._sections(branch.graph, *wanted)[branch.graph.entry]

    def _succeeding(self, section: Section) -> Zdd:
        """When a section cannot be left by its success."""
        if isinstance(section, ElementarySection):
            return self.objective(section)
        return self.either(
            self._branch(b, *((SUCCEED,) if b.mandatory else (SUCCEED, FAIL))) for b in section.branches
        )

    def _failing(self, section: Section) -> Zdd:
        """When a section cannot be left by its failure; an elementary objective always can."""
        if isinstance(section, ElementarySection):
            return self.never
        ended = self.either(self._branch(b, SUCCEED, FAIL) for b in section.branches)
        return ended | self.both(self._branch(b, FAIL) for b in section.branches if b.mandatory)


class Availability(Losses):
    """Loss functions of the hardware that can fail.

    Args:
        usage: The mission's static facts.
    """

    def __init__(self, usage: Usage) -> None:
        super().__init__(usage, (h.name for h in usage.mission.hardware if h.faulty))
        self.activities: dict[str, Zdd] = {}
        """When no alternative of each activity is possible."""
        self.resources = {h.name: self._single.get(h.name, self.never) for h in usage.mission.hardware}
        """When each resource, hardware or software, cannot be had."""
        for name in usage.suppliers_first():
            activity = usage.activities[name]
            self.activities[name] = self.both(
                self.either(self.resources[k] for k in way.consumes) for way in activity.alternatives
            )
            self.resources |= dict.fromkeys(activity.produces, self.activities[name])

    def objective(self, section: ElementarySection) -> Zdd:
        """When an objective cannot succeed: one of its activities is not possible."""
        return self.either(self.activities[a] for a in section.activities)
