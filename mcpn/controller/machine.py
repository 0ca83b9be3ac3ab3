"""The mission controller as a finite state machine (paper, 7.3).

"The mission controller receives the events and reads in the graph of the alternatives the actions he must
perform (alternative change, activation / deactivation of activity)." A state is a stable marking; the actions
of an edge are what the net's run to completion does to activities (:mod:`mcpn.controller.run`), in a safe
order (:mod:`mcpn.controller.actions`).
"""

from __future__ import annotations

from dataclasses import dataclass

from mcpn.check.verdicts.modes import Situation, situation
from mcpn.controller.actions import Action, Ordering
from mcpn.controller.run import Runner
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.space.stable.alternatives import AlternativesGraph


@dataclass(frozen=True, slots=True)
class Edge:
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
    actions: tuple[Action, ...]


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
    edges: tuple[Edge, ...]
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
    markings = [alternatives.marking(state) for state in range(alternatives.states)]
    packed = [sum(1 << place for place, tokens in enumerate(m) if tokens) for m in markings]
    numbers = {marking: number for number, marking in enumerate(packed)}
    states = tuple(situation(mission_net, marking) for marking in markings)
    runner, ordering = Runner(mission_net), Ordering(mission_net.usage, mission_net.graph)
    edges = []
    for source in range(alternatives.states):
        for label, target in alternatives.successors(source):
            event = alternatives.net.transitions[label].event
            assert event is not None
            passage = runner.fire(packed[source], label)
            # Only a section alone, listed without proof, may end elsewhere: in states that its mission never
            # enters, which are listed too, it need not be confluent.
            if passage.marking != packed[target]:
                assert alternatives.proof is None, "every interleaving ends in the same stable marking"
                target = numbers.get(passage.marking, target)
            actions = tuple(ordering.actions(states[source], states[target], passage))
            edges.append(Edge(source, event, label, target, actions))
    waiting = frozenset(n for n, marking in enumerate(markings) if marking[mission_net.beginning])
    return Machine(mission_net.mission.name, states, tuple(edges), waiting)
