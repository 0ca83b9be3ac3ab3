"""The main job: verdicts of a mission."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.shared import (
    EXIT_FAILED,
    FILE,
    emit_json,
    import_option,
    json_option,
    limit_option,
    mission_net_of,
    progress_line,
)

if TYPE_CHECKING:
    from mcpn.space.graph import StateGraph


@click.command()
@click.argument("mission", type=FILE)
@click.option("--engine", type=click.Choice(["explicit"]), default="explicit", show_default=True)
@limit_option
@import_option
@json_option
def check(
    mission: Path, engine: str, max_states: int | None, import_root: Path | None, as_json: bool
) -> None:
    """Verify MISSION: verdicts with their runs, sizes, functioning modes, warnings."""
    from mcpn.check.properties import check_mission
    from mcpn.mission.validate import find_warnings

    started = time.perf_counter()
    mission_net = mission_net_of(mission, import_root)
    with progress_line(as_json) as progress:
        found = check_mission(mission_net, max_states=max_states, progress=progress)
    seconds = time.perf_counter() - started
    if as_json:
        emit_json(_check_object(found, engine, seconds))
    else:
        from mcpn.report.text import print_check

        print_check(found, find_warnings(mission_net.mission), seconds)
    if not found.passed:
        sys.exit(EXIT_FAILED)


def _check_object(found: Any, engine: str, seconds: float) -> dict[str, Any]:
    def size(graph: StateGraph | None) -> dict[str, int | None]:
        return {
            "states": None if graph is None else graph.states,
            "edges": None if graph is None else graph.edges,
        }

    net = found.mission_net.net
    return {
        "mission": found.mission_net.mission.name,
        "places": len(net.places),
        "transitions": len(net.transitions),
        "markings": size(found.markings),
        "alternatives": size(found.alternatives),
        "verdicts": {name: verdict.holds for name, verdict in found.verdicts.items()},
        "witnesses": {
            name: [[step.event for step in run] for run in verdict.runs]
            for name, verdict in found.verdicts.items()
            if verdict.runs
        },
        "engine": engine,
        "seconds": seconds,
    }
