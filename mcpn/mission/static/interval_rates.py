"""Rates of a mission that are known as intervals."""

from __future__ import annotations

from mcpn.mission.language.datatypes import Interval
from mcpn.mission.model import Mission
from mcpn.sentences import enumeration


def interval_rates(mission: Mission) -> dict[str, Interval]:
    """The rates that are intervals, each by what it is of: ``failure_rate of gps``."""
    rates = [(f"failure_rate of {h.name}", h.failure_rate) for h in mission.hardware]
    rates += [(f"repair_rate of {h.name}", h.repair_rate) for h in mission.hardware]
    rates += [(f"rate of {event.name}", event.rate) for event in mission.events]
    rates += [(f"detection_rate of {a.name}", a.detection_rate) for a in mission.activities]
    return {name: rate for name, rate in rates if isinstance(rate, Interval)}


def at_their_means(mission: Mission) -> str:
    """Says which rates are intervals and what is computed with in their place; empty where none is."""
    found = interval_rates(mission)
    told = enumeration([f"{name} {float(rate):.6g}" for name, rate in found.items()])
    return f"computed with geometric means of intervals: {told}" if found else ""
