"""Monitors of what a mission requires: for its controller, and for a robot's log."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json
from mcpn.cli.robot.watching import not_within
from mcpn.errors import InputError, Source


@click.command()
@click.argument("mission", type=FILE)
@click.option("-o", "--output", type=FILE, help="Directory to write the monitors to: JSON, and C99.")
@click.option("--log", type=FILE, help="Read a robot's log: a journal, or an event at the end of each line.")
@click.option("--within-mission", "within", is_flag=True, help="Consider only what the mission allows.")
@click.option("--btcpp", is_flag=True, help="Write conditions of BehaviorTree.CPP 4, too.")
@question(trees=False)
def monitor(
    question: Question,
    mission: Path,
    output: Path | None,
    log: Path | None,
    within: bool,
    btcpp: bool,
) -> None:
    """Make monitors of what MISSION requires: machines that watch its events, or the log of a robot.

    Each says of its requirement whether it is violated or satisfied however it goes on, or still open: with
    any events, or earlier, with --within-mission, with those that the mission allows. With --log, exit code 1
    if the log violates one.
    """
    if output is None and log is None:
        raise click.UsageError("-o or --log is needed")
    if btcpp and output is None:
        raise click.UsageError("--btcpp needs -o, the directory to write to")
    from mcpn.controller.monitors.writing import files, monitors_of
    from mcpn.files import write_folder
    from mcpn.robot.runtime.journal import JournalError
    from mcpn.robot.runtime.monitors import Monitors, told, watch

    study = question.study(mission)
    if study.is_net:
        raise InputError.at(Source(str(mission)), "expected a mission: a net requires nothing")
    monitors = monitors_of(study.mission_spaces("what it requires"), within)
    texts = files(monitors, btcpp=btcpp)
    paths: list[str] = []
    if output is not None:
        write_folder(output, texts)
        paths = [str(output / name) for name in texts]
    watching = Monitors(json.loads(texts["monitors.json"]))
    if log is not None:
        try:
            watch(watching, _lines(log))
        except JournalError as error:
            raise InputError.at(Source(str(log), error.line), str(error)) from None
    if question.as_json:
        sizes = {each.name: len(each.values) for each in monitors.monitors}
        found: dict[str, Any] = {
            "mission": monitors.mission,
            "states": sizes,
            "unwatched": list(monitors.unwatched),
        }
        found |= {"within_mission": {each.name: each.within for each in monitors.monitors}}
        found |= {"files": paths, "log": None}
        if log is not None:
            findings = [
                {"requirement": f.requirement, "value": f.value, "number": f.number, "event": f.event or None}
                for f in watching.findings
            ]
            found["log"] = {
                "events": watching.count,
                "values": dict(watching.values),
                "findings": findings,
            }
        emit_json(found)
    else:
        for each in monitors.monitors if output is not None else ():
            click.echo(f"{each.name}: {len(each.values)} states: {each.words}")
        for line in not_within(monitors) if within else ():
            click.echo(line)
        for name in monitors.unwatched:
            click.echo(f"{name}: not watched, for it speaks of what may happen")
        for line in (*paths, *(told(watching) if log is not None else ())):
            click.echo(line)
    if log is not None and watching.violated:
        sys.exit(EXIT_FAILED)


def _lines(log: Path) -> list[str]:
    try:
        return log.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is no text"
        raise InputError.at(Source(str(log)), f"cannot be read: {why}") from None
