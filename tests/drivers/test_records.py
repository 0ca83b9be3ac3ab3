"""What a run records: full disks, kills in the middle, files that are damaged."""

from __future__ import annotations

import json
import os
import pty
import random
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mcpn.files as mcpn_files
from mcpn.cli.play.event_files import events_of_file
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.files import write_atomically, write_folder
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller, DamagedFile, Journal, Monitors
from mcpn.robot.runtime.file_schema import parsed, signed_line
from mcpn.robot.runtime.journal import read_journal
from mcpn.robot.runtime.monitors import watch
from mcpn.robot.runtime.restoring import read_snapshot
from mcpn.robot.runtime.tables import Tables, read
from mcpn.robot.targets.json import write_json
from mcpn.study import open_study
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


# --- files are written whole ---


def test_what_a_killed_process_has_left_is_swept(tmp_path: Path) -> None:
    program = (
        "import os, signal, sys; from pathlib import Path; import mcpn.files as f\n"
        "f.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "f.write_atomically(Path('one.txt'), 'x')\n"
    )
    subprocess.run([sys.executable, "-c", program], cwd=tmp_path, check=False)
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(".one.txt.")
    write_atomically(tmp_path / "one.txt", "y", durable=True)
    assert [path.name for path in tmp_path.iterdir()] == ["one.txt"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1])
@pytest.mark.parametrize("when", ["before", "after"])
def test_a_signal_at_the_renaming_leaves_nothing_beside(number: int, when: str, tmp_path: Path) -> None:
    program = (
        "import os, sys, mcpn.files as f\n"
        "from mcpn.cli import main\n"
        "replace = os.replace\n"
        "def renamed(*of):\n"
        f"    if {when!r} == 'before': os.kill(os.getpid(), {int(number)})\n"
        "    replace(*of)\n"
        f"    os.kill(os.getpid(), {int(number)})\n"
        "f.os.replace = renamed\n"
        "sys.argv = ['mcpn', 'convert', 'mission.xml', 'net.pnml']\n"
        "main()\n"
    )
    (tmp_path / "mission.xml").write_text(LOOP.format(requirement=""))
    ran = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, preexec_fn=interruptible, check=False)
    assert ran.returncode == 128 + number
    assert {path.name for path in tmp_path.iterdir()} - {"net.pnml"} == {"mission.xml"}
    assert (tmp_path / "net.pnml").exists() == (when == "after")


def test_a_folder_of_files_is_replaced_at_once(tmp_path: Path) -> None:
    """Killed at any call of the system that writes, all files are the old ones, or all the new ones."""
    (tmp_path / "probe").mkdir()
    (tmp_path / "other").mkdir()
    if not mcpn_files._exchanged(tmp_path / "probe", tmp_path / "other"):
        pytest.skip("this file system cannot exchange two folders")
    folder = tmp_path / "build"
    old, new = ({name: f"{name} {age}" for name in "abc"} for age in ("old", "new"))
    program = (
        "import os, signal, sys; from pathlib import Path; import mcpn.files as f\n"
        "left = int(sys.argv[1])\n"
        "def counted(call):\n"
        "    def called(*of, **how):\n"
        "        global left\n"
        "        left -= 1\n"
        "        if left == 0: os.kill(os.getpid(), signal.SIGKILL)\n"
        "        return call(*of, **how)\n"
        "    return called\n"
        "for name in ('_write', '_exchanged', '_remove', '_place'):\n"
        "    setattr(f, name, counted(getattr(f, name)))\n"
        f"f.write_folder(Path('build'), {new!r})\n"
    )
    seen = []
    for at in range(1, 20):
        write_folder(folder, old)
        ran = subprocess.run([sys.executable, "-c", program, str(at)], cwd=tmp_path, check=False)
        found = {path.name: path.read_text() for path in folder.iterdir()}
        assert found in (old, new)
        seen.append(found == new)
        if ran.returncode == 0:
            break
    assert seen == sorted(seen)
    assert (seen.count(False) >= 4, seen.count(True)) == (True, 2)  # three files, the exchange; removed, done
    assert {path.name for path in tmp_path.iterdir()} == {"build", "probe", "other"}  # the rest was swept


