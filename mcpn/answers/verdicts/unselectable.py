"""Elements of a mission that are never selected, entered, left or used in any of its reachable states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from mcpn.answers.verdicts.entered import selected_and_entered
from mcpn.answers.verdicts.routing import Routing
from mcpn.drawing.compose import MissionNet
from mcpn.errors import Problem
from mcpn.mission.static.usage import Usage
from mcpn.mission.static.warnings import in_order, never_entered, never_used, of_objectives
from mcpn.nets.events import Event, What
from mcpn.spaces.algebra import S, Space


class Never(NamedTuple):
    """What is suspicious in the states of a mission, each with its line.

    Args:
        unselectable: Alternatives never selected, objectives never entered or never left, resources never
            used.
        futile: Objectives and blocks whose success leads only to failure.
    """

    unselectable: tuple[Problem, ...] = ()
    futile: tuple[Problem, ...] = ()


def never_happens(mission_net: MissionNet, space: Space[S], firings: Mapping[int, int]) -> Never:
    """What of a mission never happens.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
        firings: By transition how often it fires between them.
    """
    usage, mission = mission_net.usage, mission_net.mission
    transitions = mission_net.net.transitions
    events = (transitions[t].event for t, count in firings.items() if count)
    happens = {event for event in events if event is not None}
    selected, entered = selected_and_entered(mission_net, space)
    sections = list(usage.graph.walk())
    begun = {activity for section in sections if section.name in entered for activity in section.activities}
    running = frozenset[str]().union(*map(usage.closure, begun))
    problems, used = list[Problem](), set[str]()
    for activity in mission.activities:
        if activity.name not in usage.started:
            continue
        for alternative in activity.alternatives:
            name = f"{activity.name}.{alternative.name}"
            # Where no objective with the activity is entered, these are reported, not its alternatives.
            if name in selected or activity.name not in running:
                used.update(alternative.consumes)
            else:
                why = _held(usage, activity.name, alternative.consumes)
                problems.append(Problem(alternative.source, f"alternative {name} can never be selected{why}"))
    routing = Routing(usage.graph, entered, happens, mission)
    problems.extend(routing.never_entered())
    for what, verb in ((What.SUCCESS, "succeed"), (What.FAILURE, "fail")):
        never = (s for s in sections if s.name in entered and Event(what, s.name) not in happens)
        problems.extend(of_objectives(usage, never, f"can never {verb}"))
    problems.extend(never_entered(usage))
    problems.extend(never_used(mission, used))
    return Never(tuple(in_order(problems)), tuple(in_order(routing.futile())))


def _held(usage: Usage, activity: str, consumed: Sequence[str]) -> str:
    """Why it is never selected, where its activity serves another that holds what it consumes."""
    for contention in usage.contentions:
        above = [name for name in contention.rivals if name != activity]
        if contention.wanted in consumed and len(above) == 1 and activity in usage.closure(above[0]):
            return f": {above[0]}, which it serves, has {contention.wanted} already"
    return ""
