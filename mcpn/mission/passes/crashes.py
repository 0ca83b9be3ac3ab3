"""What may crash consumes what stands for that: out of service after a crash, and lost only while it runs.

There is one such resource for each activity, and for each alternative, that may crash. Nobody else consumes
it, and it can fail only while the activity runs, which is why it is no hardware as robots declare it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Alternative, Crash

_NEVER: dict[str, Any] = {"faulty": False, "recovers": True, "failure_rate": None, "repair_rate": None}


def crashes(mission: Mission) -> Mission:
    """Activities and alternatives that may crash consume what stands for that (`faulty`)."""
    found = {robot.name: tuple(_standing_for(robot.activities)) for robot in mission.robots}
    if not any(found.values()):
        return mission
    robots = (
        replace(
            robot,
            crashes=(*robot.crashes, *found[robot.name]),
            activities=tuple(_consuming(activity) for activity in robot.activities),
        )
        for robot in mission.robots
    )
    return replace(mission, robots=tuple(robots))


def _standing_for(activities: tuple[Activity, ...]) -> Iterator[Crash]:
    for activity in activities:
        if activity.faulty:
            yield _crash(activity.name, activity, activity)
        for way in activity.alternatives:
            if way.faulty:
                yield _crash(f"{activity.name}.{way.name}", activity, way)


def _crash(name: str, activity: Activity, crashing: Activity | Alternative) -> Crash:
    return Crash(
        name=name,
        description=crashing.description,
        repairable=crashing.recovers,
        failure_rate=crashing.failure_rate,
        repair_rate=crashing.repair_rate,
        source=crashing.source,
        activity=activity.name,
    )


def _consuming(activity: Activity) -> Activity:
    """An activity that never crashes by itself: it and its alternatives lose what stands for that."""
    ways = []
    for way in activity.alternatives:
        own = [activity.name] * activity.faulty + [f"{activity.name}.{way.name}"] * way.faulty
        ways.append(replace(way, consumes=(*way.consumes, *own), **_NEVER) if own else way)
    return replace(activity, alternatives=tuple(ways), **_NEVER)
