"""Runs in mission words, event by event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcpn.check.modes import Situation, situation
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.net.petri import PetriNet
from mcpn.space.graph import StateGraph


@dataclass(frozen=True)
class Step:
    """One event of a run, or one internal firing where a run shows the net's own behaviour.

    Args:
        event: The event; for an internal firing the transition's name.
        words: The same for a reader: what happens, and what changes in the functioning mode.
    """

    event: Event | str
    words: str


def run_in_words(mission_net: MissionNet, graph: StateGraph, run: Sequence[int]) -> list[Step]:
    """Tells a run of a graph.

    Args:
        mission_net: The mission's net.
        graph: Its alternatives graph, or its markings graph (then only the events are told).
        run: Indices of edges, from the initial state on.

    Returns:
        A step for each event.
    """
    return replay(mission_net, [graph.net.transitions[int(graph.labels[e])].name for e in run])


def replay(mission_net: MissionNet, firings: Sequence[str]) -> list[Step]:
    """Tells a sequence of firings; internal evolution left out of it is completed along one interleaving.

    Args:
        mission_net: The mission's net.
        firings: Names of transitions from the initial marking on, events with or without the internal ones
            between them.

    Returns:
        A step for each event, with the changes up to the next one.
    """
    net = mission_net.net
    marking = net.initial
    steps: list[Step] = []
    pending: tuple[Event, Situation] | None = None
    mission = mission_net.mission.name
    for name in firings:
        transition = net.transitions[net.transition_index[name]]
        if transition.event is not None:
            marking = stabilise(net, marking)
            if pending:
                steps.append(step_in_words(mission, *pending, situation(mission_net, marking)))
            pending = transition.event, situation(mission_net, marking)
        marking = net.fire(marking, net.transition_index[name])
    if pending:
        steps.append(step_in_words(mission, *pending, situation(mission_net, stabilise(net, marking))))
    return steps


def stabilise(net: PetriNet, marking: Sequence[int]) -> tuple[int, ...]:
    """Fires internal transitions, the first enabled each time, until none is.

    The caller knows that internal evolution ends; a marking that comes back stops it all the same.
    """
    at = tuple(marking)
    seen: set[tuple[int, ...]] = set()
    while at not in seen:
        seen.add(at)
        enabled = net.enabled(at)
        if not enabled or not net.transitions[enabled[0]].internal:
            return at
        at = net.fire(at, enabled[0])
    return at


def step_in_words(mission: str, event: Event, before: Situation, after: Situation) -> Step:
    """An event with what it changes.

    Args:
        mission: The mission's name.
        event: The event.
        before: What the robot did before it.
        after: What it does afterwards.
    """
    words = what_happens(event, mission)
    changed = changes(before, after)
    return Step(event, f"{words}: {', '.join(changed)}" if changed else words)


def what_happens(event: Event, mission: str) -> str:
    """An event in mission words.

    Args:
        event: The event.
        mission: The mission's name.

    Returns:
        For example "GPS_sensor fails".
    """
    name = event.element
    match event.what:
        case What.START:
            return f"mission {mission} starts"
        case What.SUCCESS:
            return f"objective {name} succeeds"
        case What.FAILURE:
            return f"objective {name} fails"
        case What.OUT_OF_SERVICE:
            return f"{name} fails"
        case What.LOST:
            return f"{event.element} is lost for good"
        case What.REPAIRED:
            return f"{name} works again"
        case What.DECLARED:
            return f"event {name} happens"
        case What.NAMED:
            return name


def changes(before: Situation, after: Situation) -> list[str]:
    """What changes from one stable marking to the next, in mission words."""
    found = [f"{name} begins" for name in after.objectives if name not in before.objectives]
    for activity, alternative in after.mode.items():
        was = before.mode.get(activity)
        if was is not None and was != alternative:
            found.append(f"{activity} changes from {was} to {alternative}")
        elif was is None and alternative != activity:
            found.append(f"{activity} runs as {alternative}")
    found += [f"{name} has no way to run" for name in after.refused if name not in before.refused]
    found += [f"{name} waits" for name in after.waiting if name not in before.waiting]
    if after.outcome and not before.outcome:
        found.append(f"the mission ends in {after.outcome}")
    return found
