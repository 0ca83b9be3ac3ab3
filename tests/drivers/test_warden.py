"""The warden: whom it ends when its controller is gone, and in which order."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from mcpn.robot.drivers import warden
from mcpn.robot.drivers.inbox import Inbox
from mcpn.robot.drivers.processes import ProcessDriver, Warden, row_of
from mcpn.robot.drivers.warden import ProcessGroup
from tests.drivers.robots import alive, numbers, until
from tests.drivers.runs import Runs

DRIVER = """
import signal, sys, time
def leave(*_):
    with open(sys.argv[1], "a") as file:
        file.write(sys.argv[2])
    sys.exit()
signal.signal(signal.SIGTERM, leave)
print(flush=True)
time.sleep(60)
"""


class Drivers:
    """Processes that note in one file that they were asked to end."""

    def __init__(self, folder: Path) -> None:
        self.notes = folder / "ended"
        self.notes.touch()
        self.processes: list[subprocess.Popen[bytes]] = []

    def start(self, name: str) -> ProcessGroup:
        """Starts one that notes its name."""
        command = [sys.executable, "-c", DRIVER, str(self.notes), name]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True)
        self.processes.append(process)
        assert process.stdout is not None
        process.stdout.readline()
        row = row_of(process.pid, signal.SIGTERM, 20.0)
        assert row is not None
        return row


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    made = Drivers(tmp_path)
    yield made
    for process in made.processes:
        process.kill()
        process.communicate()


def test_what_was_started_last_ends_first(drivers: Drivers) -> None:
    """Each has ended before the one that it may stand on is asked to."""
    rows = [drivers.start(name) for name in "abc"]
    assert warden.end(rows) == rows[::-1]
    assert drivers.notes.read_text() == "cba"


def test_what_has_been_ended_is_not_ended_again(drivers: Drivers) -> None:
    """The warden is told: a process that is forgotten outlives it, others do not."""
    kept, forgotten = drivers.start("k"), drivers.start("f")
    of = Warden()
    of.watch(kept)
    of.watch(forgotten)
    of.forget(forgotten.number)
    of.close()
    assert drivers.notes.read_text() == "k"
    os.kill(forgotten.number, 0)
    assert list(of.rows) == [kept.number]


NOTING = """
import signal, sys, time
def note(name):
    with open(name, "a") as file:
        file.write(sys.argv[1] + " ")
def leave(*_):
    note("ended")
    sys.exit()
signal.signal(signal.SIGTERM, leave)
note("begun")
time.sleep(60)
"""
RUN = """
never = {never}

[activities.lidar_driver]
process = ["{python}", "noting.py", "lidar"]
ends.other = "lidar_EV_OOS"

[activities.localisation]
process = ["{python}", "noting.py", "localisation"]

[activities.drive]
process = ["{python}", "noting.py", "drive"]
ends = {0 = "success", other = "failure"}

[activities.hand_over]
process = ["{python}", "noting.py", "hand"]
ends = {0 = "success", other = "failure"}

[sources.panel]
process = ["{python}", "noting.py", "panel"]
lines = {"called back" = "called_back"}

[sources.radio]
process = ["{python}", "noting.py", "radio"]
lines = {"called back" = "called_back"}

[release.wheels]
process = ["true"]
"""


def test_a_run_stops_what_it_started_last_first(runs_of: Callable[..., Runs], tmp_path: Path) -> None:
    """Sources, which began before all else, at the end, and the last of them first."""
    (tmp_path / "noting.py").write_text(NOTING)
    run = runs_of(RUN).start()
    begun, ended = tmp_path / "begun", tmp_path / "ended"
    until(lambda: begun.exists() and len(begun.read_text().split()) == 5)
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=120)
    assert ended.read_text().split() == ["drive", "localisation", "lidar", "radio", "panel"]


def test_a_driver_that_has_been_stopped_is_forgotten(tmp_path: Path) -> None:
    """Else a warden would keep what ended long ago, and end a stranger of its number."""

    async def played() -> tuple[list[int], list[int]]:
        keeper = Warden()
        inbox = Inbox(lambda line: None, lambda: True)
        driver = ProcessDriver(
            "one", ["sleep", "60"], tmp_path, inbox, lambda *how: None, signal.SIGTERM, 20.0, keeper
        )
        await driver.start()
        begun = list(keeper.rows)
        await driver.stop(20.0)
        keeper.close()
        return begun, list(keeper.rows)

    begun, left = asyncio.run(played())
    assert len(begun) == 1
    assert left == []


STUBBORN = """
(trap '' TERM; exec sleep 60) & echo $! >children.new
(trap '' TERM; exec setsid sleep 60) & echo $! >>children.new
mv children.new children.pids
wait
"""


def test_what_a_driver_has_started_is_gone_when_it_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A killed process runs until the system takes it away, which may be long after the signal was sent."""
    real = warden.send

    def late(row: ProcessGroup, which: int) -> None:
        if which == signal.SIGKILL:
            threading.Timer(0.3, real, (row, which)).start()
        else:
            real(row, which)

    async def played() -> list[int]:
        keeper = Warden()
        inbox = Inbox(lambda line: None, lambda: True)
        driver = ProcessDriver(
            "one", ["sh", "-c", STUBBORN], tmp_path, inbox, lambda *how: None, signal.SIGTERM, 20.0, keeper
        )
        await driver.start()
        until(lambda: numbers(tmp_path))
        assert all(map(alive, numbers(tmp_path)))
        assert await driver.stop(20.0)
        left = [number for number in numbers(tmp_path) if alive(number)]
        keeper.close()
        return left

    monkeypatch.setattr(warden, "send", late)
    assert asyncio.run(played()) == []
    assert len(numbers(tmp_path)) == 2
