"""Nothing of a robot runs without its controller: signals, kills, drivers that are deaf or talk for ever."""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest

from mcpn import open as open_study
from mcpn.cli.robot.resuming import _alone, _rows
from mcpn.controller.document import document
from mcpn.errors import InputError
from mcpn.robot.drivers import warden
from mcpn.robot.drivers.inbox import LONGEST, Splitter
from mcpn.robot.drivers.running import RobotRun
from mcpn.robot.drivers.warden import ProcessGroup
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables
from tests.drivers.robots import alive, numbers, until
from tests.drivers.runs import Runs

PARTS = """
never = {never}

[activities.lidar_driver]
process = ["{python}", "{robot}", "lidar", "parent"]
ends.other = "lidar_EV_OOS"

[activities.localisation]
process = ["{python}", "{robot}", "localisation"]

[activities.drive]
process = ["{python}", "{robot}", "drive", "stubborn"]
lines = {arrived = "success"}
grace = 0.2
ends.other = "failure"

[activities.hand_over]
process = ["{python}", "{robot}", "hand"]
ends = {0 = "success", other = "failure"}

[sources.panel]
process = ["{python}", "{robot}", "panel"]
lines = {"called back" = "called_back"}

[release.wheels]
process = ["touch", "released"]
"""
ALL = ("lidar", "localisation", "drive", "panel")
Made = Callable[..., Runs]


@pytest.fixture
def made(runs_of: Made) -> Made:
    """Makes a folder of runs."""
    return lambda drivers=PARTS, **how: runs_of(drivers, **how)


def going(runs: Runs) -> None:
    """Waits until all of the robot runs, and the snapshot knows it."""
    until(lambda: all(runs.runs(part) for part in ALL))


def known(runs: Runs, count: int) -> None:
    """Waits until the snapshot names so many processes."""
    at = runs.folder / "at.json"

    def said() -> bool:
        if not at.exists():
            return False
        document = json.loads(at.read_text())
        return len(document.get("beside", {}).get("processes", {}).get("drivers", ())) >= count

    until(said)


@pytest.mark.parametrize(
    "name",
    [
        *("SIGHUP", "SIGTSTP", "SIGRTMIN"),
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGXCPU")
        ),
    ],
)
def test_every_signal_that_can_be_caught_stops_the_robot(name: str, made: Made) -> None:
    runs = made()
    run = runs.start("--json")
    going(runs)
    number = signal.Signals[name]
    run.send_signal(number)
    out, _ = run.communicate(timeout=120)
    assert run.returncode == 128 + number
    assert json.loads(out)["interrupted"]
    assert runs.left == []
    assert (runs.folder / "released").exists()


def test_who_is_killed_takes_the_robot_along(made: Made) -> None:
    """Also what a driver has started, a daemon too, and a driver that is deaf; nobody is left after that."""
    runs = made()
    run = runs.start()
    going(runs)
    assert len(runs.left) == 6
    run.kill()
    until(lambda: not runs.left, 120)


@pytest.mark.parametrize("ends", ["drive.order", None])
def test_what_a_driver_started_ends_with_it(ends: str | None, made: Made) -> None:
    """Also where the driver ends by itself, and a daemon; what has no mark stays."""
    free = "env -u MCPN_DRIVER setsid {python} {robot} free & exec {python} {robot} drive parent"
    drive = '"{python}", "{robot}", "drive", "stubborn"'
    assert drive in PARTS
    runs = made(PARTS.replace(drive, f'"sh", "-c", "{free}"'))
    run = runs.start()
    going(runs)
    until(lambda: len(runs.runs("drive")) == 3 and runs.runs("free"))
    if ends:
        (runs.folder / ends).write_text("1")
        until(lambda: len(numbers(runs.folder, "drive")) == 6)  # it failed, and the way home has begun
        assert len(runs.runs("drive")) == 3
    run.send_signal(signal.SIGTERM)
    run.wait(120)  # what it writes to stays open
    assert runs.left == runs.runs("free")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_who_is_killed_with_its_warden_takes_the_robot_along_too(made: Made) -> None:
    runs = made()
    run = runs.start("--snapshot", "at.json")
    going(runs)
    known(runs, 4)
    said = json.loads((runs.folder / "at.json").read_text())["beside"]["processes"]
    os.kill(said["warden"][0], signal.SIGKILL)
    run.kill()
    until(lambda: not runs.left, 20)


