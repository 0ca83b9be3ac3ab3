"""Common causes: cut sets, severities, numbers and formulas where two sensors share a power board."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.risk import risk
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.simulator import Simulation, resources
from mcpn.drawing.compose import MissionNet, compose
from mcpn.events import Event
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.writer import written
from mcpn.mission.xml import read_mission
from mcpn.report.failures.openpsa import structured
from mcpn.report.pictures.objectives import mission_drawing
from mcpn.spaces.engine_names import SPACE_ENGINES, Engine
from mcpn.study import open_study
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import minimal

SHARED = """<mission name="dive" xmlns="urn:mcpn:mission:1">
  <robot name="auv">
    <hardware name="gps" failure_rate="{gps}"/><hardware name="imu" failure_rate="{imu}"/>
    <fault name="board" affects="gps imu" failure_rate="{board}"/>
    <activity name="locate"><alternative name="by_gps" consumes="gps"/>
      <alternative name="by_imu" consumes="imu"/></activity>
  </robot>
  <objective name="dive" activities="locate" duration="2"/>
</mission>
"""
GPS, IMU, BOARD, END = 0.25, 0.5, 0.125, 0.5


@pytest.fixture
def path(tmp_path: Path) -> Path:
    found = tmp_path / "dive.xml"
    found.write_text(SHARED.format(gps=GPS, imu=IMU, board=BOARD))
    return found


@pytest.fixture
def net(path: Path) -> MissionNet:
    return compose(read_mission(path))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_common_cause_is_a_cut_set_of_its_own(net: MissionNet, engine: Engine) -> None:
    asked = Asked(net, engine)
    assert asked.all.mission.cut_sets == [("board",), ("gps", "imu")]
    rows = {row.hardware: row for row in fmeca(asked.prospects)}
    assert rows["board"].severity is Severity.MISSION_LOST
    assert rows["board"].detection == "at once, by the error to locate"
    assert rows["gps"].severity is Severity.DEGRADED
    assert minimal(structured(net.usage).cut_sets("mission-lost")) == [("board",), ("gps", "imu")]


@pytest.mark.parametrize("engine", ENGINES)
def test_numbers_against_a_closed_form(net: MissionNet, engine: Engine) -> None:
    """Both sensors in service, then the one that is left; the board ends it at any moment."""
    one = {name: END / (END + rate + BOARD) for name, rate in (("gps", GPS), ("imu", IMU))}
    both = (END + GPS * one["imu"] + IMU * one["gps"]) / (END + GPS + IMU + BOARD)
    numbers = risk(Asked(net, engine).prospects)
    assert numbers.success == pytest.approx(both)
    # Without faults of the board: the same with its rate 0. With it from the start: nothing locates.
    alone = {name: END / (END + rate) for name, rate in (("gps", GPS), ("imu", IMU))}
    never = (END + GPS * alone["imu"] + IMU * alone["gps"]) / (END + GPS + IMU)
    assert numbers.importance["board"] == pytest.approx(never)


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("AG (oos(board) -> oos(gps) & oos(imu))", True),
        ("EF (oos(gps) & !oos(board))", True),
        ("EF (oos(board) & available(gps))", False),
        ("EF (objective(dive) & oos(imu) & EX success)", True),
        ("EF (objective(dive) & oos(board) & EX success)", False),
    ],
)
def test_formulas_speak_of_what_is_affected(path: Path, formula: str, holds: bool, engine: Engine) -> None:
    assert open_study(path).ctl(formula, engine=engine).holds is holds


def test_the_controller_takes_no_fault(net: MissionNet) -> None:
    text = str(document(generate(net), net))
    assert "board_EV_OOS" in text
    taken = {
        action["hardware"]
        for type_ in document(generate(net), net)["types"]
        for edge in type_["edges"]
        for action in edge["actions"]
        if "hardware" in action
    }
    assert taken == {"gps", "imu"}


def test_the_simulator_says_what_a_fault_takes_out(net: MissionNet) -> None:
    simulation = Simulation(net)
    assert dict(resources(net, simulation.situation)) == {"gps": "free", "imu": "free", "board": "no fault"}
    for event in ("MISSION_EV_START", "board_EV_OOS"):
        assert simulation.take(Event.parse(event)) is not None
    out = dict.fromkeys(("gps", "imu"), "out of service")
    assert dict(resources(net, simulation.situation)) == {**out, "board": "fault"}
    assert simulation.situation.refused == ("locate",)
    # The gps comes back with the board, and may fail by itself while that is out.
    for event in ("gps_EV_OOS", "board_EV_RD"):
        assert simulation.take(Event.parse(event)) is not None
    told = dict(resources(net, simulation.situation))
    assert told == {"gps": "out of service", "imu": "free", "board": "no fault"}


def test_the_picture_says_what_hardware_fails_with(net: MissionNet) -> None:
    told = mission_drawing(net).svg
    assert told.count("fails with board") == 2
    assert "gps + board" not in told


def test_it_is_written_as_it_was_read(path: Path, tmp_path: Path) -> None:
    mission = read_mission(path)
    other = tmp_path / "other.xml"
    other.write_bytes(written(mission))
    assert read_mission(other) == mission
    # An alternative consumes what its author says, and nothing that stands for a fault.
    assert 'consumes="gps"' in other.read_text()
    assert "board" in other.read_text()


def test_a_fault_of_what_nobody_uses_is_told(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
        <hardware name="h"/><hardware name="g"/>
        <fault name="f" affects="g"/><activity name="a" consumes="h"/></robot>
        <objective name="o" activities="a"/></mission>"""
    )
    told = [str(problem) for problem in find_warnings(compose(read_mission(path)).usage)]
    assert [t.partition(": ")[2] for t in told] == [
        "resource g is never used",
        "fault f affects nothing that is used",
    ]
