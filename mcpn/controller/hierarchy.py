"""The controller as it is run: sections, each with the machine of its type, and routes between them.

A machine of a section has states *inside* it alone. What is around is the same for every mission and needs no
table: the set of hardware out of service is stored separately, the section is entered by the state of its own
hardware (*entry*), and an edge may *leave* it with an outcome, which the section's routes lead on. Outcomes
are success, failure, abort where a branch of the section may abort, and one for each declared event that
interrupts the section as a whole, and for each condition on facts by which it is left. Hardware that the
section does not use fails and recovers freely.

The *hierarchical* controller has a machine for each type of section: its size is the sum of theirs. The
*flat* controller is the same with one section, the whole mission: its size is a product with all hardware.
Both give the same actions on the same events.

The hierarchical controller keeps the set of handlers with ``once`` that have happened beside the state, as it
keeps the hardware out of service; guards of moves ask for them. In the flat controller the state says it.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import Literal

import numpy as np

from mcpn.answers.verdicts.modes import Situation
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.renaming import Renaming
from mcpn.composite.section_type import SectionType
from mcpn.controller.machine import Machine, PlannedAction, controller, distinct, event_at
from mcpn.controller.moves import Move, Moves
from mcpn.controller.sizes import refuse_entries
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.forgetful import ALWAYS, Guard
from mcpn.drawing.sections import LocalPart
from mcpn.drawing.status import told_as_facts
from mcpn.events import START, Event, What
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.notebook import Drawn
from mcpn.spaces.markings.graph import Ints
from mcpn.spaces.memoized import memoized
from mcpn.spaces.stable.alternatives import AlternativesGraph

KINDS = ("hardware", "objectives", "activities", "alternatives")
"""Kinds of elements that machines speak of in their actions."""

NAMED = (*KINDS, "once", "facts")
"""Kinds of names that differ between sections of one type."""


@dataclass(frozen=True, slots=True)
class Entry:
    """How a section is entered.

    Args:
        target: The first state inside.
        actions: In order.
        gained: What becomes true of facts.
        lost: What is no longer true of them.
    """

    target: int
    actions: tuple[PlannedAction, ...]
    gained: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()


@dataclass(frozen=True)
class SectionMachine:
    """The machine of one type of sections, with the names of the section that stands for it.

    Args:
        hardware: The section's hardware that can fail, by its bit in the numbers of entries.
        events: By number.
        states: What each state inside is.
        entries: By number whose bits say which hardware is out of service, and then what is true of facts;
            ``None`` where no run of the mission enters the section like this.
        moves: Sorted by source, then event.
        once: The section's handlers that happen once.
        facts: What may be true of the section's facts.
        entering: How many of these, the first ones, have a bit in the numbers of entries.
    """

    hardware: tuple[str, ...]
    events: tuple[Event, ...]
    states: tuple[Situation, ...]
    entries: tuple[Entry | None, ...]
    moves: Sequence[Move]
    once: tuple[str, ...] = ()
    facts: tuple[str, ...] = ()
    entering: int = 0


@dataclass(frozen=True)
class PlacedMachine:
    """A section of the mission.

    Args:
        name: Its name.
        type: Number of its type's machine.
        names: By kind (:data:`NAMED`), from names in the type's machine to the section's own; alternatives
            as ``activity.alternative``. A name that is missing stays as it is.
        events: The type's events with the section's own names, by number.
        routes: By outcome, the section entered next, or ``succeed``, ``fail`` or ``abort``.
    """

    name: str
    type: int
    names: Mapping[str, Mapping[str, str]]
    events: tuple[Event, ...]
    routes: Mapping[str, str]


@dataclass(frozen=True)
class TableController(Drawn):
    """A mission controller, flat or hierarchical.

    Args:
        mission: The mission's name.
        form: Which of the two.
        hardware: Hardware that can fail, in the mission's order.
        initial: The section entered at the mission's start.
        sections: In document order.
        types: Their machines.
        minimised: Whether states that cannot be told apart have been merged.
    """

    mission: str
    form: Literal["flat", "hierarchical"]
    hardware: tuple[str, ...]
    initial: str
    sections: tuple[PlacedMachine, ...]
    types: tuple[SectionMachine, ...]
    minimised: bool = False

    def __repr__(self) -> str:
        return f"<{self.form} controller of the mission {self.mission}: {self.size}>"

    @property
    def states(self) -> int:
        """States of all machines."""
        return sum(len(machine.states) for machine in self.types)

    @property
    def moves(self) -> int:
        """Edges of all machines, entries included."""
        return sum(len(machine.moves) + len(machine.entries) for machine in self.types)

    @property
    def size(self) -> str:
        """In words."""
        return (
            f"{len(self.sections)} sections of {len(self.types)} types, "
            f"{self.states} states, {self.moves} edges"
        )


def hierarchical_controller(
    composite: CompositeSpace, listed: Mapping[SectionType, AlternativesGraph]
) -> TableController:
    """Generates the controller of a mission with a machine for each type of section.

    Args:
        composite: The mission's composite.
        listed: By type of section, the alternatives graph of its local net.

    Returns:
        The controller.
    """
    numbers = {type_: number for number, type_ in enumerate(listed)}
    types = [
        section_machine(net, graph, type_.part, guards)
        for type_, graph in listed.items()
        for net, guards in [type_.forgetful()]
    ]
    sections = placed_machines(composite, {type_: types[number].events for type_, number in numbers.items()})
    mission_net = composite.mission_net
    return TableController(
        mission_net.core.name,
        "hierarchical",
        composite.layout.hardware,
        mission_net.graph.entry,
        sections,
        tuple(types),
    )


def placed_machines(
    composite: CompositeSpace, events: Mapping[SectionType, tuple[Event, ...]]
) -> tuple[PlacedMachine, ...]:
    """The sections of a mission, each with the number of its type and its own names.

    Args:
        composite: The mission's composite.
        events: By type of section, in their order, its events.
    """
    numbers = {type_: number for number, type_ in enumerate(events)}
    sections = []
    for placed in composite.sections.values():
        renaming = Renaming(placed.type.part, placed.part)
        names = {kind: dict(getattr(renaming, kind)) for kind in NAMED}
        own = tuple(_renamed(event, names) for event in events[placed.type])
        sections.append(PlacedMachine(placed.name, numbers[placed.type], names, own, dict(placed.routes)))
    return tuple(sections)


def flat_controller(mission_net: MissionNet, alternatives: AlternativesGraph) -> TableController:
    """Generates the controller of a mission as one machine.

    Args:
        mission_net: The mission's net.
        alternatives: Its alternatives graph.

    Returns:
        The controller.
    """
    hardware = tuple(h.name for h in mission_net.core.hardware if h.faulty)
    refuse_entries(hardware)
    machine = inner_machine(controller(mission_net, alternatives), hardware, flags_told(mission_net))
    name = mission_net.core.name
    leads = {"success": SUCCEED, "failure": FAIL, "abort": ABORT}
    routes = {outcome: leads[outcome] for outcome in mission_net.ends}
    whole = PlacedMachine(name, 0, {kind: {} for kind in NAMED}, machine.events, routes)
    return TableController(name, "flat", hardware, name, (whole,), (machine,))


def section_machine(
    local: MissionNet, alternatives: AlternativesGraph, part: LocalPart, guards: Mapping[int, Guard]
) -> SectionMachine:
    """The machine of one section.

    Args:
        local: The net of the section alone, which forgets what has happened once.
        alternatives: Its alternatives graph.
        part: The section.
        guards: Of the net's transitions.

    Raises:
        LimitError: It has more than :data:`MOST_ENTRIES` states of its hardware.
    """
    refuse_entries(part.faulty, part.entry_flags)
    machine = inner_machine(controller(local, alternatives), part.faulty, flags_told(local), guards)
    return replace(machine, once=part.once)


def inner_machine(
    machine: Machine,
    hardware: tuple[str, ...],
    flags: Mapping[str, tuple[int, bool]],
    guards: Mapping[int, Guard] | None = None,
) -> SectionMachine:
    """The inside of a machine: what is before the start and after the end becomes entries and outcomes.

    Args:
        machine: The machine.
        hardware: Its hardware that can fail.
        flags: As of :func:`flags_told`.
        guards: Of the transitions of its net.
    """
    flags_of = _Flags(machine, flags)
    at_entries = (*hardware, *flags_of.at_entries)
    refuse_entries(hardware, flags_of.at_entries)
    graph, transitions = machine.graph, machine.graph.net.transitions
    ended = np.array([state.outcome is not None for state in machine.states], np.bool_)
    within = ~ended
    within[list(machine.waiting)] = False
    inside = np.flatnonzero(within)
    number_of = np.cumsum(within) - 1
    bit = {name: 1 << i for i, name in enumerate(at_entries)}
    entries: list[Entry | None] = [None] * (1 << len(at_entries))
    moving = within[graph.sources]
    labels = np.flatnonzero(np.bincount(graph.labels[moving])).tolist()
    events = tuple(sorted({event_at(graph.net, t) for t in labels}))
    event_of = np.zeros(len(transitions), np.int64)
    for t in labels:
        event_of[t] = bisect_left(events, event_at(graph.net, t))
    edges = np.flatnonzero(moving)
    edges = edges[np.lexsort((event_of[graph.labels[edges]], graph.sources[edges]))]
    sources, targets, labels_of = graph.sources[edges], graph.targets[edges], graph.labels[edges]
    states, lists = machine.states, machine.lists
    numbers: dict[Guard, int] = {ALWAYS: 0}
    guard_of, outcome_of = np.zeros(len(transitions), np.int64), np.zeros(len(states), np.int64)
    for t, guard in (guards or {}).items():
        guard_of[t] = numbers.setdefault(guard, len(numbers))
    outcomes: dict[str, int] = {}
    for number in np.flatnonzero(ended).tolist():
        outcome_of[number] = outcomes.setdefault(_outcome(states[number]), len(outcomes))
    said = flags_of.said
    kinds = np.stack((machine.orders[edges], guard_of[labels_of], said[sources], said[targets]))
    first, kind_of = distinct(kinds)
    by_number = [*numbers]
    done = [
        (lists[order], by_number[guard], *flags_of.changed(was, now))
        for order, guard, was, now in kinds[:, first].T.tolist()
    ]
    to = np.where(ended[targets], -1 - outcome_of[targets], number_of[targets])
    moves = Moves(number_of[sources], event_of[labels_of], to, (*outcomes,), kind_of, done)
    for edge in np.flatnonzero(~moving).tolist():
        if transitions[graph.labels[edge]].event == START:
            source, target = int(graph.sources[edge]), int(graph.targets[edge])
            assert states[target].outcome is None, "a section that is entered has something to do"
            mask = sum(bit[name] for name in (*states[source].out_of_service, *flags_of.of(source)))
            order, changes = int(machine.orders[edge]), flags_of.changes(source, target)
            entries[mask] = Entry(int(number_of[target]), lists[order], *changes)
    within_states = tuple(states[n] for n in inside.tolist())
    names, entering = flags_of.names, len(flags_of.at_entries)
    return SectionMachine(hardware, events, within_states, tuple(entries), moves, (), names, entering)


def flags_told(mission_net: MissionNet) -> dict[str, tuple[int, bool]]:
    """What controllers say of statuses beside hardware and handlers, by its text.

    Each with a place that says so, and whether it does so while it is empty.
    """
    return {flag.text: mission_net.flag_bit(flag) for flag in told_as_facts(mission_net.statuses)}


class _Flags:
    """What is true of statuses (:func:`flags_told`) in states.

    Args:
        machine: The machine.
        flags: Its flags, each with a place that says it, and whether it does so while it is empty.

    Attributes:
        at_entries: Flags that are true in some state before the start.
        names: All flags, those at entries first.
        said: By state, the number of the set of its flags.
    """

    def __init__(self, machine: Machine, flags: Mapping[str, tuple[int, bool]]) -> None:
        marked, before = machine.graph.marked, list(machine.waiting)
        true = {flag: marked(place) != reverse for flag, (place, reverse) in flags.items()}
        self.at_entries = tuple(flag for flag, states in true.items() if states[before].any())
        self.names = (*self.at_entries, *(flag for flag in flags if flag not in self.at_entries))
        # Many states have the same flags, of which there are few.
        states = machine.graph.states
        if true:
            each, numbers = np.unique(np.array([*true.values()]), axis=1, return_inverse=True)
            self._sets = [frozenset(compress(true, column)) for column in each.T.tolist()]
            self.said: Ints = numbers.reshape(-1).astype(np.int64)
        else:
            self._sets, self.said = [frozenset()], np.zeros(states, np.int64)

    def of(self, number: int) -> frozenset[str]:
        """The flags that are true in a state."""
        return self._sets[int(self.said[number])]

    def changes(self, before: int, after: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The flags that become true from one state to another, and those that become false."""
        return self.changed(int(self.said[before]), int(self.said[after]))

    @memoized
    def changed(self, was: int, now: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The flags that become true from one set of flags to another, and those that become false."""
        before, after = self._sets[was], self._sets[now]
        return tuple(sorted(after - before)), tuple(sorted(before - after))


def _outcome(state: Situation) -> str:
    assert state.outcome is not None, "asked of what has ended"
    return state.outcome


_KIND_OF_ELEMENT = {
    What.SUCCESS: "objectives",
    What.FAILURE: "objectives",
    What.TIMEOUT: "objectives",
    What.OUT_OF_SERVICE: "hardware",
    What.DETECTED: "hardware",
    What.REPAIRED: "hardware",
}


def _renamed(event: Event, names: Mapping[str, Mapping[str, str]]) -> Event:
    """An event of a type with the names of one of its sections; an event of no element stays as it is."""
    kind = _KIND_OF_ELEMENT.get(event.what)
    return event if kind is None else event.of(names[kind].get(event.element, event.element))
