"""Common causes: what takes several hardware resources out of service with one event.

A fault is a hardware resource of its own, shared by all: whatever consumes hardware that it affects consumes
it too. So it fails and is repaired as hardware is, everybody who uses something that it affects gets the
error, and what it affects may still fail by itself.

Source: K. N. Fleming, *A reliability model for common mode failures in redundant safety systems*, 1975.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from mcpn.errors import Problem
from mcpn.mission.near import Hints
from mcpn.mission.robot import Activity, Fault, Hardware, Robot


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
    """Activities whose alternatives consume the resources that stand for faults of what they consume."""
    for activity in activities:
        ways = (
            replace(way, consumes=(*way.consumes, *causes))
            if (causes := [f.name for f in faults if not set(f.affects).isdisjoint(way.consumes)])
            else way
            for way in activity.alternatives
        )
        yield replace(activity, alternatives=tuple(ways))


def failure_errors(robots: Sequence[Robot], hints: Hints) -> Iterator[Problem]:
    """What makes invalid what robots say of failures.

    Args:
        robots: Those of a mission.
        hints: At names that are near.
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


def _repaired(of: Hardware | Fault) -> Iterator[Problem]:
    """A rate of repairs of what is never repaired."""
    if of.repair_rate:
        yield Problem(of.source, f"{of.name} has a repair_rate, though it is not repairable")
