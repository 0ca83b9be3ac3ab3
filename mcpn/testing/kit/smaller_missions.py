"""Valid missions that say less than a given one: what is left when no smaller one shows the same is needed.

Hypothesis shrinks what was drawn, in the order in which it was drawn; what nothing refers to any more may be
left over. Here elements are taken out of the mission itself, and attributes are set back to their defaults.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass, replace
from itertools import chain
from typing import Any

from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity
from mcpn.mission.validate import find_errors
from mcpn.testing.kit.properties import one_safe as one_safe


def smaller_missions(mission: Mission) -> Iterator[Mission]:
    """Valid missions with one element, attribute or name less; those that leave out most first.

    Args:
        mission: A valid mission.
    """
    produced = (_without(mission, software.name) for software in mission.software)
    for smaller in chain(produced, _smaller(mission)):
        if not find_errors(smaller):
            yield smaller


def _without(mission: Mission, software: str) -> Mission:
    """A mission in which nobody produces some software, nor consumes it."""

    def less(names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name in names if name != software)

    def changed(activity: Activity) -> Activity:
        ways = tuple(replace(way, consumes=less(way.consumes)) for way in activity.alternatives)
        return replace(activity, produces=less(activity.produces), alternatives=ways)

    robots = (
        replace(
            robot,
            software=tuple(one for one in robot.software if one.name != software),
            activities=tuple(map(changed, robot.activities)),
        )
        for robot in mission.robots
    )
    return replace(mission, robots=tuple(robots))


def _smaller(element: Any) -> Iterator[Any]:
    """An element with one thing less: first a whole element inside, then an attribute, then inside these."""
    own = [f for f in fields(element) if f.init and f.name not in ("source", "name")]
    for field in own:
        value = getattr(element, field.name)
        if isinstance(value, tuple):
            for number in range(len(value)):
                yield replace(element, **{field.name: (*value[:number], *value[number + 1 :])})
    for field in own:
        value = getattr(element, field.name)
        default = field.default if field.default is not MISSING else None
        if field.default is not MISSING and value != default and not isinstance(value, tuple):
            yield replace(element, **{field.name: default})
    for field in own:
        value = getattr(element, field.name)
        if isinstance(value, tuple):
            for number, inner in enumerate(value):
                for less in _smaller(inner) if is_dataclass(inner) else ():
                    yield replace(element, **{field.name: (*value[:number], less, *value[number + 1 :])})
    if isinstance(element, Activity) and [way.name for way in element.alternatives] != [element.name]:
        for only in element.alternatives if len(element.alternatives) == 1 else ():
            yield replace(element, alternatives=(replace(only, name=element.name),))
