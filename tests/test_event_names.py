"""A declared event has one name, the one that the mission declares, wherever people and programs meet it."""

from __future__ import annotations

from io import StringIO
from pathlib import Path

import pytest

from mcpn.robot.runtime import Controller, Refused
from mcpn.robot.targets import TARGETS
from tests.commands import mcpn, output

MISSION = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="camera"/><event name="battery_low"/>
    <activity name="map" consumes="camera"/><activity name="drift"/></robot>
  <requirement name="home" formula="G (happens(battery_low) -> X objective(home))"/>
  <on event="battery_low" goto="home"/>
  <objective name="survey" activities="map"/>
  <objective name="home" activities="drift"/>
</mission>
"""
DRIVERS = """never = ["camera_EV_*", "OBJ_*"]
[activities.map]
process = ["true"]
[activities.drift]
process = ["true"]
[sources.panel]
process = ["true"]
lines = { "low" = "NAME" }
"""


@pytest.fixture(autouse=True)
def mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("m.xml").write_text(MISSION)
    return tmp_path / "m.xml"


@pytest.mark.parametrize("target", TARGETS)
def test_the_targets(target: str, tmp_path: Path) -> None:
    output("controller", "m.xml", "-o", "out", "--target", target)
    written = "".join(path.read_text() for path in (tmp_path / "out").rglob("*") if path.is_file())
    assert "battery_low" in written
    assert "battery_low_EV" not in written.replace("battery_low_EVENT", "")


def test_runs_words_and_nets(monkeypatch: pytest.MonkeyPatch) -> None:
    output("convert", "m.xml", "m.net")
    shown = mcpn("ask", "m.xml").stdout + mcpn("ask", "m.xml", "EF objective(home)").stdout
    monkeypatch.setattr("sys.stdin", StringIO("MISSION_EV_START\nbattery_low\n"))
    shown += mcpn("simulate", "m.xml").stdout + Path("m.net").read_text()
    assert "battery_low" in shown
    assert "battery_low_EV" not in shown


@pytest.mark.parametrize("name", ["battery_low", "battery_low_EV"])
def test_the_old_spelling_is_understood(name: str) -> None:
    """Where files hold it: formulas, drivers, runs, scripts of faults; and where a program says it."""
    assert mcpn("ask", "m.xml", f"EF event({name})").returncode == 0
    Path("m2.xml").write_text(MISSION.replace("happens(battery_low)", f"happens({name})"))
    assert mcpn("check", "m2.xml").returncode == 0
    Path("drivers.toml").write_text(DRIVERS.replace("NAME", name))
    assert mcpn("run", "m.xml", "--drivers", "drivers.toml", "--check").returncode == 0
    Path("run.txt").write_text(f"MISSION_EV_START\n  2. it happens  [{name}]\nOBJ_home_EV_OK\n")
    assert mcpn("simulate", "m.xml", "--events", "run.txt").returncode == 0
    Path("faults.txt").write_text(f"0.0 {name}\n")
    told = output("bench", "m.xml", "--runs", "5", "--faults", "faults.txt")
    assert told["coverage"]["edges"] == 3  # the start, the event that is told at once, the end at home
    output("controller", "m.xml", "-o", "out")
    controller = Controller.load("out/controller.json")
    controller.handle("MISSION_EV_START")
    assert [str(action) for action in controller.handle(name)][-1] == "start drift"
    assert controller.log[-1].event == "battery_low"
    with pytest.raises(Refused, match="'no_EV' is no event of this mission"):
        controller.handle("no_EV")
