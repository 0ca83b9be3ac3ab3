"""What of a mission can never be selected, entered, left or used, as its states tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mcpn.errors import Problem
from mcpn.mission.facts.usage import Usage
from mcpn.mission.facts.warnings import in_order, never_entered, never_used, of_objectives
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.space.algebra import S, Space


def unselectable(mission_net: MissionNet, space: Space[S], firings: Mapping[int, int]) -> tuple[Problem, ...]:
    """Alternatives never selected, objectives never entered or never left, resources never used."""
    usage, mission = mission_net.usage, mission_net.mission
    transitions = mission_net.net.transitions
    happens = {transitions[t].event for t, count in firings.items() if count}
    selected, entered = (
        {name for place, name in mission_net.saying(kind).items() if space.marked([place]) & space.stable}
        for kind in ("active", "objective")
    )
    found, used = list[Problem](), set[str]()
    for activity in mission.activities:
        if activity.name not in usage.started:
            continue
        for alternative in activity.alternatives:
            name = f"{activity.name}.{alternative.name}"
            if name in selected:
                used.update(alternative.consumes)
            else:
                why = _held(usage, activity.name, alternative.consumes)
                found.append(Problem(alternative.source, f"alternative {name} can never be selected{why}"))
    sections = list(usage.graph.walk())
    found.extend(of_objectives((s for s in sections if s.name not in entered), "can never be entered"))
    for what, verb in ((What.SUCCESS, "succeed"), (What.FAILURE, "fail")):
        never = (s for s in sections if s.name in entered and Event(what, s.name) not in happens)
        found.extend(of_objectives(never, f"can never {verb}"))
    found.extend(never_entered(usage.graph.never_entered()))
    for resource in (*mission.hardware, *mission.software):
        if resource.name not in used:
            found.append(never_used(resource))
    return tuple(in_order(found))


def _held(usage: Usage, activity: str, consumed: Sequence[str]) -> str:
    """Why an alternative is never selected, where its activity serves one that has what it consumes."""
    for contention in usage.contentions:
        above = [name for name in contention.rivals if name != activity]
        if contention.wanted in consumed and len(above) == 1 and activity in usage.closure(above[0]):
            return f": {above[0]}, which it serves, has {contention.wanted} already"
    return ""
