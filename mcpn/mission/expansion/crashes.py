"""Software that crashes: a hardware resource of its own for each activity, or alternative, that may.

The activity or the alternative consumes that resource, which nobody else consumes and which can fail only
while the activity runs.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass, replace

from mcpn.errors import Problem
from mcpn.mission.robot import Activity, Alternative, Hardware


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


def consuming(activities: Iterable[Activity]) -> Iterator[Activity]:
    """The activities, they and their alternatives also consuming the resources of their crashes."""
    for activity in activities:
        ways = []
        for way in activity.alternatives:
            own = [activity.name] * activity.faulty + [f"{activity.name}.{way.name}"] * way.faulty
            ways.append(replace(way, consumes=(*way.consumes, *own)) if own else way)
        yield replace(activity, alternatives=tuple(ways))


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