def test_drivers_that_outlive_their_warden_are_ended_before_a_run_goes_on(made: Made) -> None:
    """Controller and warden are killed at once; what is left is ended, and one drive drives."""
    runs = made(PARTS.replace('ends.other = "failure"', 'ends.other = "failure"\nrepeat = "safe"'))
    run = runs.start("--snapshot", "at.json")
    going(runs)
    known(runs, 4)
    said = json.loads((runs.folder / "at.json").read_text())["beside"]["processes"]
    (before,) = runs.runs("drive")
    keeper = said["warden"][0]
    for stand_in in Path(f"/proc/{keeper}/task/{keeper}/children").read_text().split():
        os.kill(int(stand_in), signal.SIGKILL)
    os.kill(keeper, signal.SIGKILL)
    run.kill()
    run.wait()
    assert alive(before)
    again = runs.start("--resume", "at.json", "--snapshot", "at.json")
    until(lambda: len(numbers(runs.folder, "drive")) == 2)
    assert not alive(before)
    going(runs)
    assert len(runs.left) == 6
    again.send_signal(signal.SIGTERM)
    _, err = again.communicate(timeout=120)
    assert again.returncode == 143
    assert re.search(rf"ended what was left of the previous run: process [\d, ]*{before}\b", err)
    assert runs.left == []


def test_a_run_that_ended_before_its_first_event_begins_when_it_is_resumed(made: Made) -> None:
    runs = made()
    study = open_study(runs.folder / "mission.xml")
    controller = Controller(Tables(document(study.controller("auto"), study.mission_net)))
    (runs.folder / "at.json").write_text(controller.snapshot())
    runs.start("--resume", "at.json")
    going(runs)


def test_a_run_that_goes_on_is_not_resumed(made: Made) -> None:
    runs = made()
    run = runs.start("--snapshot", "at.json")
    going(runs)
    known(runs, 4)
    (runs.folder / "copy.json").write_bytes((runs.folder / "at.json").read_bytes())
    other = runs.start("--resume", "copy.json")
    _, err = other.communicate(timeout=120)
    assert other.returncode == 2
    assert f"the run that wrote it still goes on: end process {run.pid} first" in err
    assert len(runs.left) == 6


def test_a_stranger_with_the_number_of_a_driver_lives() -> None:
    stranger = subprocess.Popen(["sleep", "1000"], start_new_session=True)
    try:
        since = warden.started_at(stranger.pid)
        assert since is not None
        assert warden.end([ProcessGroup(stranger.pid, f"{since}0", signal.SIGTERM, 0.0)]) == []
        assert stranger.poll() is None
        threading.Thread(target=stranger.wait).start()
        group = ProcessGroup(stranger.pid, since, signal.SIGTERM, 60.0)
        assert warden.end([group]) == [group]
        assert warden.end([group]) == []
    finally:
        stranger.kill()


@pytest.mark.parametrize(
    "changed",
    [
        *({"drivers": [[number, "boot:1", 15, 1.0]]} for number in (-5, 0, 1)),
        *({"drivers": [[5, "boot:1", stop, 1.0]]} for stop in (-1, 0, 1000)),
        *({"drivers": [[5, "boot:1", 15, grace]]} for grace in (-1.0, 1e9, float("nan"))),
        {"drivers": [[5]]},
        {"drivers": None},
        *({role: of} for role in ("controller", "warden") for of in ([], [5], ["5", "boot:1"], "on", 5)),
    ],
)
def test_a_snapshot_names_only_processes_that_can_be_drivers(changed: dict[str, object]) -> None:
    """Group 0 is mcpn's own: no such row reaches killpg."""
    said = {"controller": [5, "boot:1"], "warden": None, "drivers": [[6, "boot:1", 15, 1.0]]}
    assert _rows(Path("at.json"), said) == [ProcessGroup(6, "boot:1", 15, 1.0)]
    for lacking in said:
        with pytest.raises(InputError, match=r"at\.json"):
            _rows(Path("at.json"), {key: value for key, value in said.items() if key != lacking})
    with pytest.raises(InputError, match=r"at\.json"):
        _rows(Path("at.json"), said | changed)