def test_a_folder_that_somebody_stands_in_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor is one replaced that is a link, or has more in it."""
    monkeypatch.chdir(tmp_path)
    write_folder(tmp_path, {"a": "1"})
    number = tmp_path.stat().st_ino
    for folder in (tmp_path, Path(), Path("../") / tmp_path.name):
        write_folder(folder, {"a": "2"})
        assert (tmp_path.stat().st_ino, (tmp_path / "a").read_text()) == (number, "2")
    (tmp_path / "link").symlink_to(tmp_path / "far")
    (tmp_path / "far").mkdir()
    write_folder(tmp_path / "link", {"a": "3"})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "far" / "a").read_text() == "3"


@pytest.mark.parametrize("there", [False, True])
def test_a_folder_is_written_as_a_whole_or_not_at_all(there: bool, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "build"
    if there:
        folder.mkdir(parents=True)
        (folder / "a").write_text("before")
        (folder / "other").write_text("stays")
    with pytest.raises(Exception, match="cannot be"):
        write_folder(folder, {"a": "1", "b\0": "2"})
    assert {path.name for path in folder.iterdir()} == {"a", "other"} if there else not folder.parent.exists()
    assert not there or (folder / "a").read_text() == "before"
    write_folder(folder, {"a": "1", "b": "2"})
    assert {path.name for path in folder.iterdir()} == {"a", "b"} | ({"other"} if there else set())
    assert (folder / "a").read_text() == "1"


# --- files are read back as they were written ---


def kinds(folder: Path) -> dict[str, tuple[bytes, Callable[[Path], object]]]:
    """By kind of file, one as it is written, and what it means when it is read back."""
    path = folder / "mission.xml"
    path.write_text(LOOP.format(requirement=ONCE))
    net = compose(read_mission(path))
    controller = Controller.from_document(document(generate(net), net))
    monitors = Monitors(json.loads(files(monitors_of(open_study(path).mission_spaces()))["monitors.json"]))
    log = folder / "log"
    with log.open("w") as stream:
        journal = Journal(stream)
        controller.observe(journal)
        for event in ("MISSION_EV_START", "H_EV_OOS", "OBJ_o_0_EV_FAIL"):
            controller.handle(event)
            monitors.take(event)
        journal.resumed(3)
    beside = {"monitors": {"digest": monitors.digest, "state": monitors.state}}
    text = files(monitors_of(open_study(path).mission_spaces()))["monitors.json"]

    def watched(path: Path) -> object:
        fresh = Monitors(json.loads(text))
        watch(fresh, path.read_text().splitlines())
        return fresh.count, fresh.state

    tables = controller._tables

    def snapshot(path: Path) -> object:
        saved = read_snapshot(path.read_text(), tables)
        return parsed(saved.text(tables.digest))

    return {
        "controller": (write_json(document(generate(net), net)).encode(), lambda path: read(path).digest),
        "monitors": (
            files(monitors_of(open_study(path).mission_spaces()))["monitors.json"].encode(),
            lambda path: Monitors.load(path).digest,
        ),
        "snapshot": (controller.snapshot(beside).encode(), snapshot),
        "journal": (
            log.read_bytes(),
            lambda path: [*map(meant, read_journal(path.read_text().splitlines()))],
        ),
        "journal, replayed": (log.read_bytes(), lambda path: [*events_of_file(path)]),
        "journal, watched": (log.read_bytes(), watched),
    }


def meant(told: Any) -> tuple[str, bool, int | None]:
    return told.event, told.refused, told.number


def flipped(folder: Path, times: int) -> dict[str, int]:
    """Flips bits of each kind of file, one at a time: none is read with another meaning."""
    rng, path, same = random.Random(11), folder / "file", dict[str, int]()
    for kind, (whole, means) in kinds(folder).items():
        path.write_bytes(whole)
        expected = means(path)
        same[kind] = 0
        for bit in (rng.randrange(8 * len(whole)) for _ in range(times)):
            changed = bytearray(whole)
            changed[bit // 8] ^= 1 << bit % 8
            path.write_bytes(changed)
            try:
                found = means(path)
            except (DamagedFile, InputError, UnicodeDecodeError):
                continue
            assert found == expected, (kind, bit)
            same[kind] += 1
    return same


def test_a_flipped_bit_is_found(tmp_path: Path) -> None:
    same = flipped(tmp_path, 200)
    assert all(count < 20 for count in same.values())  # a space, a capital letter of an escape


@pytest.mark.slow
def test_ten_thousand_flipped_bits_are_found(tmp_path: Path) -> None:
    print(flipped(tmp_path, 10_000))  # noqa: T201


def test_numbers_that_python_cannot_hold_are_told(tmp_path: Path) -> None:
    """What is nested for ever, or is no number, is an error of the one tree."""
    monitors = json.loads(kinds(tmp_path)["monitors"][0])
    path = tmp_path / "file"
    for text in (
        "[" * 100_000,
        '{"a":' * 100_000,
        "1" * 5000,
        json.dumps(monitors | {"version": float("inf")}),
    ):
        path.write_text(text)
        for load in (Monitors.load, read):
            with pytest.raises(DamagedFile):
                load(path)
    assert signed_line({"a": 1, "digest": "x"}) == signed_line({"a": 1})
