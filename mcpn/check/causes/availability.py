"""What success needs, read from the mission's text alone: loss functions without a state space.

An activity is possible where one of its alternatives has all its resources, a software resource where its
producer is possible, hardware where it is in service. So the loss of an objective is a monotone function of
the hardware that is out of service, made of conjunctions over alternatives and disjunctions over resources;
the loss of the mission follows on the objectives graph as a greatest fixpoint, section by section. No state
is explored: the cost is that of the diagrams, which keep shared parts shared.

This holds where nothing contends (:attr:`Availability.exact`): then an activity whose resources can all be
had runs, whatever else does. The state spaces are the truth, and the tests hold this against them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property, reduce
from operator import and_, or_

from mcpn._kernel import Zdd
from mcpn.mission.facts.usage import Usage
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.space.images import ImageStore


class Availability:
    """Loss functions from the mission's text: families of sets of hardware, with all that contain them.

    Args:
        usage: The mission's static facts.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self.hardware = tuple(h.name for h in usage.mission.hardware if h.faulty)
        self.over(len(self.hardware))
        self._resources: dict[str, Zdd] = {h.name: self.never for h in usage.mission.hardware}
        self._resources |= {h: self.single(number) for number, h in enumerate(self.hardware)}
        self._activities: dict[str, Zdd] = {}
        for name in usage.suppliers_first():
            self._activities[name] = self._activity(name)
            for product in usage.activities[name].produces:
                self._resources[product] = self._activities[name]

    def over(self, elements: int) -> None:
        """Makes functions of so many elements from now on."""
        self.images = ImageStore(elements)
        self.never, self.always = self.images.nothing, self.images.everything

    def single(self, element: int) -> Zdd:
        """Lost where one element is."""
        return self.images.upward(self.images.store.singleton([element]))

    @property
    def exact(self) -> bool:
        """Whether nothing contends, so that these functions are those of the state space."""
        return not self.usage.contentions

    def either(self, functions: Iterable[Zdd]) -> Zdd:
        """Lost where one is."""
        return reduce(or_, functions, self.never)

    def both(self, functions: Iterable[Zdd]) -> Zdd:
        """Lost where all are."""
        return reduce(and_, functions, self.always)

    def _activity(self, name: str) -> Zdd:
        return self.both(
            self.either(self._resources[k] for k in alternative.consumes)
            for alternative in self.usage.activities[name].alternatives
        )

    def minimal(self, function: Zdd) -> list[tuple[int, ...]]:
        """The minimal sets of elements where a function is true, smaller ones first."""
        return sorted(self.images.minimal(function), key=lambda members: (len(members), members))

    def activity(self, name: str) -> Zdd:
        """When no alternative of an activity is possible."""
        return self._activities[name]

    def resource(self, name: str) -> Zdd:
        """When a resource, hardware or software, cannot be had."""
        return self._resources[name]

    def objective(self, section: ElementarySection) -> Zdd:
        """When an objective cannot succeed: one of its activities is not possible."""
        return self.either(self._activities[a] for a in section.activities)

    @cached_property
    def objectives(self) -> Mapping[str, Zdd]:
        """When each elementary objective cannot succeed, by its name."""
        return {section.name: self.objective(section) for section in self.usage.graph.walk()}

    # --- sections --------------------------------------------------------------------------------------

    def sections(self, graph: ObjectivesGraph, *wanted: str) -> Mapping[str, Zdd]:
        """When no run from the entry of each section of a graph leads to an exit that is wanted.

        Args:
            graph: The mission's objectives graph, or that of a branch.
            wanted: Those of the graph's own exits that are wanted.

        Returns:
            By section: the greatest solution of *lost here = (success is impossible, or lost behind it) and
            (failure is impossible, or lost behind it)*.
        """
        ways = {s.name: (self.succeeding(s), self.failing(s)) for s in graph.sections}
        lost = dict.fromkeys((*ways, SUCCEED, FAIL), self.always) | dict.fromkeys(wanted, self.never)
        changed = True
        while changed:
            changed = False
            for section in reversed(graph.sections):
                well, badly = ways[section.name]
                now = (well | lost[section.success]) & (badly | lost[section.failure])
                changed |= now != lost[section.name]
                lost[section.name] = now
        return {name: lost[name] for name in ways}

    def succeeding(self, section: Section) -> Zdd:
        """When a section cannot be left by its success."""
        if isinstance(section, ElementarySection):
            return self.objective(section)
        return self.either(
            self.branch(b, SUCCEED) if b.mandatory else self.branch(b, SUCCEED, FAIL)
            for b in section.branches
        )

    def failing(self, section: Section) -> Zdd:
        """When a section cannot be left by its failure; an elementary objective always can."""
        return self.never if isinstance(section, ElementarySection) else self._block_failing(section)

    def _block_failing(self, block: ParallelSection) -> Zdd:
        ended = self.either(self.branch(b, SUCCEED, FAIL) for b in block.branches)
        return ended | self.both(self.branch(b, FAIL) for b in block.branches if b.mandatory)

    def branch(self, branch: Branch, *wanted: str) -> Zdd:
        """When a branch of a parallel block cannot be left by a wanted exit."""
        return self.sections(branch.graph, *wanted)[branch.graph.entry]

    @cached_property
    def mission_from(self) -> Mapping[str, Zdd]:
        """When the mission cannot succeed any more from the entry of each section of the mission's graph."""
        return self.sections(self.usage.graph, SUCCEED)

    @property
    def mission(self) -> Zdd:
        """When the mission cannot succeed from its start."""
        return self.mission_from[self.usage.graph.entry]


class LostObjectives(Availability):
    """The loss of the mission as a function of the objectives that cannot succeed, each an element.

    Args:
        usage: The mission's static facts.
    """

    def __init__(self, usage: Usage) -> None:
        super().__init__(usage)
        self.names = tuple(section.name for section in usage.graph.walk())
        self._numbers = {name: number for number, name in enumerate(self.names)}
        self.over(len(self.names))

    def objective(self, section: ElementarySection) -> Zdd:
        """The objective itself."""
        return self.single(self._numbers[section.name])
