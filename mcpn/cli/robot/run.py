"""Signals while a robot runs: each that can be caught ends the run in order."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli import SIGNALS
from mcpn.cli.robot.monitor import monitors_for
from mcpn.cli.shared import EXIT_BAD_INPUT, EXIT_FAILED, FILE, Question, emit_json, question
from mcpn.cli.verified import require_verified
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.drivers.running import RobotRun
    from mcpn.editor.served import RobotPage
    from mcpn.runtime.controller import Controller, Step
    from mcpn.runtime.monitors import Monitors
    from mcpn.runtime.tables import Action
    from mcpn.study import Study

SUSPENDING = {signal.SIGTSTP}
"""The signal that would suspend mcpn, with nobody in charge of what runs."""
IGNORED = {signal.SIGTTIN, signal.SIGTTOU}
"""Signals of a terminal to what runs in the background: each write that is tried again would raise one."""


@contextmanager
def caught(stop: Callable[[int], None]) -> Iterator[None]:
    """Has a function called on the loop's thread with each signal that would end or suspend this process.

    Signals have a way of their own into the loop: in the one that asyncio shares with calls from threads,
    they can be lost behind these. One that is ignored stays so (SIGHUP under ``nohup``). Where one has come,
    all is stopped in the end, and a further one ends the process with the exit code of the first.
    """
    loop = asyncio.get_running_loop()
    heard, waking = socket.socketpair()
    received: list[int] = []
    codes: list[int] = []

    def leave(_number: int, _frame: FrameType | None) -> None:
        os._exit(codes[0])

    def note(number: int, _frame: FrameType | None) -> None:
        received.append(number)
        codes.append(128 + number)

    def take() -> None:
        with suppress(BlockingIOError):
            heard.recv(4096)
        while received:
            stop(received.pop(0))

    before = {}
    for end in (heard, waking):
        end.setblocking(False)
    loop.add_reader(heard.fileno(), take)
    woken = signal.set_wakeup_fd(waking.fileno(), warn_on_full_buffer=False)
    try:
        for number in SIGNALS | SUSPENDING:
            handler = signal.getsignal(number)
            if handler is not None and handler is not signal.SIG_IGN:
                before[number] = signal.signal(number, note)
        for number in IGNORED:
            before[number] = signal.signal(number, signal.SIG_IGN)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, leave if codes and number not in IGNORED else handler)
        signal.set_wakeup_fd(woken)
        loop.remove_reader(heard.fileno())
        take()
        heard.close()
        waking.close()


# What a run shows on the terminal, on threads of their own: no terminal that stands still stops a robot.

MOST = 1000
"""Lines that wait to be shown, from which on those that may be left out are counted alone."""
LAST = 5.0
"""Seconds that the terminal has at the end to show what waits."""


class ShownLines:
    """Lines that a thread shows, in their order.

    Args:
        show: Shows a line; called on that thread. Where it raises, nothing more is shown.
        many: What is shown in the place of lines that were left out, from their number.
    """

    def __init__(self, show: Callable[..., object], many: Callable[[int], str]) -> None:
        self._show, self._many = show, many
        self._waiting: deque[tuple[str, dict[str, Any]]] = deque()
        self._changed = threading.Condition()
        self._untold = 0
        self._closed = False
        self.left_out = 0
        """How many lines were left out."""
        self.lost: OSError | None = None
        """Why nothing further is shown."""
        self._thread = threading.Thread(target=self._print, daemon=True)
        self._thread.start()

    def put(self, text: str, **how: Any) -> None:
        """Has a line shown."""
        with self._changed:
            self._tell_left_out()
            self._waiting.append((text, how))
            self._changed.notify()

    def offer(self, text: str, **how: Any) -> None:
        """Has a line shown, unless too many wait."""
        with self._changed:
            if len(self._waiting) >= MOST:
                self._untold += 1
                self.left_out += 1
                return
        self.put(text, **how)

    def close(self) -> None:
        """Waits until all is shown, but not for long."""
        with self._changed:
            if self._closed:
                return
            self._tell_left_out()
            self._closed = True
            self._changed.notify()
        self._thread.join(LAST)

    def _tell_left_out(self) -> None:
        if self._untold:
            self._waiting.append((self._many(self._untold), {}))
            self._untold = 0

    def _print(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closed)
                if not self._waiting:
                    return
                text, how = self._waiting.popleft()
            if self.lost is None:
                try:
                    self._show(text, **how)
                except OSError as error:
                    self.lost = error


class EventLines:
    """What happens, on the terminal: each event with its actions, and what runs then."""

    def __init__(self) -> None:
        from mcpn.report.terminal import Terminal

        self._began = time.monotonic()
        self._runs = ""
        self._lines = ShownLines(
            Terminal().print, lambda count: f"({count:,} lines of drivers are not shown)"
        )
        self.close = self._lines.close

    def __call__(self, step: Step) -> None:
        """Shows an event."""
        at = f"{time.monotonic() - self._began:8.2f} s  {step.event}"
        if not step.taken:
            self._lines.put(f"{at}: not possible now", style="yellow")
            return
        actions = "; ".join(map(str, step.actions)) or "nothing to do"
        self._lines.put(f"{at}: {actions}")
        inside = step.after.inside
        mode = ", ".join(name if name == way else f"{name} ({way})" for name, way in inside.mode.items())
        ended = "" if step.after.phase == "running" else step.after.phase
        runs = ended or f"{', '.join(inside.objectives)}: {mode or 'nothing'}"
        if runs != self._runs:
            self._lines.put(f"runs {runs}" if not ended else runs, style="bold", indent=12)
            self._runs = runs

    def line(self, name: str, line: str) -> None:
        """Shows output of a driver that is no event."""
        self._lines.offer(f"{name}: {line}", style="dim", indent=12)

    @property
    def lost(self) -> OSError | None:
        """Why standard output shows nothing further."""
        return self._lines.lost


class WarningLines(logging.Handler):
    """Warnings on standard error; those that it does not take in time are counted."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._lines = ShownLines(
            lambda text: click.echo(text, err=True),
            lambda count: f"warning: {count:,} warnings are not shown",
        )

    def emit(self, record: logging.LogRecord) -> None:
        """Has a warning shown."""
        self._lines.offer(f"{record.levelname.lower()}: {record.getMessage()}")

    @property
    def left_out(self) -> int:
        """How many warnings were not shown."""
        return self._lines.left_out

    def close(self) -> None:
        """Waits until all is shown, but not for long."""
        self._lines.close()
        super().close()


