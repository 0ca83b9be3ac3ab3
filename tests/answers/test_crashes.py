"""Software that crashes: verdicts, causes, numbers and controllers, beside hardware in its place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import assume, event, example, given

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.minimal_cut_sets import Moment
from mcpn.answers.causes.risk import risk
from mcpn.answers.verdicts.mission import check
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.simulator import Simulation, resources
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event, What
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.writer import written
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime.controller import Controller
from mcpn.spaces.engine_names import Engine
from mcpn.study import Study
from mcpn.testing import missions
from tests.answers.crashing import with_hardware
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import fragile_missions
from tests.small import mission, robot

CONTENDING = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="h" faulty="false"/>
    <software name="s"/>
    <activity name="producer" consumes="h" produces="s" faulty="true" failure_rate="1"/>
    <activity name="work"><alternative name="best" consumes="s h"/><alternative name="last"/></activity>
  </robot>
  <objective name="begin" activities="work" duration="4" failure_probability="0.25"/>
  <objective name="end" activities="work" duration="1" failure_probability="0.5"/>
</mission>
"""
"""The producer waits for what the best way holds: nothing succeeds unless it has crashed before the start."""

FORMS: tuple[Form, ...] = ("flat", "hierarchical", "modular")

LOCALISE = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <activity name="localise" {whole}>
      <alternative name="by_scan" {scan}/>
      <alternative name="by_odometry" {odometry}/>
    </activity>
    <activity name="wait"><alternative name="wait"/></activity>
  </robot>
  <objective name="first" activities="wait" duration="1"/>
  <objective name="drive" activities="localise" duration="1"/>
