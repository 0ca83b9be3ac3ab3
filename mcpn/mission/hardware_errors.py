"""What is wrong with hardware and faults as robots declare them: rates, repairs, effects, late detection."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from mcpn.did_you_mean import Hints
from mcpn.errors import Problem
from mcpn.mission.robot import Activity, Fault, Hardware, Robot


def failure_errors(robots: Sequence[Robot], hints: Hints) -> Iterator[Problem]:
    """Declarations of hardware and faults that are not valid.

    Args:
        robots: Those of a mission.
        hints: Finds what unknown names may have been meant as.
    """
    hardware = {h.name: h for robot in robots for h in robot.hardware}
    software = {s.name for robot in robots for s in robot.software}
    for h in hardware.values():
        for name, rate in (("failure_rate", h.failure_rate), ("repair_rate", h.repair_rate)):
            if rate and not h.faulty:
                yield Problem(h.source, f"{h.name} has a {name}, though it cannot fail (faulty is false)")
        if h.demand_probability and not h.faulty:
            yield Problem(
                h.source, f"{h.name} has a demand_probability, though it cannot fail (faulty is false)"
            )
        if h.detected == "late" and not h.faulty:
            yield Problem(h.source, f"{h.name} is detected late, though it cannot fail (faulty is false)")
        elif h.detected == "late" and h.shared:
            message = f"{h.name} is detected late and shared: which of its users noticed the loss is not"
            yield Problem(h.source, f"{message} reported yet; expected hardware of one activity at a time")
        if not h.faulty and h.initial == "oos":
            yield Problem(h.source, f"{h.name} is out of service at the start, though it cannot fail")
        if not h.repairable and not h.faulty:
            yield Problem(h.source, f"{h.name} is not repairable, though it cannot fail (faulty is false)")
        elif not h.repairable and h.initial == "oos":
            message = f"{h.name} is out of service at the start and not repairable: it is never in service"
            yield Problem(h.source, message)
        elif not h.repairable:
            yield from _repaired(h)
        if h.affects and not h.shared:
            yield Problem(h.source, f"{h.name} stands for a common cause: expected it shared")
    causes: list[Fault | Hardware] = [fault for robot in robots for fault in robot.faults]
    causes += (h for h in hardware.values() if h.affects)
    for fault in causes:
        if not fault.affects:
            yield Problem(fault.source, f"fault {fault.name} affects nothing, expected names of hardware")
        if isinstance(fault, Fault) and not fault.repairable:
            yield from _repaired(fault)
        for name in dict.fromkeys(fault.affects):
            if name in software:
                message = f"fault {fault.name} affects {name}, which is software: name what makes it"
                yield Problem(fault.source, message)
            elif name not in hardware:
                message = f"fault {fault.name} affects {name}, which is not declared"
                yield Problem(fault.source, message + hints.known(name, hardware))


def _repaired(element: Hardware | Fault) -> Iterator[Problem]:
    """A problem where hardware, or a fault, that is not repairable has a rate of repairs."""
    if element.repair_rate:
        yield Problem(element.source, f"{element.name} has a repair_rate, though it is not repairable")


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
