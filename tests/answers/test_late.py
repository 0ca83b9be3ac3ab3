"""Loss that is detected late: what can still succeed, causes by brute force, and who refuses it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st
from scipy.linalg import expm

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.passages import Beside
from mcpn.answers.causes.risk import Risk, risk
from mcpn.answers.verdicts.mission import check
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.simulator import Simulation, resources
from mcpn.drawing.compose import compose
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.mission.robot import Hardware
from mcpn.mission.writer import written
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.runtime import Refused, SnapshotError
from mcpn.robot.runtime.restoring import snapshot_text
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.answers.dense import Dense, with_numbers
from tests.answers.test_cutsets import confirm
from tests.answers.test_fmeca import assert_severities
from tests.answers.test_risk_interrupted import assert_same
from tests.commands import mcpn
from tests.draws import fewer
from tests.logic.asked import Asked
from tests.logic.oracle import fragile_missions

KNOWING: tuple[Engine, ...] = ("explicit", "symbolic", "local")
FORMS: tuple[Form, ...] = ("flat", "hierarchical", "modular")

PHOTO = """<mission name="photo" xmlns="urn:mcpn:mission:1">
  <robot name="drone">
    <hardware name="camera" detected="late" failure_rate="1"/>
    <hardware name="sonar"/>
    <activity name="look">
      <alternative name="by_eye" consumes="camera"/>
      <alternative name="by_ear" consumes="sonar"/>
    </activity>
    <activity name="self_test" consumes="" detects="camera" {rate}/>
  </robot>
  {first}<objective name="search" activities="look" duration="1" retries="{tries}"/>