</mission>
"""


def localising(tmp_path: Path, whole: str = "", scan: str = "", odometry: str = "") -> Mission:
    path = tmp_path / "m.xml"
    path.write_text(LOCALISE.format(whole=whole, scan=scan, odometry=odometry))
    return read_mission(path)


@pytest.mark.parametrize("engine", ENGINES)
def test_it_crashes_only_while_it_runs(tmp_path: Path, engine: Engine) -> None:
    of = localising(tmp_path, scan='faulty="true"', odometry='faulty="true"')
    study = Study(of)
    for formula, holds in {
        "AG (oos(localise.by_scan) -> !alternative(localise.by_scan))": True,
        "EF (objective(first) & event(localise.by_scan_EV_OOS))": False,
        "AG (event(localise.by_odometry_EV_OOS) -> alternative(localise.by_odometry))": True,
        "EF (oos(localise.by_scan) & alternative(localise.by_odometry))": True,
        "AG (oos(localise.by_odometry) -> EF !oos(localise.by_odometry))": True,
        # It goes on with odometry although the scan has recovered: nothing returns undeclared.
        "EF (event(localise.by_scan_EV_RD) & EX alternative(localise.by_odometry))": True,
    }.items():
        assert study.ctl(formula, engine=engine).holds is holds, formula


@pytest.mark.parametrize("engine", ENGINES)
def test_numbers_by_hand(tmp_path: Path, engine: Engine) -> None:
    # An hour of waiting, in which nothing crashes, then an hour of driving on the mean.
    once = 'faulty="true" recovers="false" failure_rate="0.5"'
    numbers = risk(Asked(compose(localising(tmp_path, whole=once)), engine).prospects)
    assert numbers.success == pytest.approx(1 / 1.5)
    assert numbers.importance == pytest.approx({"localise": 1.0})
    numbers = risk(Asked(compose(localising(tmp_path, scan=once, odometry=once)), engine).prospects)
    assert numbers.success == pytest.approx((1 + 0.5 * (1 / 1.5)) / 1.5)
    each = 1 - 1 / 1.5
    assert numbers.importance == pytest.approx(
        {"localise.by_scan": each, "localise.by_odometry": 1 - 1 / 1.5}
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_what_recovers_meanwhile_is_there_again(engine: Engine) -> None:
    """Driving fails by a crash, then the robot waits an hour in which the driver recovers at 2 per hour."""
    go = Activity(
        name="go", faulty=True, failure_rate=0.5, repair_rate=2.0, alternatives=(Alternative(name="go"),)
    )
    wait = Activity(name="wait", alternatives=(Alternative(name="wait"),))
    drive = Objective(name="drive", activities=("go",), duration=1.0, success="succeed", failure="rest")
    rest = Objective(name="rest", activities=("wait",), duration=1.0)
    of = mission(robot((), go, wait), drive, rest, replace(drive, name="again", success=None, failure=None))
    numbers = risk(Asked(compose(of), engine).prospects)
    well = 1 / 1.5
    assert numbers.success == pytest.approx(well + (1 - well) * (2 / 3) * well)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_entered_after_an_earlier_crash_alone_counts(tmp_path: Path, engine: Engine) -> None:
    """Composition had left out the sections that are entered in no run from the start."""
    (tmp_path / "m.xml").write_text(CONTENDING)
    numbers = risk(Asked(compose(read_mission(tmp_path / "m.xml")), engine).prospects)
    assert numbers.success == 0.0
    assert numbers.importance == pytest.approx({"producer": -0.75 * 0.5})


@pytest.mark.parametrize("engine", ENGINES)
def test_cut_sets_severities_and_runs(tmp_path: Path, engine: Engine) -> None:
    scan, odometry = 'faulty="true"', 'faulty="true" recovers="false"'
    asked = Asked(compose(localising(tmp_path, scan=scan, odometry=odometry)), engine)
    causes = asked.all
    assert causes.mission.cut_sets == [("localise.by_odometry", "localise.by_scan")]
    assert causes.objectives["first"].cut_sets == []
    assert causes.objectives["drive"].moments[Moment.ENTRY.value] == causes.mission.cut_sets
    (run,) = causes.mission.runs.values()
    assert run is not None
    assert [str(e) for e in run.events] == [
        "MISSION_EV_START",
        "OBJ_first_EV_OK",
        "localise.by_scan_EV_OOS",
        "localise.by_odometry_EV_OOS",
        "OBJ_drive_EV_FAIL",
    ]
    rows = {(row.hardware, row.objective): row for row in fmeca(asked.prospects)}
    # What cannot fail in an objective has no row there.
    assert set(rows) == {("localise.by_scan", "drive"), ("localise.by_odometry", "drive")}
    row = rows["localise.by_scan", "drive"]
    assert row.severity is Severity.DEGRADED
    assert row.detection == "at once: localise has crashed"
    assert row.local_effect == "localise: by_scan -> by_odometry"


def renamed(cut_sets: list[tuple[str, ...]], names: dict[str, str]) -> set[frozenset[str]]:
    return {frozenset(names.get(h, h) for h in cut_set) for cut_set in cut_sets}


NEVER_WON = Mission(
    name="never_won",
    robots=(
        Robot(
            name="r",
            hardware=(Hardware(name="h", faulty=False),),
            software=(Software(name="s", exclusive=True),),
            activities=(
                Activity(
                    name="producer",
                    produces=("s",),
                    alternatives=(
                        Alternative(name="first", consumes=("h",)),
                        Alternative(name="second", faulty=True, recovers=False),
                    ),
                ),
                Activity(
                    name="consumer",
                    alternatives=(
                        Alternative(name="one", consumes=("s", "h"), faulty=True, recovers=False),
                        Alternative(name="other", faulty=True, recovers=False),
                    ),
                ),
            ),
        ),
    ),
    blocks=(Objective(name="obj", activities=("consumer",)),),
)
"""An activity and its own producer want one hardware: only a loss before the start resolves that."""


@fewer(0.25)
@example(NEVER_WON)
@given(
    fragile_missions(max_objectives=2, max_sections=4, max_hardware=1, max_producers=1, crashes=True)
    | missions(sections=3, hardware=1, producers=1, crashes=True, aborts=1, loops=False)
)
def test_cut_sets_are_those_of_hardware_in_their_place(of: Mission) -> None:
    """What it means that something is lost for good is asked of software as of hardware."""
    other, names = with_hardware(of)
    event(f"may crash: {min(len(names), 3)}")
    assume(names)
    try:
        expected, subject = Asked(compose(other)), compose(of)
        never = check(subject).unselectable  # what never runs never crashes, and may be lost as hardware
        assume(not any(way in said.message for said in never for way in names.values()))
        for engine in ENGINES:
            asked = Asked(subject, engine)
            for name in (None, *asked.prospects.objectives):
                goal = asked.prospects.mission if name is None else asked.prospects.objectives[name]
                if not goal.won:
                    continue  # what no run wins may be won where hardware is lost before anything runs
                for moment in Moment:
                    if name is not None or moment is not Moment.ENTRY:
                        found = renamed(asked.cut_sets(name, moment), {})
                        assert found == renamed(expected.cut_sets(name, moment), names), (engine, moment)
    except (LimitError, SemanticsError):
        assume(False)


@pytest.mark.parametrize("form", FORMS)
def test_a_controller_refuses_a_crash_of_what_does_not_run(tmp_path: Path, form: Form) -> None:
    net = compose(localising(tmp_path, scan='faulty="true"'))
    told = document(generate(net, form), net)
    assert told["crashing"] == ["localise.by_scan"]
    controller = Controller.from_document(told)
    assert list(controller.possible) == ["MISSION_EV_START"]
    controller.handle("MISSION_EV_START")
    assert "localise.by_scan_EV_OOS" not in controller.possible
    controller.handle("OBJ_first_EV_OK")
    actions = controller.handle("localise.by_scan_EV_OOS")
    # The robot takes and releases nothing that stands for a crash.
    assert [(a.verb, a.activity) for a in actions] == [("select", "localise")]
    controller.handle("OBJ_drive_EV_OK")
    assert list(controller.possible) == ["localise.by_scan_EV_RD"]


def test_the_simulator_says_what_has_crashed(tmp_path: Path) -> None:
    net = compose(localising(tmp_path, scan='faulty="true"', odometry='faulty="true"'))
    simulation = Simulation(net)
    assert simulation.cut_set() is None  # nothing may fail now
    for text in ("MISSION_EV_START", "OBJ_first_EV_OK", "localise.by_scan_EV_OOS"):
        simulation.take(Event.parse(text))
    said = dict(resources(net, simulation.situation))
    assert said == {"localise.by_scan": "crashed", "localise.by_odometry": "not crashed"}
    assert simulation.cut_set() == ("localise.by_odometry",)


def test_one_crash_that_keeps_another_away_is_no_cut_set() -> None:
    """The driver crashes, and its consumer has no way to run, so that it cannot crash any more."""
    driver = Activity(name="driver", produces=("scan",), faulty=True, alternatives=(Alternative(name="d"),))
    ways = (Alternative(name="by_scan", consumes=("scan",), faulty=True), Alternative(name="blind"))
    drive = Activity(name="drive", alternatives=ways)
    of = mission(
        Robot(name="r", software=(Software(name="scan"),), activities=(driver, drive)),
        Objective(name="o", activities=("drive",)),
    )
    simulation = Simulation(compose(of))
    simulation.take(Event.parse("MISSION_EV_START"))
    assert simulation.cut_set() is None
    crashes = [e.element for e in simulation.possible if e.what is What.OUT_OF_SERVICE]
    assert crashes == ["driver", "drive.by_scan"]


def test_it_is_written_as_it_was_read(tmp_path: Path) -> None:
    of = localising(tmp_path, 'faulty="true" repair_rate="2"', 'faulty="true" recovers="false"')
    other = tmp_path / "other.xml"
    other.write_bytes(written(of))
    assert read_mission(other) == of
    assert other.read_text().count("faulty") == 2
    assert "consumes" not in other.read_text()


def test_what_never_runs_is_told_once(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="h"/>
        <activity name="a" consumes="h"/><activity name="b" consumes="h" faulty="true"/></robot>
        <objective name="o" activities="a"/></mission>"""
    )
    net = compose(read_mission(path))
    told = [str(problem).partition(": ")[2] for problem in find_warnings(net.usage)]
    assert told == ["activity b is never started"]
    assert Asked(net).all.mission.cut_sets == [("h",)]
