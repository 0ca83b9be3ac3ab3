"""Faults that are hardware resources of their own: common causes, and software that crashes.

A common cause takes several hardware resources out of service with one event. It becomes a shared hardware
resource: every alternative that consumes hardware which the cause affects consumes the cause too. So the
cause fails and is repaired as hardware is, every user of affected hardware gets the error, and the affected
hardware may still fail by itself.

An activity, or an alternative, that may crash consumes a hardware resource of its own, which nobody else
consumes and which can fail only while the activity runs.

Source: K. N. Fleming, *A reliability model for common mode failures in redundant safety systems*, 1975.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mcpn.did_you_mean import Hints
from mcpn.errors import Problem
from mcpn.mission.robot import Activity, Alternative, Fault, Hardware, Robot


@dataclass(frozen=True, slots=True, kw_only=True)
class Crash(Hardware):
    """The hardware resource of an activity, or an alternative, that may crash: out of service after a crash.

    Its name is that of the activity, or of the activity and the alternative: ``localise.by_scan``.

    Args:
        activity: The activity.
    """

    activity: str


def as_crashes(activities: Iterable[Activity]) -> Iterator[Crash]:
    """The resources that stand for activities and alternatives that may crash."""
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


def as_hardware(faults: Iterable[Fault]) -> Iterator[Hardware]:
    """The resources that stand for faults."""
    for fault in faults:
        yield Hardware(
            name=fault.name,
            description=fault.description,
            shared=True,
            repairable=fault.repairable,
            failure_rate=fault.failure_rate,
            repair_rate=fault.repair_rate,
            source=fault.source,
        )


def consuming(activities: Iterable[Activity], faults: Sequence[Fault]) -> Iterator[Activity]:
    """The activities, their alternatives also consuming the resources of their faults and their crashes."""
    for activity in activities:
        if not faults and not may_crash(activity):
            yield activity
            continue
        ways = []
        for way in activity.alternatives:
            causes = [f.name for f in faults if not set(f.affects).isdisjoint(way.consumes)]
            causes += [activity.name] * activity.faulty + [f"{activity.name}.{way.name}"] * way.faulty
            ways.append(replace(way, consumes=(*way.consumes, *causes)) if causes else way)
        yield replace(activity, alternatives=tuple(ways))


def may_crash(activity: Activity) -> bool:
    """Whether the activity, or an alternative of it, may crash."""
    return activity.faulty or any(way.faulty for way in activity.alternatives)


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
    for fault in (fault for robot in robots for fault in robot.faults):
        if not fault.affects:
            yield Problem(fault.source, f"fault {fault.name} affects nothing, expected names of hardware")
        if not fault.repairable:
            yield from _repaired(fault)
        for name in dict.fromkeys(fault.affects):
            if name in software:
                message = f"fault {fault.name} affects {name}, which is software: name what makes it"
                yield Problem(fault.source, message)
            elif name not in hardware:
                message = f"fault {fault.name} affects {name}, which is not declared"
                yield Problem(fault.source, message + hints.known(name, hardware))


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


def crash_errors(activity: Activity, resources: Container[str]) -> Iterator[Problem]:
    """What an activity, and its alternatives, declare of crashes that is not valid.

    Args:
        activity: The activity.
        resources: The names of all that robots declare.
    """
    if activity.faulty and activity.name in resources:
        message = f"activity {activity.name} is faulty, though a resource is called {activity.name} too"
        yield Problem(activity.source, f"{message}: its crash would have that name; give one another name")
    said: list[tuple[str, Activity | Alternative]] = [(f"activity {activity.name}", activity)]
    said += [(f"alternative {way.name} of {activity.name}", way) for way in activity.alternatives]
    for name, declared in said:
        rates = (("failure_rate", declared.failure_rate), ("repair_rate", declared.repair_rate))
        without_effect = [f"has a {what}" for what, rate in rates if rate]
        without_effect += [] if declared.recovers else ["does not recover"]
        for what in () if declared.faulty else without_effect:
            yield Problem(declared.source, f'{name} {what}, though it never crashes: add faulty="true"')
        if declared.faulty and not declared.recovers and declared.repair_rate:
            yield Problem(declared.source, f"{name} has a repair_rate, though it never recovers")


def _repaired(element: Hardware | Fault) -> Iterator[Problem]:
    """A problem where hardware, or a fault, that is not repairable has a rate of repairs."""
    if element.repair_rate:
        yield Problem(element.source, f"{element.name} has a repair_rate, though it is not repairable")
