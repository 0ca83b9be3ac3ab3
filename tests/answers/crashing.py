"""Missions with hardware in the place of what may crash: the same but that hardware also fails while idle."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot

Crashing = TypeVar("Crashing", Activity, Alternative)


def with_hardware(mission: Mission) -> tuple[Mission, dict[str, str]]:
    """Each crash as hardware that its alternatives consume last, and the name of each crash by that of it."""
    names: dict[str, str] = {}
    return replace(mission, robots=tuple(_robot(robot, names) for robot in mission.robots)), names


def _never_crashing(of: Crashing) -> Crashing:
    return replace(of, faulty=False, recovers=True, failure_rate=None, repair_rate=None)


def _robot(robot: Robot, names: dict[str, str]) -> Robot:
    added: list[Hardware] = []

    def made(of: Activity | Alternative, crash: str) -> tuple[str, ...]:
        if not of.faulty:
            return ()
        name = f"x{len(names)}"
        names[name] = crash
        said = Hardware(
            name=name, repairable=of.recovers, failure_rate=of.failure_rate, repair_rate=of.repair_rate
        )
        added.append(said)
        return (name,)

    def sound(activity: Activity) -> Activity:
        whole = made(activity, activity.name)
        ways = []
        for way in activity.alternatives:
            own = made(way, f"{activity.name}.{way.name}")
            ways.append(replace(_never_crashing(way), consumes=(*way.consumes, *whole, *own)))
        return replace(_never_crashing(activity), alternatives=tuple(ways))

    activities = tuple(map(sound, robot.activities))
    return replace(robot, hardware=(*robot.hardware, *added), activities=activities)
