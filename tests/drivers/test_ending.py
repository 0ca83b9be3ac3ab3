"""How what was begun is ended: in a hurry, over messages, where it never began, where nobody reads."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from mcpn.cli.robot.resuming import _begun
from mcpn.cli.robot.shown_lines import MOST, ShownLines
from mcpn.errors import InputError
from mcpn.robot.drivers.topics import StopMessage, tell_to_stop
from tests.commands import mcpn, output
from tests.drivers.robots import MISSION, NEVER, numbers, until
from tests.drivers.runs import Runs

Made = Callable[..., Runs]
NOTHING = """
never = {never}
[activities.lidar_driver]
nothing = true
[activities.localisation]
nothing = true
[activities.hand_over]
nothing = true
[sources.panel]
process = ["{python}", "{robot}", "panel"]
[sources.panel.lines]
"called back" = "called_back"
"done" = "OBJ_give_EV_OK"
"no" = "OBJ_give_EV_FAIL"
"lost" = "lidar_EV_OOS"
[activities.drive]
"""
DRIVES = 'process = ["{python}", "{robot}", "drive"]\nlines = {arrived = "success"}\nends.other = "failure"\n'


@pytest.fixture
def made(runs_of: Made) -> Made:
    """Makes a folder of runs, of a courier of which only the drive is a driver's."""
    return lambda drivers: runs_of(NOTHING + drivers)


@pytest.mark.parametrize(
    "release",
    [
        'process = ["{python}", "{robot}", "release", "stubborn"]',
        'python = "slow:release"',
    ],
)
def test_a_second_signal_shortens_the_release(release: str, made: Made) -> None:
    """The release has a whole day, and is not at its end before that."""
    runs = made(DRIVES + f"[release.wheels]\n{release}\ngrace = 86400\n")
    (runs.folder / "slow.py").write_text(
        "import pathlib, time\n"
        "def release(call):\n"
        "    pathlib.Path('release.pids').write_text('')\n"
        "    time.sleep(86400)\n"
    )
    run = runs.start("--json")
    until(lambda: runs.runs("drive"))
    run.send_signal(signal.SIGTERM)
    until((runs.folder / "release.pids").exists)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 143
    assert "the release of wheels has not ended within 0.5 seconds" in err
    assert runs.left == []


def test_a_second_signal_waits_for_no_function(made: Made) -> None:
    runs = made(
        'python = "slow:drive"\ngrace = 86400\nends.other = "failure"\nlines = {arrived = "success"}\n'
    )
    (runs.folder / "slow.py").write_text(
        "import pathlib, time\n"
        "def drive(call):\n"
        "    pathlib.Path('begun').write_text('')\n"
        "    call.stopping.wait()\n"
        "    pathlib.Path('asked').write_text('')\n"
        "    time.sleep(86400)\n"
    )
    run = runs.start("--json")
    until((runs.folder / "begun").exists)
    run.send_signal(signal.SIGTERM)
    until((runs.folder / "asked").exists)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 143
    assert "drive has not ended" in err


@pytest.mark.parametrize(
    "program", ["#!/no/such/interpreter\n", "#!/bin/sh\nexit 127\n", "#!/bin/sh\nexit 3\n"]
)
def test_a_program_that_cannot_be_run_was_not_started(program: str, made: Made) -> None:
    """It is there, and executable; its interpreter is not. A program may end with any status itself."""
    ends = 'ends = { not_started = "called_back", other = "failure" }\nlines = {arrived = "success"}\n'
    runs = made('process = ["./drives"]\n' + ends)
    (runs.folder / "drives").write_text(program)
    (runs.folder / "drives").chmod(0o755)
    run = runs.start("--json", "--journal", "log.jsonl")
    log = runs.folder / "log.jsonl"
    until(lambda: log.exists() and log.read_text().count("\n") > 1)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    told = [json.loads(line)["event"] for line in log.read_text().splitlines()]
    absent = "no/such" in program
    assert told[1] == ("called_back" if absent else "OBJ_travel_EV_FAIL")
    assert ("the program './drives' cannot be run" in err) == absent