</mission>
"""
TEST = '<objective name="test" activities="self_test" duration="1"/>'


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "photo.xml"


def photo(path: Path, first: str = "", tries: int = 0, rate: str = "") -> Mission:
    path.write_text(PHOTO.format(first=first, tries=tries, rate=rate))
    return read_mission(path)


@pytest.mark.parametrize("engine", KNOWING)
def test_what_is_lost_unnoticed_does_not_serve(path: Path, engine: Engine) -> None:
    for first, tries, formula, holds in (
        # Nobody notices: the robot goes on to look by eye, and cannot succeed.
        ("", 0, "AG (objective(search) & oos(camera) -> alternative(look)=by_eye)", True),
        ("", 0, "EF (objective(search) & oos(camera) & event(OBJ_search_EV_OK))", False),
        ("", 0, "AG (oos(camera) -> !EF success)", False),  # it may be lost when nobody needs it any more
        ("", 0, "AG (objective(search) & oos(camera) -> !EF success)", True),
        # The first try that fails tells.
        ("", 1, "EF (alternative(look)=by_eye & oos(camera) & EX alternative(look)=by_ear)", True),
        ("", 1, "AG (objective(search_try2) & oos(camera) & alternative(look)=by_eye -> EF success)", False),
        ("", 1, "AG (oos(camera) & alternative(look)=by_ear -> EF success)", True),
        # A test before finds it, if it is lost by then.
        (TEST, 0, "AG (objective(test) & oos(camera) -> EF success)", True),
        (TEST, 0, "AG (objective(search) & oos(camera) & alternative(look)=by_eye -> EF success)", False),
    ):
        study = Study(photo(path, first, tries))
        assert study.ctl(formula, engine=engine).holds is holds, (tries, formula)


@pytest.mark.parametrize("engine", KNOWING)
def test_causes_by_hand(path: Path, engine: Engine) -> None:
    once, twice, tested = (Asked(compose(photo(path, *of)), engine) for of in (("", 0), ("", 1), (TEST, 0)))
    assert once.all.mission.cut_sets == [("camera",)]  # sonar is of no use, as nobody knows
    assert twice.all.mission.cut_sets == [("camera", "sonar")]
    assert tested.all.mission.cut_sets == [("camera", "sonar")]
    (run,) = once.all.mission.runs.values()
    assert run is not None
    assert [str(e) for e in run.events][-1] == "OBJ_search_EV_FAIL"
    rows = {(row.hardware, row.objective): row for row in fmeca(tested.prospects)}
    late = "late, by self_test when it runs, or as an objective fails that uses it"
    assert rows["camera", "search"].detection == late
    assert rows["camera", "search"].severity is Severity.MISSION_LOST
    assert rows["camera", "test"].detection == "by self_test, which runs"
    (row,) = [row for row in fmeca(once.prospects) if row.hardware == "camera"]
    assert row.severity is Severity.MISSION_LOST


@pytest.mark.parametrize("engine", KNOWING)
def test_verdicts(path: Path, engine: Engine) -> None:
    found = check(compose(photo(path, "", 1)), engine=engine)
    assert all(verdict.holds for verdict in found.verdicts.values() if verdict.required)


def small(of: Mission) -> bool:
    try:
        direct(compose(of).net, max_states=400)
    except (LimitError, SemanticsError):
        return False
    return True


@fewer(0.4)
@given(
    fragile_missions(max_objectives=2, max_sections=4, max_hardware=2, late=True)
    | missions(max_objectives=2, max_sections=4, max_hardware=2, max_producers=1, late=True, aborts=1),
    st.sampled_from(KNOWING),
)
def test_cut_sets_are_those_of_brute_force(of: Mission, engine: Engine) -> None:
    assume(of.late and small(of))
    confirm(Asked(compose(of), engine))


@fewer(0.2)
@given(
    fragile_missions(max_objectives=2, max_sections=4, max_hardware=2, late=True), st.sampled_from(KNOWING)
)
def test_severities_are_those_of_plain_search(of: Mission, engine: Engine) -> None:
    assume(of.late and small(of))
    net = compose(of)
    assert_severities(net, fmeca(Asked(net, engine).prospects))


@fewer(0.5)
@given(missions(sections=4, hardware=2, producers=2, branches=3, late=True, lasting=True))
def test_compact_templates_do_the_same(of: Mission) -> None:
    assume(of.late and small(of))
    each = [direct(compose(of, templates).net) for templates in (None, CompactTemplates())]
    assert len({(graph.states, graph.edges) for graph in each}) == 1


def test_the_simulator_shows_what_nobody_knows(path: Path) -> None:
    net = compose(photo(path, "", 1))
    simulation = Simulation(net)
    for text in ("MISSION_EV_START", "camera_EV_OOS"):
        assert simulation.take(Event.parse(text)) is not None
    said = dict(resources(net, simulation.situation))
    assert said["camera"] == "out of service, unnoticed, used by look"
    possible = {str(event) for event in simulation.possible}
    assert possible == {"OBJ_search_try1_EV_FAIL", "sonar_EV_OOS"}  # no success, and no repair
    change = simulation.take(Event.parse("OBJ_search_try1_EV_FAIL"))
    assert change is not None
    assert change.after.mode == {"look": "by_ear"}
    assert dict(resources(net, simulation.situation))["camera"] == "out of service"
    assert "camera_EV_RD" in {str(event) for event in simulation.possible}


def test_it_is_written_as_it_was_read(path: Path, tmp_path: Path) -> None:
    of = photo(path, TEST)
    other = tmp_path / "other.xml"
    other.write_bytes(written(of))
    assert read_mission(other) == of
    assert 'detects="camera"' in other.read_text()


@pytest.mark.parametrize("form", FORMS)
def test_a_controller_by_hand(path: Path, form: Form) -> None:
    mission_net = compose(photo(path, "", 1))
    said = document(generate(mission_net, form), mission_net)
    assert said["late"] == {"camera": "camera known"}
    runtime = Runtime.from_document(said)
    runtime.handle("camera_EV_OOS")  # before the mission
    assert runtime.out_of_service == runtime.unnoticed == {"camera"}
    with pytest.raises(Refused):
        runtime.handle("camera_EV_RD")
    runtime.handle("MISSION_EV_START")
    assert runtime.mode == {"look": "by_eye"}
    assert "OBJ_search_try1_EV_OK" not in runtime.possible
    with pytest.raises(Refused):
        runtime.handle("camera_EV_DETECTED")  # nothing detects it now
    saved = runtime.snapshot()
    runtime.handle("OBJ_search_try1_EV_FAIL")
    assert runtime.mode == {"look": "by_ear"}
    assert runtime.unnoticed == frozenset()
    assert "camera_EV_RD" in runtime.possible
    runtime.handle("OBJ_search_try2_EV_OK")
    assert "camera_EV_RD" in runtime.possible
    runtime.handle("camera_EV_RD")
    runtime.handle("camera_EV_OOS")  # after the mission
    assert "camera_EV_RD" not in runtime.possible
    runtime.restore(saved)
    assert runtime.unnoticed == {"camera"}
    assert runtime.mode == {"look": "by_eye"}
    wrong = json.loads(saved) | {"out_of_service": []}
    with pytest.raises(SnapshotError):
        runtime.restore(snapshot_text(wrong))


@pytest.mark.parametrize("form", FORMS)
def test_one_event_tells_no_loss_and_its_detection(path: Path, form: Form) -> None:
    mission_net = compose(photo(path, TEST))
    runtime = Runtime.from_document(document(generate(mission_net, form), mission_net))
    runtime.handle("MISSION_EV_START")
    with pytest.raises(Refused):
        runtime.handle("camera_EV_DETECTED")
    assert runtime.handle("camera_EV_OOS") == ()
    assert runtime.handle("camera_EV_DETECTED") == ()
    assert runtime.unnoticed == frozenset()
    runtime.handle("OBJ_test_EV_OK")
    assert runtime.mode == {"look": "by_ear"}


@pytest.mark.parametrize("engine", KNOWING)
def test_numbers_by_hand(path: Path, engine: Engine) -> None:
    """The camera fails once per hour, and each objective takes one."""

    def found(of: Mission) -> Risk:
        return risk(Asked(compose(of), engine).prospects)

    once = found(photo(path))
    # It must outlive an exponential duration; else the objective takes its time all the same, and fails.
    assert once.success == pytest.approx(1 / 2)
    assert once.failure == pytest.approx(1 / 2)
    assert once.importance == pytest.approx({"camera": 1.0, "sonar": 0.0})
    assert once.degraded_modes == 0
    twice = found(photo(path, "", 1))
    assert twice.success == pytest.approx(1)
    assert twice.degraded_modes == pytest.approx(1 / 2)
    unrated = found(photo(path, TEST))
    # Lost in the test or in the search, whose time begins when that of the test is over.
    assert unrated.success == pytest.approx(1 / 4)
    assert unrated.unrated == ("camera_EV_DETECTED",)
    rated = found(photo(path, TEST, rate='detection_rate="3"'))
    known = 1 / 2 * 3 / (3 + 1)
    assert rated.success == pytest.approx(1 / 2 * 1 / 2 + known)
    assert rated.unrated == ()
    assert rated.degraded_modes == pytest.approx(known)


def with_equal_rates(of: Mission) -> Mission:
    """Hardware that is repaired as often as it fails: a difference of exponents that divides is 0."""

    def equal(h: Hardware) -> Hardware:
        return replace(h, repair_rate=h.failure_rate) if h.faulty and h.repairable else h

    return replace(of, robots=tuple(replace(r, hardware=tuple(map(equal, r.hardware))) for r in of.robots))


RATES = st.sampled_from([0.0, 0.2, 0.5, 3.0])


@given(
    RATES, RATES | st.none(), st.sampled_from([0.0, 1e-12, 1e-6, 1e-4]), st.floats(0.0, 4.0), st.booleans()
)
def test_what_is_beside_a_section(
    fails: float, back: float | None, apart: float, hours: float, late: bool
) -> None:
    """Its clock tells what the exponential of the generator says, also of rates that are (nearly) equal."""
    back = fails * (1 + apart) if back is None else back
    beside = Beside(fails, back, late)
    generator = np.array([[-fails, fails], [back, -back]])
    statuses = [0, 1]
    if late:
        generator = np.array([[-fails, fails, 0.0], [0.0, 0.0, 0.0], [back, 0.0, -back]])
        statuses = [0, 2, 3]  # of two bits: well, lost, known to be
    clock = np.zeros((len(beside.clock),) * 2)
    for phase, each in enumerate(beside.clock):
        for rate, later in each:
            clock[phase, [phase, later]] += -rate, rate
    ringing = expm(hours * clock)[0]
    after = sum(ringing @ term.phases * np.outer(term.column, term.row) for term in beside.terms)
    assert isinstance(after, np.ndarray)
    expected = expm(hours * generator)
    assert after[np.ix_(statuses, statuses)] == pytest.approx(expected, abs=1e-10)
    possible = beside.possible[np.ix_(statuses, statuses)]
    assert ((expm(generator) > 0) == (possible > 0)).all()


@fewer(0.5)
@given(
    st.one_of(
        fragile_missions(max_objectives=2, max_sections=4, max_hardware=2, late=True),
        missions(hardware=2, producers=1, events=1, sections=5, late=True, aborts=2),
        missions(hardware=2, producers=1, sections=5, late=True, lasting=True, faults=1),
        missions(hardware=1, producers=1, sections=5, late=True, crashes=True),
    ),
    st.sampled_from(KNOWING),
    st.booleans(),
    st.data(),
)
def test_numbers_are_those_of_a_dense_solve(
    of: Mission, engine: Engine, equal: bool, data: st.DataObject
) -> None:
    assume(of.late and small(of))
    rated = data.draw(with_numbers(of, demands=data.draw(st.booleans())))
    mission_net = compose(with_equal_rates(rated) if equal else rated)
    dense = Dense(mission_net, direct(mission_net.net))
    event(f"it may be misused: {bool(dense.misused)}, found: {any(dense.finding.values())}")
    assert_same(risk(Asked(mission_net, engine).prospects), dense.numbers())


def test_the_commands_know_it(path: Path, tmp_path: Path) -> None:
    photo(path, TEST)
    for form in FORMS:
        assert mcpn("controller", str(path), "--form", form, "-o", str(tmp_path / form)).returncode == 0
    for command in (["check"], ["causes"], ["report", "-o", str(tmp_path / "page.html")]):
        assert mcpn(command[0], str(path), *command[1:]).returncode == 0, command
