"""Common causes become hardware of their own, which all that uses affected hardware consumes too.

One event takes several hardware resources out of service. Every alternative that consumes one of them also
consumes the shared resource that stands for the cause. So the cause fails and is repaired as hardware is,
every user of affected hardware gets the error, and the affected hardware may still fail by itself.

Source: K. N. Fleming, *A reliability model for common mode failures in redundant safety systems*, 1975.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Fault, Hardware


def faults(mission: Mission) -> Mission:
    """Common causes become shared hardware that users of what they affect consume too (`<fault>`)."""
    causes = mission.faults
    if not causes:
        return mission
    robots = [
        replace(
            robot, faults=(), activities=tuple(_consuming(activity, causes) for activity in robot.activities)
        )
        for robot in mission.robots
    ]
    # Behind all that robots declare, of whichever robot it is.
    robots[-1] = replace(robots[-1], hardware=(*robots[-1].hardware, *map(_standing_for, causes)))
    return replace(mission, robots=tuple(robots))


def _standing_for(fault: Fault) -> Hardware:
    return Hardware(
        name=fault.name,
        description=fault.description,
        shared=True,
        affects=fault.affects,
        repairable=fault.repairable,
        failure_rate=fault.failure_rate,
        repair_rate=fault.repair_rate,
        source=fault.source,
    )


def _consuming(activity: Activity, causes: Sequence[Fault]) -> Activity:
    """An activity whose alternatives also consume what may take their hardware out of service."""
    ways = []
    for way in activity.alternatives:
        met = [cause.name for cause in causes if not set(cause.affects).isdisjoint(way.consumes)]
        ways.append(replace(way, consumes=(*way.consumes, *met)) if met else way)
    return replace(activity, alternatives=tuple(ways))
