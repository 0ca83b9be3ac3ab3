"""Loss functions of one section of a mission: from its local graph, or from the mission's text.

Hardware that a section does not use is an element that its own functions do not depend on, and is never
enumerated; what is lost behind the section's ends may depend on it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from mcpn.check.availability import Availability
from mcpn.check.cutsets import Losses, Moment
from mcpn.check.families import ALWAYS, NEVER, Family
from mcpn.check.losing import CriticalEvent, Goal, Outlook
from mcpn.mission.flatten import Section
from mcpn.mission.model import FAIL
from mcpn.net.events import Event, What
from mcpn.net.templates import TemplateSet
from mcpn.space.graph import Mask
from mcpn.space.local.placing import PlacedSection
from mcpn.space.local.protocol import Outcome

Out = frozenset[int]
"""Elements that are out of service."""


class Behind(NamedTuple):
    """What the mission loses behind the two ends of a section."""

    success: Family
    failure: Family
    by_mask: Mapping[Outcome, Sequence[Family]] | None = None
    """The same by the mask of the section's hardware that is out of service at its end, where that counts."""


class SectionLosses(Protocol):
    """The loss functions of one section, as far as composition needs to know them."""

    section: Section
    here: Out
    """The hardware that it may use."""

    @property
    def succeeding(self) -> Family:
        """When the section, entered with hardware out of service, cannot be left by its success."""

    @property
    def failing(self) -> Family:
        """When it cannot be left by its failure."""

    def exits(self, out: Out) -> tuple[set[Out], set[Out]]:
        """What is out of service when forced runs from an entry leave by success, and by failure."""

    def objectives(self, moment: Moment, entries: Iterable[Out]) -> Mapping[str, Family]:
        """Cut sets of the section's objectives; entries are those of forced runs, for ``SOMETIME``."""

    def beyond(self, moment: Moment, behind: Behind, entries: Iterable[Out]) -> Family:
        """Cut sets of the mission in the states of the section that a moment asks for."""

    def critical_of(self, objective: str, repairs: bool) -> list[CriticalEvent]:
        """Critical events of one of its objectives, with or without repairs."""

    def critical(self, behind: Behind, first: bool) -> list[CriticalEvent]:
        """Critical events of the mission in the section, without repairs; before it too where it is first."""


