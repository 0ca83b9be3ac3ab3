"""Monitors of a mission's requirements, for commands that play or run it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from mcpn.controller.monitors.writing import MissionMonitors
    from mcpn.robot.runtime.monitors import Monitors
    from mcpn.study import Study


def monitors_for(study: Study) -> Monitors:
    """The monitors of a mission that its controller plays: its own continuations decide, where they can."""
    from mcpn.controller.monitors.writing import files, monitors_of
    from mcpn.robot.runtime.monitors import Monitors

    monitors = monitors_of(study.mission_spaces("what it requires"), within=True)
    for line in not_within(monitors):
        click.echo(line, err=True)
    return Monitors(json.loads(files(monitors)["monitors.json"]))


def not_within(monitors: MissionMonitors) -> Iterator[str]:
    """Which monitors are decided by any continuation though the mission's own were asked for, and why."""
    from mcpn.controller.monitors.watched import MAX_WITHIN

    for each in monitors.monitors:
        if not each.within:
            why = f"within the mission it would have more than {MAX_WITHIN} states"
            yield f"{each.name}: decided by any continuation, for {why}"
