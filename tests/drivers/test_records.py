"""What a run records: full disks, kills in the middle, files that are damaged."""

from __future__ import annotations

import json
import os
import pty
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.journal import read_journal
from tests.commands import mcpn, output
from tests.conftest import interruptible
from tests.drivers.robots import numbers, until
from tests.drivers.runs import Runs

LOOP = """<mission name="loop" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="H"/><activity name="a" consumes="H"/></robot>
  {requirement}
  <each name="i" in="0 1 2 3 4 5 6 7 8 9"><objective name="o" activities="a" failure="succeed"/></each>
</mission>
"""
QUICK = """
never = ["H_EV_*"]
[activities.a]
process = ["true"]
ends = { 0 = "success", other = "failure" }
"""
SLOW = """
never = ["H_EV_*"]
[activities.a]
process = ["{python}", "{robot}", "a"]
ends = { 0 = "success", other = "failure" }
"""
SAFE = SLOW + 'repeat = "safe"\n'
ONCE = """<requirement name="first" severity="advice"
    formula="G (objective(o_1) -> X G !objective(o_0))"/>"""
Made = Callable[..., Runs]


@pytest.fixture
def made(runs_of: Made) -> Made:
    """Makes a folder of runs."""
    return lambda drivers, requirement="": runs_of(drivers, mission=LOOP.format(requirement=requirement))


def little_room() -> None:
    """For ``preexec_fn``: no file may grow beyond 4096 bytes; the disk is full, so to say."""
    interruptible()
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))


def no_room() -> None:
    """For ``preexec_fn``: not one event has room in a file."""
    interruptible()
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, resource.RLIM_INFINITY))


def begun(runs: Runs, count: int) -> None:
    """Waits until the activity has begun so often."""
    until(lambda: len(numbers(runs.folder, "a")) == count)


def events(path: Path) -> list[str]:
    return [told.event for told in read_journal(path.read_text().splitlines()) if not told.refused]


def test_a_full_disk_does_not_end_a_mission(made: Made) -> None:
    """The journal has room for some events; all objectives are done, and the loss is told."""
    runs = made(QUICK)
    run = runs.start("--json", "--journal", "log.jsonl", before=little_room)
    out, err = run.communicate(timeout=120)
    said = json.loads(out)
    assert (run.returncode, said["outcome"], said["events"]) == (2, "success", 11)
    assert said["lost"] == ["journal"]
    assert err.count("error: the journal log.jsonl cannot be written: File too large; the run goes on") == 1
    assert "error: not everything is recorded: the journal" in err
    assert "standard output" not in err


def test_a_run_that_must_record_is_ended_in_order(made: Made) -> None:
    runs = made(SLOW)
    run = runs.start("--json", "--journal", "log.jsonl", "--must-record", before=no_room)
    out, err = run.communicate(timeout=120)
    said = json.loads(out)
    assert (run.returncode, said["outcome"], said["events"], said["lost"]) == (2, None, 1, ["journal"])
    assert "File too large; the run is ended" in err
    assert numbers(runs.folder) == []  # the event was taken, and nothing begun for it


@pytest.mark.parametrize("what", ["/dev/full", "/dev/null", "pipe"])
def test_a_journal_is_a_file_on_a_disk(what: str, made: Made) -> None:
    """What a device has taken is on no disk, and a pipe that nobody reads would be waited for."""
    runs = made(SLOW)
    os.mkfifo(runs.folder / "pipe")
    run = runs.start("--journal", what)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 2
    assert f"{what}: a journal is a file on a disk, found no regular file" in err
    assert numbers(runs.folder) == []


def test_a_snapshot_that_cannot_be_written_once_is_written_later(made: Made) -> None:
    """Its folder is taken away while the robot runs, and is there again before the end."""
    runs = made(SLOW)
    (runs.folder / "kept").mkdir()
    run = runs.start("--json", "--snapshot", "kept/at.json")
    begun(runs, 1)
    (runs.folder / "kept").rename(runs.folder / "gone")
    (runs.folder / "a.order").write_text("0")
    begun(runs, 2)
    (runs.folder / "gone").rename(runs.folder / "kept")
    run.send_signal(signal.SIGTERM)
    out, err = run.communicate(timeout=120)
    assert (run.returncode, json.loads(out)["lost"]) == (143, [])
    assert err.count("the snapshot kept/at.json cannot be written") == 1
    assert err.count("the snapshot kept/at.json is written again, and is complete") == 1
    assert json.loads((runs.folder / "kept" / "at.json").read_text())["count"] == 2


