"""The page attached to a robot that runs: it shows each state as it comes, and tells nobody else."""

from __future__ import annotations

import http.client
import json
import os
import re
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from mcpn.controller.document import document
from mcpn.robot.runtime import Controller
from mcpn.study import open_study
from tests.commands import mcpn
from tests.drivers.robots import MISSION, until
from tests.report.tabs import boxes_of, compare, steps, visited

PARTS = """
never = ["lidar_EV_RD", "encoders_EV_*", "wheels_EV_*"]

[activities.lidar_driver]
python = "part:run"
lines.lost = "lidar_EV_OOS"

[activities.localisation]
python = "part:run"

[activities.drive]
python = "part:run"
lines = { arrived = "success", stuck = "failure" }

[activities.hand_over]
python = "part:run"
lines = { done = "success", lost = "failure" }

[sources.panel]
python = "part:run"
lines = { back = "called_back" }
"""
PART = """
import time
from pathlib import Path

def run(call):
    said = Path(call.activity)
    Path(call.activity + ".runs").touch()
    while not call.stopping.wait(0.01):
        if said.exists():
            line = said.read_text()
            said.unlink()
            call.say(line)
    Path(call.activity + ".runs").unlink(missing_ok=True)
"""


class Robot:
    """A run of the courier whose parts say what a test writes."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        (folder / "mission.xml").write_text(MISSION)
        (folder / "drivers.toml").write_text(PARTS)
        (folder / "part.py").write_text(PART)
        study = open_study(folder / "mission.xml")
        self.runtime = Controller.from_document(document(study.controller("auto"), study.mission_net))
        self.events: list[str] = []
        arguments = ["run", "mission.xml", "--drivers", "drivers.toml", "--page", "--json"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "mcpn.cli", *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stderr is not None
        self.address = ""
        for line in self.process.stderr:
            if line.startswith("page: "):
                self.address = line.split()[1]
                break
        self.takes("MISSION_EV_START")

    def says(self, part: str, line: str, event: str) -> None:
        """A part says a line, which tells an event."""
        until((self.folder / f"{part}.runs").exists)
        (self.folder / f"{part}.new").write_text(line)
        os.replace(self.folder / f"{part}.new", self.folder / part)
        self.takes(event)

    def takes(self, event: str) -> None:
        self.runtime.handle(event)
        self.events.append(event)


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    robot = Robot(tmp_path)
    yield robot
    robot.process.kill()
    robot.process.communicate()


def seen(tab: Any, robot: Robot) -> None:
    """The page shows where the robot is."""
    tab.locator("#robot-told", has_text=f": {len(robot.events)} events").wait_for()
    assert steps(tab) == robot.events
    compare(tab, robot.runtime, boxes_of(tab))


def test_the_page_shows_what_the_robot_does(browser: Any, robot: Robot) -> None:
    """Each state as the runtime has it, the lidar lost on the way; who clicks looks at something else."""
    tab, wrong = visited(browser, robot.address)
    seen(tab, robot)
    robot.says("lidar_driver", "lost", "lidar_EV_OOS")
    seen(tab, robot)
    assert tab.locator('rect[data-hardware="lidar"].out').count() == 1
    robot.says("drive", "arrived", "OBJ_travel_EV_OK")
    seen(tab, robot)
    late, also_wrong = visited(browser, robot.address)  # it is told what came before
    seen(late, robot)
    tab.locator('#events button[data-event="called_back"]').click()
    robot.says("hand_over", "done", "OBJ_give_EV_OK")
    seen(late, robot)
    tab.locator("#robot-told", has_text=f": {len(robot.events)} events").wait_for()
    assert steps(tab) == [*robot.events[:-1], "called_back"]
    assert not tab.locator("#robot-follows").is_checked()
    tab.locator("#robot-follows").check()
    seen(tab, robot)
    robot.says("drive", "arrived", "OBJ_home_EV_OK")
    for each in (tab, late):
        each.locator("#robot-told", has_text="The robot has ended in success").wait_for()
        seen(each, robot)
    out, _ = robot.process.communicate(timeout=60)
    assert (robot.process.returncode, json.loads(out)["outcome"]) == (0, "success")
    assert (wrong, also_wrong) == ([], [])


def test_nobody_else_is_told(robot: Robot) -> None:
    """It listens on this machine alone; without the token, under another name or from elsewhere: nothing."""
    place = urlsplit(robot.address)
    assert place.hostname == "127.0.0.1"
    assert len(place.path.strip("/")) >= 32

    def status(path: str, method: str = "GET", **headers: str) -> int:
        connection = http.client.HTTPConnection("127.0.0.1", place.port or 0, timeout=30)
        connection.request(method, path, None, {k.replace("_", "-"): v for k, v in headers.items()})
        found = connection.getresponse().status
        connection.close()
        return found

    for path in ("/", "/stream", "/x/stream", place.path[:-2] + "/stream"):
        assert status(path) == 403
    for headers in (
        {"Origin": "https://example.org"},
        {"Host": "evil.example"},
        {"Sec_Fetch_Site": "cross-site"},
    ):
        assert status(f"{place.path}stream", **headers) == 403
    assert status(f"{place.path}stream") == 200
    # Nothing is asked of a machine that pilots a robot, and nothing told to it.
    assert status(f"{place.path}ask", "POST", Content_Type="application/json") in (400, 404)
    assert status(f"{place.path}stream", "POST", Content_Type="application/json") == 404


def test_a_page_that_comes_back_is_told_the_rest(robot: Robot) -> None:
    robot.says("drive", "arrived", "OBJ_travel_EV_OK")
    asked = urllib.request.Request(f"{robot.address}stream", headers={"Last-Event-ID": "1"})
    with urllib.request.urlopen(asked, timeout=30) as stream:
        assert stream.headers["Content-Type"].startswith("text/event-stream")
        number, data = stream.readline().decode(), stream.readline().decode()
    assert number == "id: 2\n"
    assert json.loads(data.removeprefix("data: "))["event"] == "OBJ_travel_EV_OK"


def test_interrupted_the_page_is_told(browser: Any, robot: Robot) -> None:
    tab, _ = visited(browser, robot.address)
    seen(tab, robot)
    robot.process.terminate()
    tab.locator("#robot-told", has_text=re.compile("The robot was stopped: 1 events")).wait_for()
    robot.process.communicate(timeout=60)
    assert robot.process.returncode == 143


def test_a_run_that_goes_on_has_no_page(tmp_path: Path) -> None:
    (tmp_path / "mission.xml").write_text(MISSION)
    arguments = ("run", tmp_path / "mission.xml", "--drivers", "none.toml", "--page", "--resume", "at.json")
    found = mcpn(*arguments)
    assert found.returncode == 2
    assert "--page shows a run from its start" in found.stderr