def test_a_program_beside_the_file_is_found_from_wherever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the file is named without its folder; and no program of PATH is taken for it."""
    (tmp_path / "mission.xml").write_text(MISSION)
    drivers = NOTHING.replace("{never}", json.dumps(NEVER)).replace("{robot}", "-c")
    ends = 'lines = {arrived = "success"}\nends.other = "failure"\n'
    (tmp_path / "drivers.toml").write_text(f'{drivers}process = ["./true"]\n{ends}')
    for folder in (tmp_path, tmp_path.parent):
        monkeypatch.chdir(folder)
        at = os.path.relpath(tmp_path)
        arguments = [
            "run",
            f"{at}/mission.xml",
            "--drivers",
            "drivers.toml" if at == "." else f"{at}/drivers.toml",
        ]
        assert "no program './true' is found" in mcpn(*arguments, "--check").stderr
        (tmp_path / "true").symlink_to(str(shutil.which("true")))
        assert output(*arguments, "--check")["drivers"]
        (tmp_path / "true").unlink()


def test_what_runs_behind_a_broker_is_told_to_stop_when_a_run_goes_on(made: Made, broker: int) -> None:
    """Killed, mcpn tells nobody to stop; the run that goes on does, and its starts have other numbers."""
    paho = pytest.importorskip("paho.mqtt.client", reason="needs mcpn[mqtt]")
    from paho.mqtt.enums import CallbackAPIVersion

    told: list[tuple[str, int]] = []
    client = paho.Client(CallbackAPIVersion.VERSION2)
    subscribed: list[int] = []
    client.on_subscribe = lambda *_: subscribed.append(1)
    client.on_message = lambda _client, _data, message: told.append(
        (message.topic.rpartition("/")[2], json.loads(message.payload)["run"])
    )
    client.connect("127.0.0.1", broker)
    client.subscribe("robot/#", 1)
    client.loop_start()
    runs = made(
        'mqtt = { start = "robot/{run}/start", stop = "robot/{run}/stop" }\nlines = {arrived = "success"}\n'
        'repeat = "safe"\n'
        '[sources.fails]\nmqtt = { says = "fails" }\n'
        'lines = { travel = "OBJ_travel_EV_FAIL", home = "OBJ_home_EV_FAIL" }\n'
        f'[mqtt]\nhost = "127.0.0.1"\nport = {broker}\n'
    )
    try:
        until(lambda: subscribed)
        run = runs.start("--snapshot", "at.json")
        until(lambda: told)
        run.kill()
        run.wait()
        (first,) = told
        assert first[0] == "start"
        run = runs.start("--snapshot", "at.json", "--resume", "at.json")
        until(lambda: len(told) >= 3)
        assert told[1] == ("stop", first[1])
        assert told[2][0] == "start"
        assert told[2][1] > first[1]
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=120)
        assert run.returncode == 143
        until(lambda: len(told) >= 4)
        assert told[3:] == [("stop", told[2][1])]
        assert "untold" not in json.loads((runs.folder / "at.json").read_text())["beside"]
    finally:
        client.disconnect()
        client.loop_stop()


@pytest.mark.parametrize(
    "said",
    [
        {"starts": -1},
        {"starts": "1"},
        {"untold": {}},
        {"untold": [["mqtt", "a"]]},
        {"untold": [["a", 1, ""]]},
    ],
)
def test_a_snapshot_says_what_is_to_be_told_to_stop(said: dict[str, object]) -> None:
    assert _begun(Path("at.json"), {}) == (0, ())
    message = StopMessage("mqtt", "a", "b")
    assert _begun(Path("at.json"), {"starts": 3, "untold": [["mqtt", "a", "b"]]}) == (3, (message,))
    tell_to_stop({}, message)  # which no driver is reached by any more: it is logged, and others are told
    with pytest.raises(InputError, match=r"at\.json"):
        _begun(Path("at.json"), said)


FLOOD = """
import logging, time
from pathlib import Path
def drive(call):
    while not call.stopping.is_set():
        for number in range(3000):
            logging.getLogger("mcpn.robot.drivers").warning("%s %d", "x" * 200, number)
        Path("flooded").write_text("")
        time.sleep(0.1)
"""


def longer(log: Path, count: int) -> bool:
    return log.read_text().count("\n") > count


def test_standard_error_that_stands_still_stops_no_robot(made: Made) -> None:
    """Nobody reads it, and warnings come without end: events are taken, and what is left out is counted."""
    runs = made('python = "flood:drive"\nends.other = "failure"\nlines = {arrived = "success"}\n')
    (runs.folder / "flood.py").write_text(FLOOD)
    ours, theirs = os.pipe()
    out = runs.folder / "out.json"
    with out.open("w") as stream:
        run = runs.start("--json", "--journal", "log.jsonl", stdout=stream, stderr=theirs)
    os.close(theirs)
    log = runs.folder / "log.jsonl"
    until(lambda: runs.runs("panel"))
    until((runs.folder / "flooded").exists)
    for count, event in enumerate(("lost", "called back"), 1):
        (runs.folder / "panel.new").write_text(event)
        (runs.folder / "panel.new").rename(runs.folder / "panel.order")
        until(partial(longer, log, count))
    run.send_signal(signal.SIGTERM)
    until(lambda: not runs.left, 120)
    assert run.wait(120) == 143
    os.close(ours)
    assert json.loads(out.read_text())["warnings_left_out"] > 0


def test_lines_that_are_left_out_are_counted_in_their_place() -> None:
    from threading import Event

    goes_on, told = Event(), list[str]()

    def show(text: str) -> None:
        goes_on.wait()
        told.append(text)

    shown = ShownLines(show, lambda count: f"({count})")
    for number in range(MOST + 10):
        shown.offer(str(number))
    goes_on.set()
    until(lambda: len(told) >= MOST)
    shown.put("last")
    shown.close()
    assert told[-2] == f"({shown.left_out})"
    assert told[-1] == "last"
    assert len(told) == MOST + 10 - shown.left_out + 2


def test_the_page_tells_what_is_not_recorded(made: Made) -> None:
    """As an event of its stream of its own, in the words of standard error."""
    import urllib.request

    from tests.drivers.test_records import no_room

    runs = made(DRIVES)
    run = runs.start("--journal", "log.jsonl", "--page", stdout=subprocess.DEVNULL, before=no_room)
    assert run.stderr is not None
    address = next(line for line in run.stderr if line.startswith("page: ")).split()[1]
    until(lambda: numbers(runs.folder, "drive"))
    with urllib.request.urlopen(address + "stream", timeout=120) as stream:
        for line in stream:
            if line.startswith(b"event: lost"):
                break
        said = json.loads(next(stream).removeprefix(b"data: "))
    assert said == "the journal log.jsonl cannot be written: File too large."
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=120)
    assert run.returncode == 2
