"""Going on with a run: what is left of it is ended, and no event that its journal has is lost."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded, why_not_written

if TYPE_CHECKING:
    from mcpn.robot.drivers.mapping import Plan
    from mcpn.robot.drivers.running import RobotRun
    from mcpn.robot.drivers.topics import StopMessage
    from mcpn.robot.drivers.warden import ProcessGroup
    from mcpn.robot.runtime.controller import Controller
    from mcpn.robot.runtime.controller_tables import Tables
    from mcpn.robot.runtime.monitors import Monitors


LONGEST = 600.0
"""Seconds that the warden of the run before may take to end what that run has started."""


@dataclass(frozen=True)
class Resumed:
    """A run that is gone on with.

    Args:
        failures: Tells the controller, once it is observed, which objectives have failed because the activity
            that was begun for them may not be begun again.
        starts: How many drivers were started in it.
        untold: What it has begun by a message, and has not ordered to stop.
    """

    failures: Callable[[], None] = lambda: None
    starts: int = 0
    untold: tuple[StopMessage, ...] = ()


def beside(monitors: Monitors | None, runner: RobotRun | None, ended: bool) -> dict[str, Any]:
    """What stands beside the controller in the snapshot of a run.

    Args:
        monitors: What watches it.
        runner: Knows its drivers.
        ended: Whether none of them runs any more.
    """
    from dataclasses import astuple

    from mcpn.robot.drivers.warden import started_at

    found: dict[str, Any] = {}
    if monitors is not None:
        found["monitors"] = {"digest": monitors.digest, "state": monitors.state}
    if runner is not None:
        found["starts"] = runner.starts
        if untold := runner.untold:
            found["untold"] = [list(message) for message in untold]
    if runner is not None and not ended:
        warden = runner.warden
        found["processes"] = {
            "controller": [os.getpid(), started_at(os.getpid())],
            "warden": None if (row := warden.row) is None else [row.number, row.since],
            "drivers": [list(astuple(row)) for row in warden.rows.values()],
        }
    return found


def resumed(
    path: Path,
    controller: Controller,
    tables: Tables,
    monitors: Monitors | None,
    journal: Path | None,
    plan: Plan,
    may_repeat: Callable[[str, str], bool],
    must_record: bool = False,
) -> Resumed:
    """Brings a controller to where a run has stopped, when nothing of that run is left.

    Args:
        path: The snapshot.
        controller: A new controller, which then stands where the snapshot was taken.
        tables: Its tables.
        monitors: What is to watch it.
        journal: The journal that is gone on with: events in it that the snapshot does not know yet are
            taken, for they have happened.
        plan: The drivers.
        may_repeat: Asked of an activity and its objective whether it may be begun again.
        must_record: Whether the journal must have all events of the run from its start.

    Raises:
        InputError: The snapshot or the journal is damaged or of another run, or the run still goes on.
    """
    from mcpn.robot.runtime.file_schema import DamagedFile

    try:
        text = read_bounded(path).decode()
        said = controller.beside(text)
        rows = _rows(path, said.get("processes"))
        starts, untold = _begun(path, said)
        _alone(path, said.get("processes"), rows)
        controller.restore(text)
        if monitors is not None:
            _watching(monitors, said.get("monitors"))
    except (DamagedFile, ValueError) as error:
        raise InputError.at(Source(str(path)), str(error)) from None
    if journal is not None:
        first = _taken(controller, monitors, journal)
        missing = controller.count if first is None else first - 1
        if missing and must_record:
            what = f"the run is to be recorded, and its first {missing} events are not in this journal"
            raise InputError.at(Source(str(journal)), what)
        if missing and first is None:
            what = f"it begins in the middle: the run's first {missing} events are not in it"
            click.echo(f"warning: {journal}: {what}", err=True)
    return Resumed(lambda: _fail(controller, tables, plan, may_repeat), starts, untold)


def _begun(path: Path, said: Mapping[str, Any]) -> tuple[int, tuple[StopMessage, ...]]:
    """How many drivers a run has started, and what it has to tell to stop."""
    from mcpn.robot.drivers.topics import StopMessage

    starts, untold = said.get("starts", 0), said.get("untold", [])
    whole = (
        type(starts) is int
        and starts >= 0
        and isinstance(untold, list)
        and all(
            isinstance(message, list) and len(message) == 3 and all(type(t) is str for t in message)
            for message in untold
        )
    )
    if not whole:
        raise InputError.at(Source(str(path)), "the snapshot's list of drivers to stop is malformed")
    return starts, tuple(StopMessage(*message) for message in untold)


def _rows(path: Path, said: Any) -> list[ProcessGroup]:
    from mcpn.robot.drivers.known import MOST_SECONDS
    from mcpn.robot.drivers.warden import ProcessGroup

    if said is None:
        return []
    try:
        for process in (said["controller"], said["warden"]):
            if process is not None and (len(process) != 2 or type(process[0]) is not int):
                raise ValueError(f"{process!r} is no process")
        rows = [
            ProcessGroup(int(number), str(since), int(stop), float(grace))
            for number, since, stop, grace in said["drivers"]
        ]
        for row in rows:  # 0 and 1 stand for mcpn's own group and the whole machine
            if not (
                row.number >= 2 and row.stop in signal.valid_signals() and 0 <= row.grace <= MOST_SECONDS
            ):
                raise ValueError(f"{row} is no driver")
        return rows
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InputError.at(
            Source(str(path)), f"the snapshot's list of processes is malformed: {error!r}"
        ) from None


def _alone(path: Path, said: Mapping[str, Any] | None, rows: list[ProcessGroup]) -> None:
    """Ends what is left of the run before, or refuses where that run goes on."""
    from mcpn.robot.drivers import warden

    if said is None:
        return

    def is_there(process: Any) -> bool:
        return (
            process is not None and process[0] != os.getpid() and warden.started_at(process[0]) == process[1]
        )

    if is_there(said["controller"]):
        number = said["controller"][0]
        raise InputError.at(
            Source(str(path)), f"the run that wrote it still goes on: end process {number} first"
        )
    until = time.monotonic() + LONGEST
    while is_there(said["warden"]):
        if time.monotonic() > until:
            raise InputError.at(
                Source(str(path)), f"process {said['warden'][0]} still ends drivers of that run"
            )
        time.sleep(warden.LOOK)
    if left := warden.end(rows):
        if still := ", ".join(str(row.number) for row in left if warden.is_left(row)):
            raise InputError.at(Source(str(path)), f"drivers of that run cannot be ended: process {still}")
        numbers = ", ".join(str(row.number) for row in left)
        click.echo(f"warning: ended what was left of the previous run: process {numbers}", err=True)


def _watching(monitors: Monitors, said: Any) -> None:
    if said is None:
        raise ValueError("--monitors: the snapshot says nothing of monitors, for none watched that run")
    if said["digest"] != monitors.digest:
        raise ValueError("--monitors: the snapshot is of a run that other requirements were watched in")
    monitors.resume(said["state"])


def _taken(controller: Controller, monitors: Monitors | None, path: Path) -> int | None:
    """Takes the events that a journal has and the snapshot does not; then its last line is mended.

    Nothing is written before all that stands there is known to be of this run.

    Returns:
        The number of the first event; ``None`` if there is none.
    """
    from mcpn.robot.runtime.actions import Refused
    from mcpn.robot.runtime.journal import JournalError, read_journal

    if not path.exists():
        return None
    data = read_bounded(path)
    whole = data.rfind(b"\n") + 1
    lacks_its_end = whole < len(data) and _is_whole(data[whole:])
    first = last = None
    line = 0
    try:
        for told in read_journal(data[: None if lacks_its_end else whole].decode().splitlines()):
            line = told.line
            if told.number is None:
                raise JournalError("expected the number of the event, as mcpn run writes it", line)
            expected = last + 1 if last is not None else min(told.number, controller.count + 1)
            if told.number != expected:
                raise JournalError(f"event {told.number} found, {expected} expected", line)
            first, last = told.number if first is None else first, told.number
            if told.number <= controller.count:
                continue
            try:
                controller.react(told.event)
                taken = True
            except Refused:
                taken = False
            if taken == told.refused:
                raise JournalError(
                    f"{told.event} was {'' if told.refused else 'not '}refused, unlike here", line
                )
            if taken and monitors is not None:
                monitors.take(told.event)
        if last is not None and last < controller.count:
            raise JournalError(
                f"it ends at event {last}, the snapshot was taken after event {controller.count}", line
            )
    except JournalError as error:
        raise InputError.at(Source(str(path), error.line), str(error)) from None
    except UnicodeDecodeError:
        raise InputError.at(Source(str(path)), "it is no text") from None
    if whole < len(data):
        _mend(path, None if lacks_its_end else whole)
    return first


def _is_whole(line: bytes) -> bool:
    """Whether a line of a journal lacks nothing, but the end of the line."""
    from mcpn.robot.runtime.file_schema import DamagedFile, parsed, signed_line

    try:
        text = line.decode()
        return text == signed_line(parsed(text))
    except (DamagedFile, UnicodeDecodeError):
        return False


def _mend(path: Path, whole: int | None) -> None:
    """Ends the last line of a journal, or cuts off what stands behind so many bytes.

    Raises:
        InputError: It cannot be written.
    """
    try:
        if whole is None:
            with path.open("ab") as file:
                file.write(b"\n")
            return
        os.truncate(path, whole)
    except OSError as error:
        raise InputError.at(Source(str(path)), why_not_written(path, error)) from None
    click.echo(f"warning: {path}: its last line was not written to its end, and is cut off", err=True)


def _fail(controller: Controller, tables: Tables, plan: Plan, may_repeat: Callable[[str, str], bool]) -> None:
    from mcpn.robot.drivers.mapping import FAILURE, ending

    state = controller.state
    for objective in state.objectives:
        for activity in tables.laws.objectives[objective]["activities"]:
            way = state.mode.get(activity)
            spec = None if way is None else plan.driver(activity, way)
            if (
                spec is None
                or spec.repeat == "safe"
                or (spec.repeat == "ask" and may_repeat(activity, objective))
            ):
                continue
            event = ending(objective, FAILURE)
            if event in controller.possible:
                click.echo(
                    f"warning: {activity} had begun for {objective}, and may not be begun again "
                    f'(repeat = "{spec.repeat}"): {objective} has failed',
                    err=True,
                )
                controller.react(event)
                break