def test_a_run_is_gone_on_with_in_the_same_journal_and_with_its_monitors(made: Made) -> None:
    """Killed and resumed, the journal is that of one run, and nothing is violated that never was."""
    runs = made(SAFE, requirement=ONCE)
    options = ("--json", "--monitors", "--journal", "log.jsonl", "--snapshot", "at.json")
    run = runs.start(*options)
    for count in (1, 2):
        begun(runs, count)
        (runs.folder / "a.order").write_text("0")
    begun(runs, 3)
    run.kill()
    run.wait()
    until(lambda: not runs.left, 120)
    run = runs.start(*options, "--resume", "at.json")
    for count in range(4, 12):
        begun(runs, count)
        (runs.folder / "a.order").write_text("0")
    out, _ = run.communicate(timeout=120)
    said = json.loads(out)
    assert (run.returncode, said["outcome"], said["violated"]) == (0, "success", [])
    log = runs.folder / "log.jsonl"
    assert events(log) == ["MISSION_EV_START", *(f"OBJ_o_{i}_EV_OK" for i in range(10))]
    assert sum("resumed" in json.loads(line) for line in log.read_text().splitlines()) == 1
    played = output("simulate", runs.folder / "mission.xml", "--events", log)
    assert played["outcome"] == "success"
    watched = output("monitor", runs.folder / "mission.xml", "--log", log)["log"]
    assert watched["events"] == 11


def interrupted(runs: Runs, done: int) -> None:
    """A run that is interrupted when some objectives are done and the next one has begun."""
    run = runs.start("--journal", "log.jsonl", "--snapshot", "at.json")
    for count in range(1, done + 1):
        begun(runs, count)
        (runs.folder / "a.order").write_text("0")
    begun(runs, done + 1)
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=120)
    assert run.returncode == 143


def test_what_happened_after_the_snapshot_is_taken_from_the_journal(made: Made) -> None:
    """The journal is one event ahead, as where a kill comes between the two files; half a line is cut off."""
    runs = made(SAFE)
    interrupted(runs, 2)
    log, at = runs.folder / "log.jsonl", runs.folder / "at.json"
    controller = Controller(Tables(of_mission(runs.folder / "mission.xml")))
    for event in events(log)[:2]:
        controller.handle(event)
    at.write_text(controller.snapshot())
    log.write_text(log.read_text() + '{"time": 17')
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json", "--snapshot", "at.json")
    begun(runs, 4)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    assert "its last line was not written to its end, and is cut off" in err
    assert json.loads(at.read_text())["count"] == 3
    assert len(events(log)) == 3


def test_a_journal_that_is_no_run_of_this_is_not_touched(made: Made) -> None:
    """It is verified before its last line is mended."""
    runs = made(SAFE)
    interrupted(runs, 1)
    log = runs.folder / "log.jsonl"
    text = log.read_text().replace("OBJ_o_0_EV_OK", "OBJ_o_0_EV_NO") + '{"time": 17'
    log.write_text(text)
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json")
    _, err = run.communicate(timeout=120)
    assert run.returncode == 2
    assert "log.jsonl:2: the line has been changed" in err
    assert log.read_text() == text


def test_an_event_that_lacks_only_its_end_of_line_is_not_lost(made: Made) -> None:
    runs = made(SAFE)
    interrupted(runs, 1)
    log = runs.folder / "log.jsonl"
    log.write_text(log.read_text().removesuffix("\n"))
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json")
    begun(runs, 3)
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=120)
    assert run.returncode == 143
    assert events(log) == ["MISSION_EV_START", "OBJ_o_0_EV_OK"]


def test_an_event_that_a_journal_lacks_in_its_middle_is_told(made: Made) -> None:
    runs = made(SAFE)
    interrupted(runs, 2)
    log = runs.folder / "log.jsonl"
    first, _, third = log.read_text().splitlines(keepends=True)
    log.write_text(first + third)
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json")
    _, err = run.communicate(timeout=120)
    assert run.returncode == 2
    assert "log.jsonl:2: event 3 found, 2 expected" in err


