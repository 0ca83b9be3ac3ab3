"""How likely what happens around a controller is: rates, durations and probabilities, by names and events.

A controller's document says nothing of that: no controller needs it. Whoever knows the mission hands it over.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ObjectiveChances:
    """How an objective ends, while nothing is lost.

    Args:
        duration: Its mean hours; ``None`` where nobody says how long it takes.
        failure: How probably it then fails.
        reasons: How probably it fails for each reason that has a name.
        stopped_by: Events, other than its own, that end its run.
    """

    duration: float | None
    failure: float
    reasons: Mapping[str, float]
    stopped_by: frozenset[str]


@dataclass(frozen=True, slots=True)
class AskingOrder:
    """In which order hardware is asked, of what starts together.

    Args:
        hardware: The position of each resource.
        activities: The position of each activity.
    """

    hardware: Mapping[str, int]
    activities: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Chances:
    """How likely what happens around a controller is.

    Args:
        rates: By event that comes by itself, how often an hour.
        objectives: By objective, how it ends.
        on_demand: By hardware that may fail as it starts to be used, how probably it does.
        orders: By objective in whose section something may, in which order.
    """

    rates: Mapping[str, float]
    objectives: Mapping[str, ObjectiveChances]
    on_demand: Mapping[str, float]
    orders: Mapping[str, AskingOrder]
