"""Faults that are hardware resources of their own: common causes of several losses.

A common cause takes several hardware resources out of service with one event. It becomes a shared hardware
resource: every alternative that consumes hardware which the cause affects consumes the cause too. So the
cause fails and is repaired as hardware is, every user of affected hardware gets the error, and the affected
hardware may still fail by itself.

Source: K. N. Fleming, *A reliability model for common mode failures in redundant safety systems*, 1975.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from mcpn.did_you_mean import Hints
from mcpn.errors import Problem
from mcpn.mission.expansion.crashes import may_crash
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


def _repaired(element: Hardware | Fault) -> Iterator[Problem]:
    """A problem where hardware, or a fault, that is not repairable has a rate of repairs."""
    if element.repair_rate:
        yield Problem(element.source, f"{element.name} has a repair_rate, though it is not repairable")
