"""The mission controller as a finite state machine (paper, 7.3).

"The mission controller receives the events and reads in the graph of the alternatives the actions he must
perform (alternative change, activation / deactivation of activity)." A state is a stable marking; the actions
of an edge are what the net's run to completion does to activities (:mod:`mcpn.controller.run`), in a safe
order (:mod:`mcpn.controller.actions`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from mcpn.check.verdicts.modes import Situation, said_by
from mcpn.controller.actions import Ordering, PlannedAction
from mcpn.controller.run import Passage, Runner
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.space.stable.alternatives import AlternativesGraph


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


@dataclass(frozen=True)
class Machine:
    """A mission controller with a state for each stable marking.

    Args:
        mission: The mission's name.
        states: What each state is, by number.
        edges: Sorted by source, then in the net's order; at most one for each state and event, but in a net
            that forgets (:mod:`mcpn.net.forgetful`).
        waiting: Numbers of the states before the mission's start.
        initial: Number of the initial state.
    """

    mission: str
    states: tuple[Situation, ...]
    edges: tuple[MachineEdge, ...]
    waiting: frozenset[int]
    initial: int = 0

    @property
    def events(self) -> tuple[Event, ...]:
        """Every event that the controller reacts to, sorted."""
        return tuple(sorted({edge.event for edge in self.edges}))


def controller(mission_net: MissionNet, alternatives: AlternativesGraph) -> Machine:
    """Generates the controller of a mission, or of a section of one.

    Args:
        mission_net: The net of the mission, or of the section alone.
        alternatives: Its alternatives graph.

    Returns:
        One state for each stable marking, one edge for each event that it allows.
    """
    packed = [int.from_bytes(row.tobytes(), "little") for row in alternatives.markings]
    numbers = {marking: number for number, marking in enumerate(packed)}
    states = situations(mission_net, packed)
    runner, ordering = Runner(mission_net), Ordered(mission_net, states)
    offsets, targets = alternatives.offsets.tolist(), alternatives.targets.tolist()
    labels, transitions = alternatives.labels.tolist(), alternatives.net.transitions
    edges = []
    for source, marking in enumerate(packed):
        for number in range(offsets[source], offsets[source + 1]):
            label, target = labels[number], targets[number]
            event = transitions[label].event
            assert event is not None
            passage = runner.fire(marking, label)
            # Only a section alone, listed without proof, may end elsewhere: in states that its mission never
            # enters, which are listed too, it need not be confluent.
            if passage.marking != packed[target]:
                assert alternatives.proof is None, "every interleaving ends in the same stable marking"
                target = numbers.get(passage.marking, target)
            edges.append(MachineEdge(source, event, label, target, ordering.actions(source, target, passage)))
    beginning = 1 << mission_net.beginning
    waiting = frozenset(n for n, marking in enumerate(packed) if marking & beginning)
    return Machine(mission_net.mission.name, states, tuple(edges), waiting)


def situations(mission_net: MissionNet, packed: Sequence[int]) -> tuple[Situation, ...]:
    """What some markings say, a bit for each place; those that say the same share it."""
    speaking = sorted(mission_net.roles)
    mask = sum(1 << place for place in speaking)

    @cache
    def said(marked: int) -> Situation:
        return said_by(mission_net, [place for place in speaking if marked >> place & 1])

    return tuple(said(marking & mask) for marking in packed)


class Ordered:
    """The actions of events; those with the same reasons are put in order once.

    Args:
        mission_net: The net.
        states: What each state is.
    """

    def __init__(self, mission_net: MissionNet, states: Sequence[Situation]) -> None:
        self._ordering = Ordering(mission_net.usage, mission_net.graph)
        self._states = states
        numbers: dict[object, int] = {}
        self._alike = [
            numbers.setdefault((s.objectives, s.pending, s.done, tuple(s.mode.items())), len(numbers))
            for s in states
        ]
        """By state, the number of all that actions depend on."""
        self._known: dict[object, tuple[PlannedAction, ...]] = {}

    def actions(self, source: int, target: int, passage: Passage) -> tuple[PlannedAction, ...]:
        """The actions of an event between two states."""
        key = self._alike[source], self._alike[target], passage.left, passage.idled
        if key not in self._known:
            before, after = self._states[source], self._states[target]
            self._known[key] = tuple(self._ordering.actions(before, after, passage))
        return self._known[key]
