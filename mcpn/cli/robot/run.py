"""A mission's controller among the drivers of a robot."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.exit_codes import EXIT_BAD_INPUT, EXIT_FAILED, EXIT_SIGNAL
from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json
from mcpn.cli.robot.watching import monitors_for
from mcpn.cli.verified_first import require_verified
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.editor.robot_page import RobotPage
    from mcpn.robot.drivers.running import RobotRun
    from mcpn.robot.runtime.actions import Action
    from mcpn.robot.runtime.controller import Controller
    from mcpn.robot.runtime.monitors import Monitors
    from mcpn.study import Study
from mcpn.cli.robot.shown_lines import EventLines, WarningLines
from mcpn.cli.robot.signals import caught

_log = logging.getLogger("mcpn.robot.drivers")


@click.command()
@click.argument("mission", type=FILE)
@click.option("--drivers", type=FILE, required=True, help="What the robot's activities are: a TOML file.")
@click.option("--unverified", is_flag=True, help="Do not verify the mission first.")
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Verify, check the drivers against the mission, run none; imports modules.",
)
@click.option("--init", "begins", is_flag=True, help="Write a file of drivers to edit, run nothing.")
@click.option("--monitors", "watched", is_flag=True, help="Watch the mission's requirements as it runs.")
@click.option(
    "--journal",
    type=FILE,
    help="Write a log as lines of JSON; replaces the file, or continues it (--resume).",
)
@click.option("--snapshot", type=FILE, help="Write the controller's state to this file after each event.")
@click.option("--page", "paged", is_flag=True, help="Serve a page that shows what runs; prints its address.")
@click.option(
    "--must-record", is_flag=True, help="End the run when its journal or snapshot cannot be written."
)
@click.option("--resume", type=FILE, help="Resume from this snapshot.")
@question(trees=False)
def run(
    question: Question,
    mission: Path,
    drivers: Path,
    unverified: bool,
    only_check: bool,
    begins: bool,
    watched: bool,
    journal: Path | None,
    snapshot: Path | None,
    paged: bool,
    must_record: bool,
    resume: Path | None,
) -> None:
    """Run MISSION on a robot: its controller among the drivers that a file names.

    It verifies the mission first, and runs none whose verdicts or requirements fail. Interrupted, it stops
    what runs, releases its hardware, and writes the snapshot. Exit code 0 if the mission succeeds, 1 if it
    fails or aborts, or a monitor finds a requirement violated, 2 if its journal or snapshot is not whole.
    """
    from mcpn.controller.document import document
    from mcpn.files import keep_apart
    from mcpn.robot.drivers.mapping import check_plan
    from mcpn.robot.drivers.reading import read_drivers
    from mcpn.robot.runtime.controller import Controller
    from mcpn.robot.runtime.controller_tables import Tables

    if paged and resume is not None:
        raise click.UsageError("--page shows a run from its start: it cannot be given with --resume")
    study = question.study(mission)
    if study.is_net:
        raise InputError.at(Source(str(mission)), "expected a mission: a net has no controller")
    if begins:
        _begin(study, drivers, question)
        return
    plan = read_drivers(drivers)
    keep_apart([journal, snapshot], [mission, *study.mission.files, drivers])
    keep_apart([journal], filter(None, [resume]))  # a run may go on in its own snapshot
    if not unverified:
        require_verified(study, question, "not run: mcpn check says no (--unverified runs it all the same)")
    tables = Tables(document(study.controller("auto"), study.mission_net))
    check_plan(plan, tables)
    controller = Controller(tables)
    if only_check:
        _tell(_found(controller, len(plan.specs), None, 0.0, [], [], 0), question.as_json)
        return
    monitors = monitors_for(study) if watched else None
    from mcpn.cli.robot.records import Records
    from mcpn.cli.robot.resuming import Resumed, beside, resumed
    from mcpn.robot.drivers.running import RobotRun

    goes_on = resume is not None
    before = (
        resumed(resume, controller, tables, monitors, journal, plan, _asked, must_record)
        if resume is not None
        else Resumed()
    )
    started = time.monotonic()
    received: list[int] = []
    with _warnings() as warnings, _page(controller, study if paged else None) as content:
        records = Records(must_record, None if content is None else content.lost)
        if monitors is not None:
            controller.observe(lambda step: monitors.take(step.event) if step.taken else None)
        if journal is not None:
            controller.observe(records.journal_of(journal, controller.count if goes_on else None))
        shown = None if question.as_json else EventLines()
        if shown is not None:
            controller.observe(shown)
        actions = None
        if goes_on:
            before.failures()
            actions = controller.restore(controller.snapshot())
        runner = RobotRun(
            controller,
            tables,
            plan,
            told=(lambda *line: None) if shown is None else shown.line,
            after=records.save,
            begins=records.save,
            starts=before.starts,
            untold=before.untold,
        )
        ended = False
        if snapshot is not None:
            records.snapshot_of(snapshot, lambda: controller.snapshot(beside(monitors, runner, ended)))
        records.begin(runner.end)

        def finish() -> None:
            nonlocal ended
            ended = True
            records.save()
            records.close()
            if shown is not None:
                shown.close()

        asyncio.run(_until_signal(runner, actions, received, finish))
        lost = records.lost
        if shown is not None and shown.lost is not None:
            lost.append("standard output")
        if lost:
            _log.error("not everything is recorded: the %s", ", the ".join(lost))
    seconds = time.monotonic() - started
    found = _found(controller, len(plan.specs), monitors, seconds, received, lost, warnings.left_out)
    _tell(found, question.as_json)
    if lost:
        click.get_current_context().exit(EXIT_BAD_INPUT)
    if received:
        click.get_current_context().exit(EXIT_SIGNAL + received[0])
    if controller.outcome != "success" or found["violated"]:
        click.get_current_context().exit(EXIT_FAILED)


def _begin(study: Study, drivers: Path, question: Question) -> None:
    """Writes a file of drivers to start from; one that is there is not overwritten."""
    from mcpn.controller.document import document
    from mcpn.files import write_atomically
    from mcpn.robot.drivers.skeleton import skeleton
    from mcpn.robot.runtime.controller_tables import Tables

    if drivers.exists():
        raise InputError.at(Source(str(drivers)), "exists already, and is not overwritten")
    tables = Tables(document(study.controller("auto"), study.mission_net))
    write_atomically(drivers, skeleton(tables))
    if question.as_json:
        emit_json({"files": [str(drivers)]})
    else:
        click.echo(str(drivers))


@contextlib.contextmanager
def _page(controller: Controller, study: Study | None) -> Iterator[RobotPage | None]:
    """Serves the page of a mission while the controller runs."""
    if study is None:
        yield None
        return
    from mcpn.editor.robot_page import RobotPage, attached

    content = RobotPage(study)
    controller.observe(content)
    with attached(content) as server:
        click.echo(f"page: {server.address}", err=True)
        try:
            yield content
        finally:
            content.end(controller.outcome)


@contextlib.contextmanager
def _warnings() -> Iterator[WarningLines]:
    """Shows on standard error what goes wrong with drivers; what is refused is among the events."""
    handler = WarningLines()
    silent = logging.NullHandler()
    # What asyncio logs would else be written by the loop's thread, which must not wait for standard error.
    handlers = {"mcpn.robot.drivers": handler, "asyncio": handler, "mcpn.robot.runtime": silent}
    for name, each in handlers.items():
        logging.getLogger(name).addHandler(each)
    try:
        yield handler
    finally:
        for name, each in handlers.items():
            logging.getLogger(name).removeHandler(each)
        handler.close()


async def _until_signal(
    runner: RobotRun, actions: tuple[Action, ...] | None, received: list[int], finish: Callable[[], None]
) -> None:
    """Runs; each signal that can be caught ends it in order, a second one in a hurry.

    However it ends, also where the loop raises, it is finished before signals are heard as usual.
    """

    def stop(number: int) -> None:
        received.append(number)
        runner.end(again=len(received) > 1)

    with caught(stop):
        try:
            await runner.run(actions)
        finally:
            finish()


def _asked(activity: str, objective: str) -> bool:
    """Asks who stands before the robot; where nobody does, the answer is no."""
    if sys.stdin is None or not sys.stdin.isatty():
        return False
    return click.confirm(f"{activity} had begun for {objective}: begin it again?", err=True)


def _found(
    controller: Controller,
    drivers: int,
    monitors: Monitors | None,
    seconds: float,
    received: list[int],
    lost: list[str],
    warnings: int,
) -> dict[str, Any]:
    return {
        "mission": controller.mission,
        "drivers": drivers,
        "outcome": controller.outcome,
        "interrupted": bool(received),
        "events": controller.count - controller.refusals,
        "refused": controller.refusals,
        "violated": [] if monitors is None else list(monitors.violated),
        "lost": lost,
        "warnings_left_out": warnings,
        "seconds": seconds,
    }


def _tell(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        emit_json(found)
        return
    from mcpn.report.text import print_counts

    quiet = [key for key, value in found.items() if value == [] or (key == "warnings_left_out" and not value)]
    print_counts({key: value for key, value in found.items() if key not in quiet})
