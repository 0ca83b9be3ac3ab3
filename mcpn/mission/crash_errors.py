"""What is wrong with what robots declare of crashes, and with what stands for them in core missions."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping

from mcpn.errors import Problem
from mcpn.mission.robot import Activity, Alternative, Crash


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


def standing_errors(crash: Crash, activities: Mapping[str, Activity]) -> Iterator[Problem]:
    """What is wrong with what stands for a crash, as core missions say it.

    Args:
        crash: What stands for the crash.
        activities: All activities of the mission by name.
    """
    if crash.activity not in activities:
        message = f"{crash.name} is of activity {crash.activity}, which is not declared"
        yield Problem(crash.source, message)
    if crash.repair_rate and not crash.repairable:
        yield Problem(crash.source, f"{crash.name} has a repair_rate, though it is not repairable")
    for name, activity in activities.items():
        if name != crash.activity and any(crash.name in way.consumes for way in activity.alternatives):
            message = f"activity {name} consumes {crash.name}, which stands for a crash of {crash.activity}"
            yield Problem(activity.source, message)
