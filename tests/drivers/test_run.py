"""``mcpn run`` with a robot of processes: one is killed in the middle; interrupted, nothing is left."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.commands import mcpn, output
from tests.conftest import interruptible
from tests.drivers.robots import MISSION, NEVER, alive, numbers, until

ROBOT = Path(__file__).with_name("robot.py")
PARTS = """
never = {never}

[activities.lidar_driver]
process = ["{python}", "{robot}", "lidar"]
ends.other = "lidar_EV_OOS"

[activities.localisation]
process = ["{python}", "{robot}", "localisation"]

[activities.localisation.alternatives.by_odometry]
process = ["{python}", "{robot}", "odometry", "parent"]

[activities.drive]
process = ["{python}", "{robot}", "drive_{room}", "stubborn"]
lines = {arrived = "success"}
ends = {other = "failure"}
grace = 0.2
repeat = "safe"

[activities.hand_over]
process = ["{python}", "{robot}", "hand"]
ends = {0 = "success", other = "failure"}

[sources.panel]
process = ["{python}", "{robot}", "panel", "parent"]
lines = {"call(ed)? back" = "called_back"}

[release.wheels]
process = ["touch", "released"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "mission.xml").write_text(MISSION)
    text = PARTS.replace("{never}", json.dumps(NEVER)).replace("{robot}", str(ROBOT))
    (tmp_path / "drivers.toml").write_text(text)
    return tmp_path


@pytest.fixture
def started(folder: Path) -> Iterator[list[subprocess.Popen[str]]]:
    """Runs that a test has started; what it has left, with all of the robot, ends here."""
    runs: list[subprocess.Popen[str]] = []
    yield runs
    for run in runs:
        run.kill()
    for number in filter(alive, numbers(folder)):
        os.kill(number, signal.SIGKILL)
    for run in runs:
        run.communicate()  # whose error output the robot's processes share


