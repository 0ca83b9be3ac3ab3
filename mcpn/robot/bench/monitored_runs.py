"""Monitors on the runs of a bench: how many of them violate each requirement, satisfy it, leave it open."""

from __future__ import annotations

from collections.abc import Iterable

from mcpn.robot.bench.runs import BenchRun
from mcpn.robot.runtime.monitors import Monitors


def watched(monitors: Monitors, runs: Iterable[BenchRun]) -> dict[str, dict[str, int]]:
    """By requirement, what its monitor says at the ends of how many runs.

    Args:
        monitors: Those of the mission; they begin anew with each run.
        runs: The runs.
    """
    found = {name: dict.fromkeys(("violated", "satisfied", "open"), 0) for name in monitors.values}
    for run in runs:
        monitors.restart()
        for event in run.events:
            if not event.refused:
                monitors.take(event.event)
        for name, value in monitors.values.items():
            found[name][value] += 1
    return found
