"""The mission controller as a finite state machine (paper, 7.3).

"The mission controller receives the events and reads in the graph of the alternatives the actions he must
perform (alternative change, activation / deactivation of activity)." A state is a stable marking; the actions
of an edge are what changes in the functioning mode: activities to stop, then to start, then alternatives to
select. An activity that an objective's end stops and the next objective starts at once is stopped and started
again; one that is started by request and runs before and after the event goes on, whatever the objectives
between (``papers/notes.md``, "Actions of the controller": so actions are a function of stable markings, the
same for every interleaving, and the same for a controller in two levels, whose two lists of actions at a
junction are joined).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from mcpn.check.modes import Situation, situation
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.space.alternatives import AlternativesGraph


@dataclass(frozen=True, slots=True)
class Action:
    """One order of the controller to the robot.

    Args:
        verb: ``stop`` or ``start`` an activity, or ``select`` one of its alternatives.
        activity: The activity.
        alternative: The alternative, for ``select``.
    """

    verb: Literal["stop", "start", "select"]
    activity: str
    alternative: str | None = None


@dataclass(frozen=True, slots=True)
class Edge:
    """What the controller does on an event.

    Args:
        source: Number of the state that it is in.
        event: The event received.
        target: Number of the state that it goes to.
        actions: In order: stops, starts, selections.
    """

    source: int
    event: Event
    target: int
    actions: tuple[Action, ...]


@dataclass(frozen=True)
class Machine:
    """A mission controller.

    Args:
        mission: The mission's name.
        states: What each state is, by number.
        edges: Sorted by source, then in the net's order; at most one for each state and event.
        initial: Number of the initial state.
    """

    mission: str
    states: tuple[Situation, ...]
    edges: tuple[Edge, ...]
    initial: int = 0

    @property
    def events(self) -> tuple[Event, ...]:
        """Every event that the controller reacts to, sorted."""
        return tuple(sorted({edge.event for edge in self.edges}))


def controller(mission_net: MissionNet, alternatives: AlternativesGraph) -> Machine:
    """Generates the controller of a mission.

    Args:
        mission_net: The mission's net.
        alternatives: Its alternatives graph.

    Returns:
        One state for each stable marking, one edge for each event that it allows.
    """
    markings = [alternatives.marking(state) for state in range(alternatives.states)]
    states = tuple(situation(mission_net, marking) for marking in markings)
    edges = []
    for source in range(alternatives.states):
        for label, target in alternatives.successors(source):
            transition = alternatives.net.transitions[label]
            assert transition.event is not None
            restarted = _restarted(mission_net, transition.event, states[source], states[target])
            actions = tuple(_actions(states[source], states[target], restarted))
            edges.append(Edge(source, transition.event, target, actions))
    return Machine(mission_net.mission.name, states, tuple(edges))


def _restarted(mission_net: MissionNet, event: Event, before: Situation, after: Situation) -> frozenset[str]:
    """Activities that this event's objective stops and the objectives after it start again."""
    ended = [event.element] if event.what in (What.SUCCESS, What.FAILURE) else []
    begun = [name for name in after.objectives if name not in before.objectives or name in ended]
    sections = {section.name: section for section in mission_net.graph.walk()}
    stopped = {a for name in ended for a in sections[name].activities}
    started = {a for name in begun for a in sections[name].activities}
    return frozenset(stopped & started) if ended else frozenset()


def _actions(before: Situation, after: Situation, restarted: frozenset[str]) -> Iterator[Action]:
    kept = {a for a in before.mode if a in after.mode and a not in restarted}
    yield from (Action("stop", a) for a in before.mode if a not in kept)
    yield from (Action("start", a) for a in after.mode if a not in kept)
    for activity, alternative in after.mode.items():
        if activity not in kept or before.mode[activity] != alternative:
            yield Action("select", activity, alternative)
