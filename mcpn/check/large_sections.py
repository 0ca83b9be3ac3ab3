"""Loss functions of sections too large for a local graph, where nothing contends: from the mission's text.

What a block's branches may still do depends on hardware that they do not share with each other's doings, so
that the block's own states are products, and what is lost in them is put together branch by branch. Critical
events where hardware is repaired are read from the section's diagram.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

from mcpn._kernel import Zdd
from mcpn.check.availability import ANY_WANTED, FAILURE_WANTED, SUCCESS_WANTED, Availability, entered
from mcpn.check.cutsets import Moment
from mcpn.check.families import ALWAYS, NEVER, Family
from mcpn.check.local_sections import Behind, Out, SectionLosses
from mcpn.check.losing import CriticalEvent
from mcpn.errors import LimitError
from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.net.events import Event, What
from mcpn.net.templates import TemplateSet
from mcpn.space.local.diagram import LocalDiagram
from mcpn.space.local.interface import HardwareStates
from mcpn.space.local.placing import PlacedSection
from mcpn.space.local.protocol import Outcome


def section_by_text(section: Section, text: Availability) -> SectionLosses:
    """The loss functions of a section from the mission's text.

    Args:
        section: The section.
        text: Loss functions from the mission's text.

    Raises:
        LimitError: Something in the mission contends.
    """
    if not text.exact:
        raise LimitError(
            f"section {section.name} uses too much hardware for a local graph, and is part of a mission in "
            "which resources contend: its text alone does not tell what is lost"
        )
    return (
        TextSection(section, text) if isinstance(section, ElementarySection) else BlockSection(section, text)
    )


class TextSection:
    """An elementary objective too large for a local graph, where nothing contends: its text says all.

    Its states differ in what is out of service and in whether an alternative is still possible, and a run
    without repairs that has one can succeed at once.

    Args:
        section: The section.
        text: Loss functions from the mission's text.

    """

    def __init__(self, section: ElementarySection, text: Availability) -> None:
        self.section: Section = section
        self.families = text.families
        self.hardware = text.hardware
        self.succeeding = text.objective(section)
        self.here: Out = frozenset(text.families.support(self.succeeding))
        self.failing = NEVER

    def exits(self, out: Out) -> tuple[set[Out], set[Out]]:
        """What is out of service when forced runs from an entry leave by success, and by failure."""
        lost = self.families.both(self.families.all_of(out), self.succeeding)
        badly = {frozenset(members) for members in self.families.members(lost)}
        return (set() if out in badly else {out}), badly

    def objectives(self, moment: Moment, entries: Iterable[Out]) -> Mapping[str, Family]:
        """Cut sets of the objective: at the worst moment those with which it can be entered."""
        lost = self.succeeding
        return {self.section.name: self._entered(lost, entries) if moment is Moment.SOMETIME else lost}

    def beyond(self, moment: Moment, behind: Behind, entries: Iterable[Out]) -> Family:
        """Cut sets of the mission while the objective runs."""
        lost = self._lost(behind)
        return self._entered(lost, entries) if moment is Moment.SOMETIME else lost

    def _entered(self, lost: Family, entries: Iterable[Out]) -> Family:
        found = NEVER
        for out in entries:
            found = self.families.either(found, self.families.both(self.families.all_of(out), lost))
        return found

    def _lost(self, behind: Behind) -> Family:
        return self.families.both(self.families.either(self.succeeding, behind.success), behind.failure)

    def critical_of(self, objective: str, repairs: bool) -> list[CriticalEvent]:
        """Critical events of the objective, for which repairs come too late; its modes are not told apart."""
        return [
            self._critical(Event(What.OUT_OF_SERVICE, self.hardware[h]))
            for h in self.families.support(self.succeeding)
        ]

    def critical(self, behind: Behind, first: bool) -> list[CriticalEvent]:
        """Critical events of the mission while the objective runs; its modes are not told apart."""
        lost, either = self._lost(behind), self.families.either
        found = [
            self._critical(Event(What.OUT_OF_SERVICE, self.hardware[h])) for h in self.families.support(lost)
        ]
        if first:
            found += [replace(critical, objectives=()) for critical in found]
        running = either(lost, self.succeeding)
        for before, after, what in (
            (running, behind.success, What.SUCCESS),
            (lost, behind.failure, What.FAILURE),
        ):
            if either(before, after) != before:
                found.append(self._critical(Event(what, self.section.name)))
        return found

    def _failures(self, lost: Family) -> list[Event]:
        """Failures of the hardware that a function depends on."""
        return [Event(What.OUT_OF_SERVICE, self.hardware[h]) for h in self.families.support(lost)]

    def _critical(self, event: Event) -> CriticalEvent:
        return CriticalEvent(event, (self.section.name,), {}, 1)


class Chances(NamedTuple):
    """When a branch of a block, in one state, cannot end well, cannot end at all, and cannot end badly.

    For a branch that is optional, to end at all is to end well.
    """

    well: Family
    ever: Family
    badly: Family


class BlockSection:
    """A parallel block too large for a local graph, where nothing contends.

    Args:
        section: The section.
        text: Loss functions from the mission's text.
    """

    def __init__(self, section: ParallelSection, text: Availability) -> None:
        self.section: Section = section
        self.block = section
        self.text = text
        self.families = text.families
        self.hardware = text.hardware
        self.succeeding = text.succeeding(section)
        self.failing = text.failing(section)
        inner = ObjectivesGraph((section,), section.name).walk()
        self.inside = {objective.name: text.objective(objective) for objective in inner}
        self.here: Out = frozenset().union(*(text.families.support(lost) for lost in self.inside.values()))

    def exits(self, out: Out) -> tuple[set[Out], set[Out]]:
        """Not told of blocks: the worst moment is not known of a mission with one by text."""
        raise LimitError(f"forced runs through section {self.section.name} take a local graph")

    def objectives(self, moment: Moment, entries: Iterable[Out]) -> Mapping[str, Family]:
        """Cut sets of the block's objectives, the same whenever they run."""
        return self.inside

    def beyond(self, moment: Moment, behind: Behind, entries: Iterable[Out]) -> Family:
        """Cut sets of the mission at the entry, or in every state of the block."""
        if moment is Moment.ENTRY:
            return self._lost(self.succeeding, self.failing, behind)
        return self.text.both(self._lost(well, badly, behind) for well, badly in self._within(self.block))

    def _within(self, block: ParallelSection) -> list[tuple[Family, Family]]:
        """When a block, in each of its states, cannot be left by its success, and by its failure."""
        either = self.families.either
        products = {(Chances(NEVER, NEVER, ALWAYS), True)}  # of no branch yet: all of them have ended
        for branch in block.branches:
            states = self._states(branch)
            products = {self._beside(some, one, branch) for some in products for one in states}
        return sorted({(c.well, either(c.ever, c.badly)) for c, all_ended in products if not all_ended})

    def _lost(self, well: Family, badly: Family, behind: Behind) -> Family:
        either, both = self.families.either, self.families.both
        return both(either(well, behind.success), either(badly, behind.failure))

    def _beside(
        self, some: tuple[Chances, bool], one: tuple[Chances, bool], branch: Branch
    ) -> tuple[Chances, bool]:
        """A state of some branches with a state of one more."""
        either, both = self.families.either, self.families.both
        (well, ever, badly), all_ended = some
        mine, ended = one
        if branch.mandatory:
            badly = both(badly, mine.badly)
        return Chances(either(well, mine.well), either(ever, mine.ever), badly), all_ended and ended

    def _ways(self, section: Section) -> tuple[Family, Family]:
        return self.text.succeeding(section), self.text.failing(section)

    def _states(self, branch: Branch) -> set[tuple[Chances, bool]]:
        """What a branch may still do in each of its states, and whether it has ended there."""
        wanted = (SUCCESS_WANTED if branch.mandatory else ANY_WANTED, ANY_WANTED, FAILURE_WANTED)
        lost = [{**exits, **self.text.sections(branch.graph, exits)} for exits in wanted]
        found: set[tuple[Chances, bool]] = set()
        for section in entered(branch.graph, self._ways):
            if isinstance(section, ElementarySection):
                found.add((Chances(*(of[section.name] for of in lost)), False))
            else:
                for well, badly in self._within(section):
                    behind = (Behind(of[section.success], of[section.failure]) for of in lost)
                    found.add((Chances(*(self._lost(well, badly, b) for b in behind)), False))
        if self.text.branch(branch, SUCCESS_WANTED) != ALWAYS:
            found.add((Chances(NEVER, NEVER, ALWAYS), True))
        if self.text.branch(branch, FAILURE_WANTED) != ALWAYS:
            found.add((Chances(ALWAYS if branch.mandatory else NEVER, NEVER, NEVER), True))
        return found

    def critical_of(self, objective: str, repairs: bool) -> list[CriticalEvent]:
        """Critical events of one of its objectives, for which repairs come too late; modes not told apart."""
        support = self.families.support(self.inside[objective])
        return [
            CriticalEvent(Event(What.OUT_OF_SERVICE, self.hardware[h]), (objective,), {}, 1) for h in support
        ]

    def critical(self, behind: Behind, first: bool) -> list[CriticalEvent]:
        """Not told of blocks without repairs."""
        raise LimitError(f"critical events in section {self.section.name} take a local graph")


