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

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property, reduce

from mcpn.check.causes.families import ALWAYS, NEVER, Families, Family
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.mission.usage import Usage

Exits = Mapping[str, Family]
"""What is lost at each of the two exits of an objectives graph."""

SUCCESS_WANTED: Exits = {SUCCEED: NEVER, FAIL: ALWAYS}
FAILURE_WANTED: Exits = {SUCCEED: ALWAYS, FAIL: NEVER}
ANY_WANTED: Exits = {SUCCEED: NEVER, FAIL: NEVER}


def entered(graph: ObjectivesGraph, lost: Callable[[Section], tuple[Family, Family]]) -> list[Section]:
    """The sections of a graph that some run enters, each after one that leads to it.

    Args:
        graph: The sections.
        lost: When a section cannot be left by its success, and by its failure.
    """
    names, known = [graph.entry], {section.name for section in graph.sections}
    for name in names:  # grows while it is walked
        section = graph.section(name)
        for loss, after in zip(lost(section), (section.success, section.failure), strict=True):
            if loss != ALWAYS and after in known and after not in names:
                names.append(after)
    return [graph.section(name) for name in names]


class Availability:
    """Loss functions from the mission's text; elements are the faulty hardware in the mission's order.

    Args:
        usage: The mission's static facts.
        families: Where to make the functions; a store of its own by default.
    """

    def __init__(self, usage: Usage, families: Families | None = None) -> None:
        self.usage = usage
        self.hardware = tuple(h.name for h in usage.mission.hardware if h.faulty)
        self.families = families or Families(len(self.hardware))
        self._resources: dict[str, Family] = {h.name: NEVER for h in usage.mission.hardware}
        self._resources |= {h: self.families.single(number) for number, h in enumerate(self.hardware)}
        self._activities: dict[str, Family] = {}
        for name in usage.suppliers_first():
            self._activities[name] = self._activity(name)
            for product in usage.activities[name].produces:
                self._resources[product] = self._activities[name]

    @property
    def exact(self) -> bool:
        """Whether nothing contends, so that these functions are those of the state space."""
        return not self.usage.contentions

    def either(self, functions: Iterable[Family]) -> Family:
        """Lost where one is."""
        return reduce(self.families.either, functions, NEVER)

    def both(self, functions: Iterable[Family]) -> Family:
        """Lost where all are."""
        return reduce(self.families.both, functions, ALWAYS)

    def _activity(self, name: str) -> Family:
        return self.both(
            self.either(self._resources[k] for k in alternative.consumes)
            for alternative in self.usage.activities[name].alternatives
        )

    def activity(self, name: str) -> Family:
        """When no alternative of an activity is possible."""
        return self._activities[name]

    def resource(self, name: str) -> Family:
        """When a resource, hardware or software, cannot be had."""
        return self._resources[name]

    def objective(self, section: ElementarySection) -> Family:
        """When an objective cannot succeed: one of its activities is not possible."""
        return self.either(self._activities[a] for a in section.activities)

    @cached_property
    def objectives(self) -> Mapping[str, Family]:
        """When each elementary objective cannot succeed, by its name."""
        return {section.name: self.objective(section) for section in self.usage.graph.walk()}

    # --- sections --------------------------------------------------------------------------------------

    def sections(self, graph: ObjectivesGraph, exits: Exits) -> Mapping[str, Family]:
        """When no run from the entry of each section of a graph leads to an exit that is wanted.

        Args:
            graph: The mission's objectives graph, or that of a branch.
            exits: What is lost at the graph's own exits.

        Returns:
            By section: the greatest solution of *lost here = (success is impossible, or lost behind it) and
            (failure is impossible, or lost behind it)*.
        """
        families = self.families
        ways = {s.name: (self.succeeding(s), self.failing(s)) for s in graph.sections}
        lost = dict.fromkeys(ways, ALWAYS) | dict(exits)
        changed = True
        while changed:
            changed = False
            for section in reversed(graph.sections):
                well, badly = ways[section.name]
                now = families.both(
                    families.either(well, lost[section.success]),
                    families.either(badly, lost[section.failure]),
                )
                changed |= now != lost[section.name]
                lost[section.name] = now
        return {name: lost[name] for name in ways}

    def succeeding(self, section: Section) -> Family:
        """When a section cannot be left by its success."""
        if isinstance(section, ElementarySection):
            return self.objective(section)
        return self.either(
            self.branch(b, SUCCESS_WANTED if b.mandatory else ANY_WANTED) for b in section.branches
        )

    def failing(self, section: Section) -> Family:
        """When a section cannot be left by its failure; an elementary objective always can."""
        return NEVER if isinstance(section, ElementarySection) else self._block_failing(section)

    def _block_failing(self, block: ParallelSection) -> Family:
        ended = self.either(self.branch(b, ANY_WANTED) for b in block.branches)
        failed = self.both(self.branch(b, FAILURE_WANTED) for b in block.branches if b.mandatory)
        return self.families.either(ended, failed)

    def branch(self, branch: Branch, exits: Exits) -> Family:
        """When a branch of a parallel block cannot be left by a wanted exit."""
        return self.sections(branch.graph, exits)[branch.graph.entry]

    @cached_property
    def mission_from(self) -> Mapping[str, Family]:
        """When the mission cannot succeed any more from the entry of each section of the mission's graph."""
        return self.sections(self.usage.graph, SUCCESS_WANTED)

    @property
    def mission(self) -> Family:
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
        self.families = Families(len(self.names))

    def objective(self, section: ElementarySection) -> Family:
        """The objective itself."""
        return self.families.single(self._numbers[section.name])