def test_only_who_asks_again_takes_the_time_from_drivers() -> None:
    """Two records that fail in one event end a run in order; a second signal kills."""
    killed = []

    class Driver:
        def kill(self) -> None:
            killed.append(self)

    unused: Any = None
    run = RobotRun(unused, unused, unused)
    run.running["a"] = driver = cast(Any, Driver())
    run.end()
    run.end()
    assert killed == []
    run.end(again=True)
    assert killed == [driver]


def test_what_cannot_be_killed_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its run is not gone on with."""
    monkeypatch.setattr(warden, "is_left", lambda row: True)
    monkeypatch.setattr(warden, "send", lambda row, which: None)
    monkeypatch.setattr(warden, "KILLED", 0.05)
    group = ProcessGroup(5, "boot:1", signal.SIGTERM, 0.0)
    assert warden.end([group]) == [group]
    with pytest.raises(InputError, match="cannot be ended: process 5"):
        _alone(Path("at.json"), {"controller": None, "warden": None}, [group])


def test_a_group_of_another_boot_is_a_stranger(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where its leader is dead, so that no start of it can be compared."""
    monkeypatch.setattr(warden, "_boot", lambda: "now")
    monkeypatch.setattr(warden, "started_at", lambda number: None)
    monkeypatch.setattr(warden, "_group_is_there", lambda number: True)
    assert warden.is_left(ProcessGroup(5, "now:1", signal.SIGTERM, 0.0))
    assert not warden.is_left(ProcessGroup(5, "before:1", signal.SIGTERM, 0.0))


PANEL = """
[activities.hand_over]
nothing = true
[sources.panel]
process = ["{python}", "{robot}", "panel"]
lines = {"called back" = "called_back", "done" = "OBJ_give_EV_OK", "no" = "OBJ_give_EV_FAIL"}
"""
FLOOD = (
    """
never = {never}
[activities.lidar_driver]
process = ["yes", "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"]
ends.other = "lidar_EV_OOS"
[activities.localisation]
process = ["sh", "-c", "tr '\\\\0' a < /dev/zero"]
[activities.drive]
process = ["{python}", "{robot}", "drive"]
lines = {arrived = "success"}
ends.other = "failure"
"""
    + PANEL
)


def memory(number: int) -> int:
    """Bytes that a process has."""
    return int(Path(f"/proc/{number}/statm").read_text().split()[1]) * resource.getpagesize()


@pytest.mark.parametrize("signals", [(signal.SIGINT,), (signal.SIGTERM,)])
def test_signals_are_not_lost_behind_a_flood_of_lines(
    signals: tuple[signal.Signals, ...], made: Made
) -> None:
    """One driver prints without end, another one without a newline: neither fills the memory."""
    runs = made(FLOOD)
    run = runs.start(stdout=subprocess.DEVNULL)
    until(lambda: runs.runs("drive") and runs.runs("panel"))
    before = memory(run.pid) if Path("/proc/self/statm").exists() else 0
    written = runs.folder / "panel.order"
    for _ in range(20):  # the loop has turns for others, too: each order is read and told
        written.write_text("anything")
        until(lambda: not written.exists())
    if before:
        assert memory(run.pid) < before + (100 << 20)
    for number in signals:
        run.send_signal(number)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 128 + signals[0]
    assert err.count(f"localisation (by_odometry): a line has more than {LONGEST} bytes") == 0
    assert err.count(f"localisation (by_scan): a line has more than {LONGEST} bytes") == 1
    assert runs.left == []