@pytest.mark.parametrize("lost", ["all", "the first"])
def test_a_run_that_must_record_does_not_go_on_without_its_record(lost: str, made: Made) -> None:
    """Its journal is gone, or begins in the middle; without ``--must-record`` this is told."""
    runs = made(SAFE)
    interrupted(runs, 2)
    log = runs.folder / "log.jsonl"
    text = log.read_text()
    log.write_text("" if lost == "all" else "".join(text.splitlines(keepends=True)[1:]))
    missing = 3 if lost == "all" else 1
    options = ("--journal", "log.jsonl", "--resume", "at.json")
    run = runs.start(*options, "--must-record")
    _, err = run.communicate(timeout=120)
    assert run.returncode == 2
    assert f"the run is to be recorded, and its first {missing} events are not in this journal" in err
    assert len(numbers(runs.folder)) == 3  # nothing is begun
    run = runs.start(*options)
    begun(runs, 4)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    assert ("it begins in the middle: the run's first 3 events are not in it" in err) == (lost == "all")


def test_a_run_that_must_record_does_not_go_on_where_nothing_can_be_recorded(made: Made) -> None:
    """The line that says that the run is resumed has no room."""
    runs = made(SAFE)
    interrupted(runs, 1)
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json", "--must-record", before=no_room)
    _, err = run.communicate(timeout=120)
    assert run.returncode == 2
    assert "log.jsonl: not everything can be recorded: nothing is run" in err
    assert len(numbers(runs.folder)) == 2  # nothing is begun


def test_the_last_snapshot_is_written_where_the_run_breaks_down(tmp_path: Path) -> None:
    """The loop raises, by a fault of mcpn's own: the robot is stopped, and the snapshot says so."""
    program = (
        "import mcpn.robot.drivers.running as running\n"
        "from mcpn.cli import main\n"
        "def broken(self, actions): raise ZeroDivisionError\n"
        "running.RobotRun._carry_out = broken\n"
        "main()\n"
    )
    runs = Runs(tmp_path, QUICK, LOOP.format(requirement=""))
    options = ["--journal", "log.jsonl", "--snapshot", "at.json"]
    arguments = ["run", "mission.xml", "--drivers", "drivers.toml", *options]
    ran = subprocess.run(
        [sys.executable, "-c", program, *arguments], cwd=runs.folder, capture_output=True, check=False
    )
    assert b"ZeroDivisionError" in ran.stderr
    said = json.loads((runs.folder / "at.json").read_text())
    assert said["count"] == 1
    assert "processes" not in said["beside"]
    assert len(events(runs.folder / "log.jsonl")) == 1


@pytest.mark.parametrize("answer", ["y", "n"])
def test_who_stands_before_the_robot_is_asked(answer: str, made: Made) -> None:
    """At a terminal; the third objective had begun."""
    runs = made(SLOW + 'repeat = "ask"\n')
    interrupted(runs, 2)
    ours, theirs = pty.openpty()
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json", stdin=theirs)
    os.close(theirs)
    os.write(ours, f"{answer}\n".encode())
    begun(runs, 4)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    os.close(ours)
    assert "a had begun for o_2: begin it again?" in err
    last = events(runs.folder / "log.jsonl")[-1]
    assert last == ("OBJ_o_1_EV_OK" if answer == "y" else "OBJ_o_2_EV_FAIL")


def of_mission(path: Path) -> dict[str, Any]:
    net = compose(read_mission(path))
    return document(generate(net), net)


def test_what_had_begun_and_may_not_be_repeated_has_failed(made: Made) -> None:
    """The third objective is not begun again: it is told as failed, and the fourth begins."""
    runs = made(SLOW)
    interrupted(runs, 2)
    run = runs.start("--journal", "log.jsonl", "--resume", "at.json")
    begun(runs, 4)
    run.send_signal(signal.SIGTERM)
    _, err = run.communicate(timeout=120)
    assert 'a had begun for o_2, and may not be begun again (repeat = "fail"): o_2 has failed' in err
    assert events(runs.folder / "log.jsonl")[-1] == "OBJ_o_2_EV_FAIL"


def test_a_snapshot_without_monitors_resumes_none(made: Made) -> None:
    runs = made(SAFE, requirement=ONCE)
    interrupted(runs, 1)
    arguments = ["run", runs.folder / "mission.xml", "--drivers", runs.folder / "drivers.toml", "--monitors"]
    found = mcpn(*arguments, "--resume", runs.folder / "at.json")
    assert found.returncode == 2
    assert "the snapshot says nothing of monitors" in found.stderr