class GraphSection:
    """A section on the local graph of its type, told in its own names.

    Args:
        placed: The section with the graph of its type.
        text: The mission's hardware as elements.
        templates: The set of templates; the paper's by default.
    """

    def __init__(self, placed: PlacedSection, text: Availability, templates: TemplateSet | None) -> None:
        self.section = placed.section
        self.placed = placed
        self.families = text.families
        self.hardware = text.hardware
        # Nets of one type are the same but for names, place by place and transition by transition.
        own = placed.net(templates)
        self.outlook = Outlook(own, replace(placed.listed.graph, net=own.net))
        self.losses = Losses(self.outlook, text.families, text.hardware)
        self.here: Out = frozenset(self.losses.elements)
        self.reached = np.ones(self.outlook.graph.states, np.bool_)
        """States that the mission reaches, those before and after the section among them."""

    @property
    def goals(self) -> Mapping[str, Goal]:
        """Success of each of its objectives, in states that the mission reaches."""
        found = self.outlook.objectives.items()
        return {name: replace(goal, running=goal.running & self.reached) for name, goal in found}

    @cached_property
    def succeeding(self) -> Family:
        """When the section cannot be left by its success."""
        return self.losses.cut_sets(self.outlook.mission, Moment.START)

    @cached_property
    def failing(self) -> Family:
        """When the section cannot be left by its failure."""
        failed = self.placed.listed.ended["failure"].mask
        goal = Goal("mission", "failure", ~failed, failed, self.outlook.allowed(True))
        return self.losses.cut_sets(goal, Moment.START)

    # --- forced runs -----------------------------------------------------------------------------------

    def after_entry(self, out: Out) -> Mask:
        """States after forced runs from the entry with some hardware out of service."""
        mask = sum(1 << i for i, name in enumerate(self.placed.faulty) if self.hardware.index(name) in out)
        return self.losses.after_forced(int(self.placed.listed.entry[mask]))

    def exits(self, out: Out) -> tuple[set[Out], set[Out]]:
        """What is out of service when forced runs from an entry leave by success, and by failure."""
        graph, usable = (
            self.outlook.graph,
            self.outlook.forced & self.after_entry(out)[self.outlook.graph.sources],
        )
        well, badly = (
            {self.losses.out(s) | out - self.here for s in graph.targets[edges[usable[edges]]].tolist()}
            for edges in self.placed.listed.leaving.values()
        )
        return well, badly

    def _at_worst(self, goal: Goal, entries: Iterable[Out]) -> Family:
        found, begun = NEVER, goal.running & self.outlook.begun
        for out in entries:
            lost = self.losses.in_some(goal, begun & self.after_entry(out))
            found = self.families.either(found, self.families.both(self.families.all_of(out), lost))
        return found

    # --- goals -----------------------------------------------------------------------------------------

    def objectives(self, moment: Moment, entries: Iterable[Out]) -> Mapping[str, Family]:
        """Cut sets of the section's objectives."""
        if moment is Moment.SOMETIME:
            known = list(entries)
            return {name: self._at_worst(goal, known) for name, goal in self.goals.items()}
        return {name: self.losses.cut_sets(goal, moment, name) for name, goal in self.goals.items()}

    def beyond(self, moment: Moment, behind: Behind, entries: Iterable[Out]) -> Family:
        """Cut sets of the mission in the states of the section that a moment asks for."""
        goal = self._led_on(behind)
        if moment is Moment.SOMETIME:
            return self._at_worst(goal, entries)
        return self.losses.cut_sets(goal, moment, self.section.name)

    def _led_on(self, behind: Behind) -> Goal:
        """The mission's success as a goal on the local graph, its ends told what comes behind."""
        local = self.placed.listed
        success, failure = local.ended["success"].mask, local.ended["failure"].mask
        # A mission that has failed is lost, as on the whole graph; one that has gone on is told of behind.
        failed = np.zeros_like(success)
        for route, ended in ((self.section.success, success), (self.section.failure, failure)):
            failed |= ended if route == FAIL else False
        ended = success | failure
        # What follows an end belongs to the next section.
        along = ~ended[self.outlook.graph.sources]
        goal = Goal("mission", "beyond", (~ended | failed) & self.reached, ended, along)
        ends = [(success, behind.success), (failure, behind.failure)]
        if behind.by_mask is not None:
            ends = [
                (local.ended[outcome].mask & (local.out_of_service == mask), lost)
                for outcome, by_mask in behind.by_mask.items()
                for mask, lost in enumerate(by_mask)
            ]
        self.losses.lead_on(goal, ends)
        return goal

    def at_start(self, behind: Behind) -> Family:
        """Cut sets of the mission before it begins with this section."""
        return self.losses.in_every(self._led_on(behind), ~self.outlook.begun)

    def entering(self, behind: Behind) -> list[Family]:
        """When the mission is lost just after the entry, by the mask of the hardware out of service there."""
        functions = self.losses.functions(self._led_on(behind))
        return [functions[state] for state in self.placed.listed.entry.tolist()]

    def lost_behind(self, behind: Behind) -> list[Family]:
        """By state, when the mission is lost without repairs, as a function of the hardware not used here."""
        functions, families = self.losses.functions(self._led_on(behind)), self.families
        others = frozenset(range(families.elements)) - self.here
        return [
            families.inside(families.assuming(loss, self.losses.out(s)), others)
            for s, loss in enumerate(functions)
        ]

    # --- critical events -------------------------------------------------------------------------------

    def critical_of(self, objective: str, repairs: bool) -> list[CriticalEvent]:
        """Critical events of one of its objectives, with or without repairs."""
        return self.outlook.critical(self.goals[objective], repairs)

    def critical(self, behind: Behind, first: bool) -> list[CriticalEvent]:
        """Critical events of the mission in the section, without repairs.

        A failure of hardware that the section does not use is critical where the loss behind the section's
        ends depends on it.
        """
        goal, outlook, graph, families = self._led_on(behind), self.outlook, self.outlook.graph, self.families
        lost = self.lost_behind(behind)
        chance = goal.running & np.array([loss != ALWAYS for loss in lost], np.bool_)
        if not first:
            chance &= outlook.begun
        ends = zip(graph.sources.tolist(), graph.targets.tolist(), strict=True)
        worse = [chance[a] and families.either(lost[a], lost[b]) != lost[a] for a, b in ends]
        crossing = np.flatnonzero(outlook.allowed(False) & np.array(worse, np.bool_)).tolist()
        besides = [
            (Event(What.OUT_OF_SERVICE, self.hardware[h]), state)
            for state in np.flatnonzero(chance).tolist()
            for h in families.support(lost[state])
        ]
        return self.outlook.grouped([*self._named(crossing), *besides])

    def _named(self, edges: Iterable[int]) -> Iterator[tuple[Event, int]]:
        """Events of some edges with the states before them."""
        graph = self.outlook.graph
        for edge in edges:
            event = graph.net.transitions[int(graph.labels[edge])].event
            assert event is not None, "only events label the alternatives graph"
            yield event, int(graph.sources[edge])

    def critical_with_repairs(
        self, good: Mask, traps: Mapping[Outcome, Mask], first: bool
    ) -> list[CriticalEvent]:
        """Critical events of the mission in the section where hardware may be repaired.

        Args:
            good: States from which the mission can succeed, shape (states,).
            traps: By outcome, with which masks of the section's hardware its end may lose the mission, shape
                (masks,).
            first: Whether the mission begins with this section.
        """
        local, graph = self.placed.listed, self.outlook.graph
        crossing = local.edges_inside & good[graph.sources] & ~good[graph.targets]
        for outcome, edges in local.leaving.items():
            after = local.out_of_service[graph.targets[edges]]
            crossing[edges] = good[graph.sources[edges]] & traps[outcome][after]
        if first and good[local.entry].any():
            crossing |= (
                local.before.mask[graph.sources] & local.inside.mask[graph.targets] & ~good[graph.targets]
            )
        return self.outlook.grouped(self._named(np.flatnonzero(crossing).tolist()))
