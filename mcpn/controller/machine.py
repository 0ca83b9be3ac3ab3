"""The mission controller as a finite state machine (paper, 7.3).

"The mission controller receives the events and reads in the graph of the alternatives the actions he must
perform (alternative change, activation / deactivation of activity)." A state is a stable marking; the actions
of an edge are what the net's run to completion does to activities (:mod:`mcpn.controller.run`), in a safe
order (:mod:`mcpn.controller.actions`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from mcpn.answers.verdicts.modes import Situation, said_by
from mcpn.controller.actions import Ordering, PlannedAction
from mcpn.controller.run import Left, Runner
from mcpn.drawing.compose import MissionNet
from mcpn.nets.events import Event
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.graph import Ints
from mcpn.spaces.stable.alternatives import AlternativesGraph


@dataclass(frozen=True, slots=True)
class MachineEdge:
    """What the controller does on an event.

    Args:
        source: Number of the state that it is in.
        event: The event received.
        transition: The net's transition of it.
        target: Number of the state that it goes to.
        actions: In order: stops, releases, selections, starts.
    """

    source: int
    event: Event
    transition: int
    target: int
    actions: tuple[PlannedAction, ...]


@dataclass(frozen=True, eq=False)
class Machine:
    """A mission controller with a state for each stable marking, its edges in arrays.

    Args:
        mission: The mission's name.
        states: What each state is, by number.
        graph: The alternatives graph, whose edges they are: sorted by source, then in the net's order; at
            most one for each state and event, but in a net that forgets (:mod:`mcpn.drawing.mortal`).
        orders: By edge, the number of its list of actions.
        lists: By number, actions in order: stops, releases, selections, starts.
        waiting: Numbers of the states before the mission's start.
        initial: Number of the initial state.
    """

    mission: str
    states: tuple[Situation, ...]
    graph: AlternativesGraph
    orders: Ints
    lists: Sequence[tuple[PlannedAction, ...]]
    waiting: frozenset[int]
    initial: int = 0

    @cached_property
    def edges(self) -> tuple[MachineEdge, ...]:
        """What the controller does, one by one."""
        graph = self.graph
        columns = (graph.sources, graph.labels, graph.targets, self.orders)
        return tuple(
            MachineEdge(source, event_at(graph.net, label), label, target, self.lists[order])
            for source, label, target, order in zip(*(c.tolist() for c in columns), strict=True)
        )

    @property
    def events(self) -> tuple[Event, ...]:
        """Every event that the controller reacts to, sorted."""
        labels = np.flatnonzero(np.bincount(self.graph.labels)).tolist()
        return tuple(sorted({event_at(self.graph.net, label) for label in labels}))


def controller(mission_net: MissionNet, alternatives: AlternativesGraph) -> Machine:
    """Generates the controller of a mission, or of a section of one.

    Args:
        mission_net: The net of the mission, or of the section alone.
        alternatives: Its alternatives graph.

    Returns:
        One state for each stable marking, one edge for each event that it allows.
    """
    packed = [int.from_bytes(row.tobytes(), "little") for row in alternatives.markings]
    states = situations(mission_net, packed)
    ordered = Ordered(mission_net, states)
    passed, passages = Runner(mission_net).passages(alternatives)
    alike = np.array(ordered.alike, np.int64)
    kinds = np.stack((alike[alternatives.sources], alike[alternatives.targets], passed))
    first, orders = distinct(kinds)
    lists = [
        ordered.actions(source, target, passages[number])
        for source, target, number in zip(
            alternatives.sources[first].tolist(),
            alternatives.targets[first].tolist(),
            passed[first].tolist(),
            strict=True,
        )
    ]
    beginning = 1 << mission_net.beginning
    waiting = frozenset(n for n, marking in enumerate(packed) if marking & beginning)
    return Machine(mission_net.mission.name, states, alternatives, orders, lists, waiting)


def distinct(columns: Ints) -> tuple[Ints, Ints]:
    """The distinct ones of some columns of numbers that are not negative.

    Returns:
        By number of a distinct column, where it stands first, and by column its number.
    """
    found = np.zeros(columns.shape[1], np.int64)
    first = np.zeros(min(columns.shape[1], 1), np.int64)
    for row in columns:  # pairs of what was found and the next row fit 64 bits
        pairs = found * (row.max(initial=0) + 1) + row
        order = np.argsort(pairs, kind="stable")
        new = np.diff(pairs[order], prepend=-1) != 0
        first, found[order] = order[new], np.cumsum(new) - 1
    return first, found


def event_at(net: PetriNet, label: int) -> Event:
    """The event of a transition that an alternatives graph is labelled with."""
    event = net.transitions[label].event
    assert event is not None, "only event transitions label the alternatives graph"
    return event


def situations(mission_net: MissionNet, packed: Sequence[int]) -> tuple[Situation, ...]:
    """The situations of markings, which are integers with a bit for each place; equal ones are one object."""
    with_role = sorted(mission_net.roles)
    mask = sum(1 << place for place in with_role)

    @cache
    def said(marked: int) -> Situation:
        return said_by(mission_net, [place for place in with_role if marked >> place & 1])

    return tuple(said(marking & mask) for marking in packed)


class Ordered:
    """The actions of events, in order; computed once for all edges that determine the same actions.

    Args:
        mission_net: The net.
        states: What each state is.
    """

    def __init__(self, mission_net: MissionNet, states: Sequence[Situation]) -> None:
        self._ordering = Ordering(mission_net.usage, mission_net.graph)
        self._states = states
        numbers: dict[object, int] = {}
        self.alike = [
            numbers.setdefault((s.objectives, s.pending, s.done, tuple(s.mode.items())), len(numbers))
            for s in states
        ]
        """By state, the number of all that actions depend on."""
        self._known: dict[object, tuple[PlannedAction, ...]] = {}

    def actions(self, source: int, target: int, passage: Left) -> tuple[PlannedAction, ...]:
        """The actions of an event between two states."""
        key = self.alike[source], self.alike[target], passage.left, passage.idled, passage.ended
        if key not in self._known:
            before, after = self._states[source], self._states[target]
            self._known[key] = tuple(self._ordering.actions(before, after, passage))
        return self._known[key]
