"""How likely the events of a mission are beside each other: what a walk at random draws by.

A weight is a rate, per hour, as the numbers of risk have it (:mod:`mcpn.answers.causes.risk`): what the files
of the mission give counts. Where they give nothing an objective takes an hour, and something fails, or a
declared event happens, a tenth as often as an objective succeeds.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from itertools import repeat

from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What

USUAL, SELDOM = 1.0, 0.1
"""Rates, per hour, where the files give none: of successes, starts and repairs; of all else."""

Likelihood = Callable[[Event], float]


def likelihood(mission_net: MissionNet) -> Likelihood:
    """The weight of each event of a mission; the start of the mission is more likely than all else."""
    mission = mission_net.core
    given: dict[tuple[What, str, str], float | None] = {}
    for hardware in mission.hardware:
        given[What.OUT_OF_SERVICE, hardware.name, ""] = hardware.failure_rate
        given[What.LOST, hardware.name, ""] = hardware.failure_rate
        given[What.REPAIRED, hardware.name, ""] = hardware.repair_rate
    for activity in mission.activities:
        for name in activity.detects:
            given[What.DETECTED, name, ""] = activity.detection_rate
    for event in mission.events:
        given[What.DECLARED, event.name, ""] = event.rate
    for section in mission_net.graph.walk():
        rate = 1 / section.duration if section.duration else USUAL
        fails = section.failure_probability or SELDOM / (USUAL + SELDOM)
        given[What.SUCCESS, section.name, ""] = rate * (1 - fails)
        even = fails / (1 + len(section.reasons))  # where the file does not say how often which
        shares = section.shares if any(section.shares[1:]) else repeat(even)
        for (reason, _), share in zip(section.failures, shares, strict=False):
            given[What.FAILURE, section.name, reason] = rate * share
        given[What.TIMEOUT, section.name, ""] = rate * SELDOM
    default_rates: Mapping[What, float] = {
        What.START: 10 * (1 + len(given)),
        What.REPAIRED: USUAL,
        What.DETECTED: USUAL,
    }

    def weight(event: Event) -> float:
        rate = given.get((event.what, event.element, event.reason))
        return default_rates.get(event.what, SELDOM) if rate is None else rate

    return weight


def drawn_event(possible: Sequence[Event], weight: Likelihood, rng: random.Random) -> Event:
    """One of some events at random; where none of them has a weight, all are equally likely.

    Args:
        possible: At least one.
        weight: Of each.
        rng: What draws.
    """
    weights = [weight(event) for event in possible]
    return rng.choices(possible, weights if any(weights) else None)[0]