def test_a_terminal_that_stands_still_stops_no_robot(made: Made) -> None:
    """Nobody reads standard output, which a flood fills at once."""
    runs = made(FLOOD)
    run = runs.start("--journal", "log.jsonl")
    until(lambda: runs.runs("drive") and runs.runs("panel"))
    for event in ("called back",):
        (runs.folder / "panel.order").write_text(event)
    until(lambda: "called_back" in (runs.folder / "log.jsonl").read_text())
    run.send_signal(signal.SIGTERM)
    until(lambda: not runs.left, 120)
    run.communicate(timeout=120)
    assert run.returncode in (143, 2)


DEAF = (
    """
never = {never}
[activities.lidar_driver]
process = ["{python}", "{robot}", "lidar"]
ends.other = "lidar_EV_OOS"
[activities.localisation]
process = ["{python}", "{robot}", "localisation", "stubborn"]
grace = 1000
[activities.localisation.alternatives.by_odometry]
process = ["{python}", "{robot}", "odometry"]
[activities.drive]
process = ["{python}", "{robot}", "drive"]
lines = {arrived = "success"}
ends.other = "failure"
"""
    + PANEL
)


def test_a_deaf_driver_delays_no_event(made: Made) -> None:
    """The old localisation does not end: what the panel tells is taken, the new one waits and says so."""
    runs = made(DEAF)
    out = runs.folder / "out.txt"

    def shown() -> str:
        return " ".join(out.read_text().split())  # lines are wrapped where COLUMNS says so

    with out.open("w") as stream:
        run = runs.start("--journal", "log.jsonl", stdout=stream)
    until(lambda: all(runs.runs(part) for part in ALL))
    (lidar,) = runs.runs("lidar")
    os.kill(lidar, signal.SIGKILL)
    log = runs.folder / "log.jsonl"
    until(lambda: "lidar_EV_OOS" in log.read_text())
    (runs.folder / "panel.order").write_text("called back")
    until(lambda: "called_back" in log.read_text())
    assert runs.runs("localisation")  # which has 1000 seconds
    assert numbers(runs.folder, "odometry") == []
    until(lambda: "localisation (by_odometry): start waits for localisation" in shown())
    assert "start is done" not in shown()
    os.kill(runs.runs("localisation")[0], signal.SIGKILL)
    until(lambda: runs.runs("odometry"))
    until(lambda: "localisation (by_odometry): start is done" in shown())
    run.send_signal(signal.SIGTERM)
    run.wait(120)
    assert runs.left == []


def test_a_line_that_is_too_long_is_left_out_as_a_whole() -> None:
    told: list[str] = []
    splitter = Splitter(5, lambda: told.append("long"))
    pieces = [b"one\ntw", b"o\r\nsixsix", b"six", b"\nfive5\nsixsix\n", b"last"]
    assert [line for piece in (*pieces, b"") for line in splitter.lines(piece)] == [
        "one",
        "two",
        "five5",
        "last",
    ]
    assert told == ["long", "long"]
    assert Splitter(5, lambda: None).lines(b"") == []


WORKERS = """
import os, sys, time
from mcpn.workers import executor_of

def number(_):
    time.sleep(1)
    return os.getpid()

if __name__ == "__main__":
    with executor_of(2) as pool:
        print(*{each for each in pool.map(number, range(2))}, flush=True)
        list(pool.map(number, range(1000)))
"""


def test_workers_end_with_their_parent(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(WORKERS)
    run = subprocess.Popen([sys.executable, str(program)], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    workers = [int(text) for text in run.stdout.readline().split()]
    try:
        assert workers
        assert all(map(alive, workers))
        run.kill()
        run.wait()
        until(lambda: not any(map(alive, workers)), 120)
    finally:
        run.kill()
        run.communicate()
