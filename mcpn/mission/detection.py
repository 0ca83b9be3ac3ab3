"""Losses that are detected late: what says so of hardware, and which activities detect them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping

from mcpn.did_you_mean import Hints
from mcpn.errors import Problem
from mcpn.mission.robot import Activity, Hardware


def noticed(hardware: str) -> str:
    """What may be true of hardware that is detected late: it is out of service, and the robot knows it.

    Controllers carry it from section to section beside the flags of facts, whose names have no space.
    """
    return f"{hardware} known"


def detection_errors(
    activity: Activity, hardware: Mapping[str, Hardware], known: Collection[str], hints: Hints
) -> Iterator[Problem]:
    """What is wrong with the losses that an activity detects.

    Args:
        activity: The activity.
        hardware: All that robots declare, by name.
        known: The names of all resources.
        hints: Finds what unknown names may have been meant as.
    """
    if activity.detection_rate is not None and not activity.detects:
        yield Problem(activity.source, f"activity {activity.name} has a detection_rate, but detects nothing")
    for name in dict.fromkeys(activity.detects):
        said = f"activity {activity.name} detects {name}"
        if name in hardware and hardware[name].detected != "late":
            yield Problem(
                activity.source, f"{said}, whose loss is known at once: say that it is detected late"
            )
        elif name not in hardware and name in known:
            yield Problem(activity.source, f"{said}, which is no hardware")
        elif name not in hardware:
            yield Problem(activity.source, f"{said}, which is not declared{hints.known(name, hardware)}")


def detected_twice(activities: Iterable[Activity]) -> Iterator[Problem]:
    """Hardware whose loss several activities detect."""
    detector: dict[str, str] = {}
    for activity in activities:
        for name in dict.fromkeys(activity.detects):
            if (other := detector.setdefault(name, activity.name)) != activity.name:
                message = f"activities {other} and {activity.name} both detect {name}, expected one of them"
                yield Problem(activity.source, message)
