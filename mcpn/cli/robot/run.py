"""A mission's controller among the drivers of a robot."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.robot.watching import monitors_for
from mcpn.cli.shared import (
    EXIT_FAILED,
    FILE,
    emit_json,
    import_option,
    json_option,
    limit_option,
    tell_warnings,
    templates_option,
    without_threads_of_numpy,
)
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.drivers.running import RobotRun
    from mcpn.net.templates import TemplateSet
    from mcpn.runtime.controller import Controller, Step
    from mcpn.runtime.monitors import Monitors
    from mcpn.runtime.tables import Action
    from mcpn.study import Study

INTERRUPTED = 128
"""To this the number of the signal is added."""


@click.command()
@click.argument("mission", type=FILE)
@click.option("--drivers", type=FILE, required=True, help="What the robot's activities are: a TOML file.")
@click.option("--unverified", is_flag=True, help="Do not verify the mission first.")
@click.option("--check", "only_check", is_flag=True, help="Verify, hold the drivers against it, do not run.")
@click.option("--monitors", "watched", is_flag=True, help="Watch the mission's requirements as it runs.")
@click.option("--journal", type=FILE, help="File for a log in lines of JSON; what it held is replaced.")
@click.option("--snapshot", type=FILE, help="File that says, after each event, where the controller is.")
@click.option("--page", "paged", is_flag=True, help="Serve a page that shows what runs; tells its address.")
@click.option("--resume", type=FILE, help="Go on from where this snapshot was taken.")
@limit_option
@import_option
@templates_option
@json_option
def run(
    mission: Path,
    drivers: Path,
    unverified: bool,
    only_check: bool,
    watched: bool,
    journal: Path | None,
    snapshot: Path | None,
    paged: bool,
    resume: Path | None,
    max_states: int | None,
    import_root: Path | None,
    templates: TemplateSet | None,
    as_json: bool,
) -> None:
    """Run MISSION on a robot: its controller among the drivers that a file names.

    It verifies the mission first, and runs none whose verdicts or requirements fail. Interrupted, it stops
    what runs, releases its hardware, and writes the snapshot. Exit code 0 if the mission succeeds, 1 if it
    fails or aborts, or a monitor finds a requirement violated.
    """
    without_threads_of_numpy()
    from mcpn.controller.targets.json import document
    from mcpn.drivers.mapping import check_plan
    from mcpn.drivers.reading import read_drivers
    from mcpn.opening import open_study
    from mcpn.runtime.controller import Controller
    from mcpn.runtime.tables import Tables

    if paged and resume is not None:
        raise click.UsageError("--page shows a run from its start: it cannot be given with --resume")
    study = open_study(mission, import_root=import_root, templates=templates)
    if study.is_net:
        raise InputError.at(Source(str(mission)), "expected a mission: a net has no controller")
    plan = read_drivers(drivers)
    if not unverified:
        _verify(study, max_states, as_json)
    tables = Tables(document(study.controller("auto", max_states=max_states), study.mission_net))
    check_plan(plan, tables)
    controller = Controller(tables)
    if only_check:
        _tell(_found(controller, len(plan.specs), None, 0.0, []), as_json)
        return
    monitors = monitors_for(study, max_states) if watched else None
    actions = None if resume is None else _resumed(controller, resume)
    from mcpn.drivers.running import RobotRun
    from mcpn.files import write_atomically

    shown = None if as_json else _EventLines()

    def save() -> None:
        if snapshot is not None:
            write_atomically(snapshot, controller.snapshot())

    started = time.monotonic()
    received: list[int] = []
    with _journal(controller, journal), _warnings(), _page(controller, study if paged else None, max_states):
        if shown is not None:
            controller.observe(shown)
        if monitors is not None:
            controller.observe(lambda step: monitors.take(step.event) if step.taken else None)
        runner = RobotRun(
            controller, tables, plan, told=(lambda *of: None) if shown is None else shown.line, after=save
        )
        save()
        asyncio.run(_until_signal(runner, actions, received))
        save()
    found = _found(controller, len(plan.specs), monitors, time.monotonic() - started, received)
    _tell(found, as_json)
    if received:
        click.get_current_context().exit(INTERRUPTED + received[0])
    if controller.outcome != "success" or found["violated"]:
        click.get_current_context().exit(EXIT_FAILED)


def _verify(study: Study, max_states: int | None, as_json: bool) -> None:
    """Verifies a mission; one that fails is told of, and not run."""
    warned = [] if as_json else tell_warnings(study.mission_net)
    started = time.perf_counter()
    found = study.verdicts(max_states=max_states)
    if found.passed:
        return
    if as_json:
        failed = [name for name, verdict in found.verdicts.items() if verdict.holds is False]
        unmet = [answer.asked.name for answer in found.requirements if not answer.met]
        emit_json({"mission": found.mission_net.mission.name, "failed": failed, "unmet": unmet})
    else:
        from mcpn.report.text import print_check

        print_check(found, time.perf_counter() - started, told=warned)
        click.echo("not run: mcpn check says no (--unverified runs it all the same)", err=True)
    click.get_current_context().exit(EXIT_FAILED)


def _resumed(controller: Controller, path: Path) -> tuple[Action, ...]:
    from mcpn.files import read_bounded
    from mcpn.runtime.restoring import SnapshotError

    try:
        return controller.restore(read_bounded(path).decode())
    except (SnapshotError, UnicodeDecodeError) as error:
        raise InputError.at(Source(str(path)), str(error)) from None


@contextlib.contextmanager
def _journal(controller: Controller, path: Path | None) -> Iterator[None]:
    """Writes a journal while the controller runs."""
    if path is None:
        yield
        return
    from mcpn.runtime.journal import Journal

    try:
        file = path.open("w", encoding="utf-8")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError.at(Source(str(path)), f"cannot be written: {why}") from None
    with file:
        controller.observe(Journal(file))
        yield


@contextlib.contextmanager
def _page(controller: Controller, study: Study | None, max_states: int | None) -> Iterator[None]:
    """Serves the page of a mission while the controller runs."""
    if study is None:
        yield
        return
    from mcpn.editor.attached import RobotPage, attached

    content = RobotPage(study, max_states)
    controller.observe(content)
    with attached(content) as server:
        click.echo(f"page: {server.address}", err=True)
        try:
            yield
        finally:
            content.end(controller.outcome)


@contextlib.contextmanager
def _warnings() -> Iterator[None]:
    """Shows on standard error what goes wrong with drivers; what is refused is among the events."""

    class Echo(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            click.echo(f"{record.levelname.lower()}: {record.getMessage()}", err=True)

    handler = Echo(logging.WARNING)
    silent = logging.NullHandler()
    of_drivers, of_runtime = logging.getLogger("mcpn.drivers"), logging.getLogger("mcpn.runtime")
    of_drivers.addHandler(handler)
    of_runtime.addHandler(silent)
    try:
        yield
    finally:
        of_drivers.removeHandler(handler)
        of_runtime.removeHandler(silent)


async def _until_signal(runner: RobotRun, actions: tuple[Action, ...] | None, received: list[int]) -> None:
    """Runs; SIGINT and SIGTERM end it in order, a second one in a hurry."""
    loop = asyncio.get_running_loop()
    before = {}

    def stop(number: int) -> None:
        received.append(number)
        runner.end()

    for number in (signal.SIGINT, signal.SIGTERM):
        before[number] = signal.getsignal(number)
        if before[number] is not signal.SIG_IGN:
            loop.add_signal_handler(number, stop, number)
    try:
        await runner.run(actions)
    finally:
        for number, handler in before.items():
            loop.remove_signal_handler(number)
            signal.signal(number, handler)


class _EventLines:
    """What happens, on the terminal: each event with its actions, and what runs then."""

    def __init__(self) -> None:
        from mcpn.report.terminal import Terminal

        self._terminal = Terminal()
        self._began = time.monotonic()
        self._runs = ""

    def __call__(self, step: Step) -> None:
        """Shows an event."""
        at = f"{time.monotonic() - self._began:8.2f} s  {step.event}"
        if not step.taken:
            self._terminal.print(f"{at}: not possible now", style="yellow")
            return
        actions = "; ".join(map(str, step.actions)) or "nothing to do"
        self._terminal.print(f"{at}: {actions}")
        inside = step.after.inside
        mode = ", ".join(name if name == way else f"{name} ({way})" for name, way in inside.mode.items())
        ended = "" if step.after.phase == "running" else step.after.phase
        runs = ended or f"{', '.join(inside.objectives)}: {mode or 'nothing'}"
        if runs != self._runs:
            self._terminal.print(f"runs {runs}" if not ended else runs, style="bold", indent=12)
            self._runs = runs

    def line(self, name: str, line: str) -> None:
        """Shows what a driver says that tells no event."""
        self._terminal.print(f"{name}: {line}", style="dim", indent=12)


def _found(
    controller: Controller, drivers: int, monitors: Monitors | None, seconds: float, received: list[int]
) -> dict[str, Any]:
    return {
        "mission": controller.mission,
        "drivers": drivers,
        "outcome": controller.outcome,
        "interrupted": bool(received),
        "events": controller.count - controller.refusals,
        "refused": controller.refusals,
        "violated": [] if monitors is None else list(monitors.violated),
        "seconds": seconds,
    }


def _tell(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        emit_json(found)
        return
    from mcpn.report.text import print_counts

    print_counts({key: value for key, value in found.items() if not isinstance(value, list) or value})