def critical_in_diagram(
    placed: PlacedSection,
    good: Zdd,
    traps: Mapping[Outcome, HardwareStates],
    templates: TemplateSet | None,
    *,
    first: bool,
) -> list[CriticalEvent]:
    """Critical events of the mission in a section with a diagram, where hardware may be repaired.

    Args:
        placed: The section.
        good: States inside from which the mission can succeed.
        traps: By outcome, with which states of the section's hardware its end may lose the mission.
        templates: The set of templates; the paper's by default.
        first: Whether the mission begins with this section.

    Returns:
        In the order of the net's transitions; functioning modes, of which there may be as many as states, are
        not told apart.
    """
    local = placed.local
    assert isinstance(local, LocalDiagram), "asked of sections with diagrams"
    own = placed.net(templates)
    bad = (local.inside - good) | placed.ending(traps)
    crossing = list(local.crossing(bad, good))
    if first and good:
        crossing.append((own.start, local.beginnings(local.inside - good)))
    running = own.saying("objective")
    found: dict[tuple[Event, tuple[str, ...]], int] = {}
    for transition, before in sorted(crossing, key=lambda each: each[0]):
        event = own.net.transitions[transition].event
        assert event is not None, "only events lead from one stable state to another"
        for marked, count in local.grouped(before, list(running)):
            key = event, tuple(running[place] for place in marked)
            found[key] = found.get(key, 0) + count
    return [CriticalEvent(event, objectives, {}, edges) for (event, objectives), edges in found.items()]