# --- A mission's controller among the drivers of a robot --------------------------------------------------

_log = logging.getLogger("mcpn.drivers")

INTERRUPTED = 128
"""To this the number of the signal is added."""


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
@question()
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
    from mcpn.drivers.mapping import check_plan
    from mcpn.drivers.reading import read_drivers
    from mcpn.runtime.controller import Controller
    from mcpn.runtime.tables import Tables

    if paged and resume is not None:
        raise click.UsageError("--page shows a run from its start: it cannot be given with --resume")
    study = question.study(mission)
    if study.is_net:
        raise InputError.at(Source(str(mission)), "expected a mission: a net has no controller")
    if begins:
        _begin(study, drivers, question)
        return
    plan = read_drivers(drivers)
    if not unverified:
        require_verified(study, question, "not run: mcpn check says no (--unverified runs it all the same)")
    tables = Tables(document(study.controller("auto", max_states=question.max_states), study.mission_net))
    check_plan(plan, tables)
    controller = Controller(tables)
    if only_check:
        _tell(_found(controller, len(plan.specs), None, 0.0, [], [], 0), question.as_json)
        return
    monitors = monitors_for(study, question.max_states) if watched else None
    from mcpn.cli.robot.records import Records, Resumed, beside, resumed
    from mcpn.drivers.running import RobotRun

    goes_on = resume is not None
    before = (
        resumed(resume, controller, tables, monitors, journal, plan, _asked, must_record)
        if resume is not None
        else Resumed()
    )
    started = time.monotonic()
    received: list[int] = []
    with _warnings() as warnings, _page(controller, study if paged else None, question.max_states) as content:
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
        click.get_current_context().exit(INTERRUPTED + received[0])
    if controller.outcome != "success" or found["violated"]:
        click.get_current_context().exit(EXIT_FAILED)


def _begin(study: Study, drivers: Path, question: Question) -> None:
    """Writes a file of drivers to start from; one that is there is not overwritten."""
    from mcpn.controller.document import document
    from mcpn.drivers.reading import skeleton
    from mcpn.files import write_atomically
    from mcpn.runtime.tables import Tables

    if drivers.exists():
        raise InputError.at(Source(str(drivers)), "exists already, and is not overwritten")
    tables = Tables(document(study.controller("auto", max_states=question.max_states), study.mission_net))
    write_atomically(drivers, skeleton(tables))
    if question.as_json:
        emit_json({"files": [str(drivers)]})
    else:
        click.echo(str(drivers))


@contextlib.contextmanager
def _page(controller: Controller, study: Study | None, max_states: int | None) -> Iterator[RobotPage | None]:
    """Serves the page of a mission while the controller runs."""
    if study is None:
        yield None
        return
    from mcpn.editor.served import RobotPage, attached

    content = RobotPage(study, max_states)
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
    handlers = {"mcpn.drivers": handler, "asyncio": handler, "mcpn.runtime": silent}
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
