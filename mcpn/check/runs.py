"""Runs in mission words, event by event."""

from __future__ import annotations

from dataclasses import dataclass

from mcpn.check.modes import Situation
from mcpn.net.events import Event, What


@dataclass(frozen=True)
class Step:
    """One event of a run, or one internal firing where a run shows the net's own behaviour.

    Args:
        event: The event; for an internal firing the transition's name.
        words: The same for a reader: what happens, and what changes in the functioning mode.
    """

    event: Event | str
    words: str


def step_in_words(mission: str, event: Event, before: Situation, after: Situation) -> Step:
    """An event with what it changes.

    Args:
        mission: The mission's name.
        event: The event.
        before: What the robot did before it.
        after: What it does afterwards.
    """
    words = what_happens(event, mission)
    changed = changes(before, after)
    return Step(event, f"{words}: {', '.join(changed)}" if changed else words)


def what_happens(event: Event, mission: str) -> str:
    """An event in mission words.

    Args:
        event: The event.
        mission: The mission's name.

    Returns:
        For example "GPS_sensor fails".
    """
    name = event.element
    match event.what:
        case What.START:
            return f"mission {mission} starts"
        case What.SUCCESS:
            return f"objective {name} succeeds"
        case What.FAILURE:
            return f"objective {name} fails"
        case What.OUT_OF_SERVICE:
            return f"{name} fails"
        case What.LOST:
            return f"{event.element} is lost for good"
        case What.REPAIRED:
            return f"{name} works again"
        case What.DECLARED:
            return f"event {name} happens"
        case What.NAMED:
            return name


def changes(before: Situation, after: Situation) -> list[str]:
    """What changes from one stable marking to the next, in mission words."""
    found = [f"{name} begins" for name in after.objectives if name not in before.objectives]
    for activity, alternative in after.mode.items():
        was = before.mode.get(activity)
        if was is not None and was != alternative:
            found.append(f"{activity} changes from {was} to {alternative}")
        elif was is None and alternative != activity:
            found.append(f"{activity} runs as {alternative}")
    found += [f"{name} has no way to run" for name in after.refused if name not in before.refused]
    found += [f"{name} waits" for name in after.waiting if name not in before.waiting]
    if after.outcome and not before.outcome:
        found.append(f"the mission ends in {after.outcome}")
    return found