def start(folder: Path, runs: list[subprocess.Popen[str]], *options: str) -> subprocess.Popen[str]:
    arguments = ["run", "mission.xml", "--drivers", "drivers.toml", "--journal", "log.jsonl", *options]
    run = subprocess.Popen(
        [sys.executable, "-m", "mcpn.cli", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
    )
    runs.append(run)
    return run


def order(folder: Path, part: str, text: str) -> None:
    """Tells a part, once it runs, what to print or with which status to end."""
    until(lambda: any(map(alive, numbers(folder, part))))
    beside = folder / f"{part}.new"
    beside.write_text(text)
    beside.rename(folder / f"{part}.order")


def journal(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]


def test_one_of_five_processes_is_killed(folder: Path, started: list[subprocess.Popen[str]]) -> None:
    run = start(folder, started, "--json")
    until(lambda: all(numbers(folder, part) for part in ("lidar", "localisation", "drive_12")))
    (lidar,) = numbers(folder, "lidar")
    os.kill(lidar, signal.SIGKILL)
    until(lambda: numbers(folder, "odometry"))
    until(lambda: not any(map(alive, numbers(folder, "localisation"))))
    assert any(map(alive, numbers(folder, "drive_12")))  # which goes on meanwhile
    order(folder, "drive_12", "arrived")
    order(folder, "hand", "0")
    order(folder, "drive_base", "arrived")
    out, err = run.communicate(timeout=60)
    assert (run.returncode, set(err.splitlines())) == (0, {"warning: drive has not ended within 0.2 seconds"})
    said = json.loads(out)
    assert (said["outcome"], said["events"], said["refused"]) == ("success", 5, 0)
    steps = journal(folder)
    assert [step["event"] for step in steps] == [
        "MISSION_EV_START",
        "lidar_EV_OOS",
        "OBJ_travel_EV_OK",
        "OBJ_give_EV_OK",
        "OBJ_home_EV_OK",
    ]
    assert "select localisation by_odometry" in steps[1]["actions"]
    assert not any(map(alive, numbers(folder)))
    assert (folder / "released").exists()
    replayed = output("simulate", folder / "mission.xml", "--events", folder / "log.jsonl")
    assert replayed["outcome"] == "success"


def test_interrupted_it_leaves_nothing_and_goes_on_from_there(
    folder: Path, started: list[subprocess.Popen[str]]
) -> None:
    run = start(folder, started, "--json", "--snapshot", "at.json")
    order(folder, "drive_12", "arrived")
    order(folder, "hand", "0")
    until(lambda: all(numbers(folder, part) for part in ("drive_base", "panel")))
    until(lambda: len(numbers(folder, "lidar")) == 2 and (folder / "released").exists())
    (folder / "released").unlink()
    run.send_signal(signal.SIGINT)
    out, _ = run.communicate(timeout=60)
    assert run.returncode == 130
    assert json.loads(out)["interrupted"]
    assert not any(map(alive, numbers(folder)))
    assert (folder / "released").exists()  # the wheels were taken
    assert [path.name for path in folder.glob(".*")] == []
    again = start(folder, started, "--json", "--resume", "at.json")
    order(folder, "drive_base", "arrived")
    out, _ = again.communicate(timeout=60)
    assert (again.returncode, json.loads(out)["outcome"]) == (0, "success")
    assert len(numbers(folder, "drive_12")) == 1
    assert len(numbers(folder, "drive_base")) == 2


def test_a_second_interruption_does_not_wait(folder: Path, started: list[subprocess.Popen[str]]) -> None:
    drivers = folder / "drivers.toml"
    drivers.write_text(drivers.read_text().replace("grace = 0.2", "grace = 1000"))
    run = start(folder, started)
    until(lambda: any(map(alive, numbers(folder, "drive_12"))))

    def ended() -> bool:
        run.send_signal(signal.SIGINT)
        return run.poll() is not None

    until(ended)
    assert run.returncode == 130
    assert not any(map(alive, numbers(folder)))


def test_a_source_tells_events_and_people_see_what_runs(
    folder: Path, started: list[subprocess.Popen[str]]
) -> None:
    run = start(folder, started)
    until(lambda: numbers(folder, "drive_12"))
    order(folder, "panel", "call back")
    order(folder, "drive_base", "1")
    out, err = run.communicate(timeout=60)
    assert run.returncode == 1, err
    assert "runs travel: drive, localisation (by_scan), lidar_driver" in out
    assert "called_back: stop drive" in out
    assert "drive: drive_base runs" in out
    assert "outcome      failure" in out


def test_what_no_activity_can_do_fails(folder: Path, started: list[subprocess.Popen[str]]) -> None:
    """Both sensors are lost: nothing of the objective runs that could say so."""
    drivers = folder / "drivers.toml"
    text = drivers.read_text().replace('"encoders_EV_*", ', '"encoders_EV_RD", ')
    drivers.write_text(text.replace('lines = {"call', 'lines = {"slips" = "encoders_EV_OOS", "call'))
    mission, watched = folder / "mission.xml", '<requirement name="sees" formula="G !oos(lidar)"'
    mission.write_text(MISSION.replace("  <on event", f"  {watched} severity='advice'/>\n  <on event"))
    run = start(folder, started, "--json", "--monitors")
    until(lambda: numbers(folder, "localisation"))
    order(folder, "panel", "slips")
    order(folder, "lidar", "3")
    out, _ = run.communicate(timeout=60)
    said = json.loads(out)
    assert (run.returncode, said["outcome"], said["violated"]) == (1, "failure", ["sees"])
    events = [step["event"] for step in journal(folder)]
    assert events[-2:] == ["OBJ_travel_EV_FAIL", "OBJ_home_EV_FAIL"]
    assert not any(map(alive, numbers(folder)))


def test_a_mission_that_fails_its_checks_is_not_run(folder: Path) -> None:
    mission, required = folder / "mission.xml", '<requirement name="never" formula="G !objective(give)"/>'
    mission.write_text(MISSION.replace("  <on event", f"  {required}\n  <on event"))
    arguments = ["run", mission, "--drivers", folder / "drivers.toml", "--check"]
    found = mcpn(*arguments)
    assert found.returncode == 1
    assert "not run" in found.stderr
    said = output(*arguments, code=1)
    assert said["unmet"] == ["never"]
    assert mcpn(*arguments, "--unverified").returncode == 0
    assert numbers(folder) == []


def test_a_snapshot_of_another_is_refused(folder: Path) -> None:
    (folder / "at.json").write_text("{}")
    arguments = ["run", folder / "mission.xml", "--drivers", folder / "drivers.toml"]
    found = mcpn(*arguments, "--resume", folder / "at.json")
    assert found.returncode == 2
    assert "at.json: the snapshot is not whole" in found.stderr
    assert numbers(folder) == []


PHOTO = """<mission name="photo" xmlns="urn:mcpn:mission:1">
  <robot name="drone">
    <hardware name="camera" detected="late"/>
    <hardware name="sonar"/>
    <activity name="look">
      <alternative name="by_eye" consumes="camera"/>
      <alternative name="by_ear" consumes="sonar"/>
    </activity>
    {test}
  </robot>
  {check}
  <objective name="search" activities="look" retries="1" {timeout}>
    <parameter name="honest" value="{honest}"/>
  </objective>
</mission>
"""
TEST = '<activity name="self_test" consumes="" detects="camera"/>'
CHECK = '<objective name="check" activities="self_test"/>'
SENSES = """
def test(call):
    call.say("dark")
    call.say("seen")
    return True

def eye(call):
    call.say("dark")
    return call.parameters.get("honest") != "true"

def ear(call):
    return True
"""
LOOKING = """
never = ["sonar_EV_*", "camera_EV_RD"]
[activities.look.alternatives.by_eye]
python = "senses:eye"
lines = { "dark" = "camera_EV_OOS" }
ends = { true = "success", other = "failure" }
[activities.look.alternatives.by_ear]
python = "senses:ear"
ends = { true = "success", other = "failure" }
"""
TESTING = """
[activities.self_test]
python = "senses:test"
lines = { "dark" = "camera_EV_OOS", "seen" = "camera_EV_DETECTED" }
ends = { true = "success", other = "failure" }
"""


@pytest.mark.parametrize(
    ("mission", "learnt"),
    [
        (
            PHOTO.format(test=TEST, check=CHECK, timeout="", honest=""),
            ["camera_EV_OOS", "camera_EV_DETECTED", "OBJ_check_EV_OK", "OBJ_search_try1_EV_OK"],
        ),
        (
            PHOTO.format(test="", check="", timeout="", honest="true"),
            ["camera_EV_OOS", "OBJ_search_try1_EV_FAIL", "OBJ_search_try2_EV_OK"],
        ),
        # A success that cannot be is kept, until the time is over.
        (
            PHOTO.format(test="", check="", timeout='timeout="0.3"', honest=""),
            ["camera_EV_OOS", "OBJ_search_try1_EV_TIMEOUT", "OBJ_search_try2_EV_OK"],
        ),
    ],
)
def test_a_driver_learns_of_a_loss_that_is_detected_late(
    mission: str, learnt: list[str], tmp_path: Path
) -> None:
    (tmp_path / "mission.xml").write_text(mission)
    (tmp_path / "senses.py").write_text(SENSES)
    (tmp_path / "drivers.toml").write_text(LOOKING + TESTING * ("self_test" in mission))
    log = tmp_path / "log.jsonl"
    found = output("run", tmp_path / "mission.xml", "--drivers", tmp_path / "drivers.toml", "--journal", log)
    assert (found["outcome"], found["refused"]) == ("success", 0)
    events = [json.loads(line)["event"] for line in log.read_text().splitlines()]
    assert events == ["MISSION_EV_START", *learnt]
