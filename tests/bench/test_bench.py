"""The bench beside the numbers of risk, which solve what it plays; sequences beside the tables."""

from __future__ import annotations

import json
import random
import runpy
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.controller.chances import chances_of
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.robot.bench.controller_places import ControllerPlace, Places
from mcpn.robot.bench.generated_code import Program, compare
from mcpn.robot.bench.runs import bench, interval, one_run
from mcpn.robot.bench.scxml_replay import Statechart
from mcpn.robot.bench.sequences import sequences
from mcpn.robot.bench.world import World
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.machines import TypeTables
from mcpn.robot.runtime.tables import Tables
from mcpn.robot.targets import files
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests import small
from tests.answers.dense import interrupted_missions, with_numbers
from tests.answers.test_demands import BY_HAND
from tests.commands import mcpn
from tests.conftest import ROOT, ULYSSE
from tests.controller.test_c import build, run_lines
from tests.draws import fewer
from tests.shares import returns_early

GLIDER = ROOT / "experiments" / "glider" / "mission.xml"
WATCH = ROOT / "tests" / "controller" / "watch.xml"
UNTIMED = missions(disjoint_branches=True, protocols=False, timeouts=0, hardware=3, objectives=3, sections=5)
"""Numbers of risk know no timeouts."""
LATE = missions(hardware=2, objectives=2, sections=4, producers=1, timeouts=0, late=True)
NAMED = missions(hardware=1, objectives=3, sections=4, producers=1, timeouts=0, reasons=7, recovers=2)
NEVER = 1 - 1e-7
"""Confidence of intervals that tests ask for: a false alarm in ten million comparisons."""


def world(mission_net: MissionNet, duration: float | None = None) -> World:
    tables = Tables(document(generate(mission_net), mission_net))
    return World(tables, chances_of(mission_net), duration)


@fewer(0.2)
@given(
    st.one_of(
        UNTIMED.flatmap(with_numbers),
        UNTIMED.flatmap(lambda of: with_numbers(of, demands=True)),
        interrupted_missions(),
        LATE.flatmap(lambda of: with_numbers(of, demands=True)),
        NAMED.flatmap(with_numbers),
    )
)
def test_frequencies_are_those_of_risk(mission: Mission) -> None:
    mission_net = compose(mission)
    try:
        space = ArraySpace(direct(mission_net.net, max_states=2000))
        numbers = risk(Prospects(mission_net, space))
        played = world(mission_net)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    runs = 300
    found = bench(played, runs, 5, most_events=1000)
    cut = found.outcomes[None] / runs  # a mission may go on for ever, or for very long
    expected = {"success": numbers.success, "failure": numbers.failure, "abort": numbers.abort or 0.0}
    for outcome, probability in expected.items():
        low, high = interval(found.outcomes[outcome], runs, NEVER)
        assert low - 1e-9 <= probability <= high + cut + 1e-9, outcome
    if not found.outcomes[None]:
        mean, deviation = found.degraded
        assert abs(mean - numbers.degraded_modes) <= 6 * max(deviation, 6 / runs)


def one_sensor() -> Mission:
    """An objective of two hours that a sensor, which fails every four hours, must outlive."""
    of = small.robot((Hardware(name="H", failure_rate=0.25),), small.activity("a", ("H",)))
    return small.mission(of, Objective(name="x", activities=("a",), duration=2.0, failure_probability=0.2))


def test_one_objective_and_one_sensor() -> None:
    """By hand: the sensor outlives an exponential duration with 1 / (1 + rate * mean)."""
    found = bench(world(compose(one_sensor())), 4000, 1)
    low, high = interval(found.outcomes["success"], 4000, NEVER)
    assert low <= 0.8 / (1 + 0.25 * 2.0) <= high
    assert found.outcomes["success"] + found.outcomes["failure"] == 4000


@BY_HAND
def test_what_fails_on_demand(of: Mission, success: float, degraded: float) -> None:
    found = bench(world(compose(of)), 4000, 1)
    low, high = interval(found.outcomes["success"], 4000, NEVER)
    assert low <= success <= high
    assert found.outcomes["success"] + found.outcomes["failure"] == 4000
    mean, deviation = found.degraded
    assert abs(mean - degraded) <= 6 * deviation


def test_what_always_fails_on_demand_gives_no_hope() -> None:
    """``a`` prefers h, which fails as soon as it is asked: it runs in g, or fails if g has gone."""
    lost = Hardware(name="h", demand_probability=1.0)
    of = small.robot((lost, Hardware(name="g", failure_rate=1.0)), small.activity("a", ("h",), ("g",)))
    only = Objective(name="x", activities=("a",), duration=1.0, failure_probability=0.0)
    played = world(compose(small.mission(of, only)))
    runs = [one_run(played, random.Random(seed)) for seed in range(2000)]
    low, high = interval(sum(run.outcome == "success" for run in runs), 2000, NEVER)
    assert low <= 0.5 <= high
    for run in runs:
        assert [event.event for event in run.events[:2]] == ["MISSION_EV_START", "h_EV_OOS"]
        assert run.events[1].hours == 0.0
        assert len(run.events) == (3 if run.outcome == "success" else 4)


def test_the_same_seed_gives_the_same_runs() -> None:
    played = world(compose(read_mission(GLIDER)))
    one, other = bench(played, 50, 3, most_traces=50), bench(played, 20, 3, most_traces=50)
    assert one.traces[: len(other.traces)] == other.traces
    assert bench(played, 50, 4).hours != one.hours


def test_wilson_s_interval() -> None:
    """Wilson (1927); the figures by hand: z = 1.959964, 8 of 10."""
    low, high = interval(8, 10, 0.95)
    assert (low, high) == pytest.approx((0.490162, 0.943318), abs=1e-6)
    assert interval(0, 10, 0.95)[0] == 0.0
    assert interval(10, 10, 0.95)[1] == 1.0


def test_a_run_is_one_of_the_controller(ulysse_net: MissionNet) -> None:
    """What is looked up is what the runtime says when it handles the whole run."""
    played = world(ulysse_net, 1.0)
    rng = random.Random(2)
    faults = [f"{h.name}_EV_{what}" for h in ulysse_net.mission.hardware for what in ("OOS", "RD")]
    script = sorted((rng.uniform(0, 6), fault) for fault in faults)
    run = one_run(played, rng, script)
    controller = Controller(played.tables, on_refused=lambda refused: None)
    for event in run.events:
        controller.handle(event.event)
    assert [not step.taken for step in controller.log] == [event.refused for event in run.events]
    assert controller.outcome == run.outcome
    assert [event.hours for event in run.events] == sorted(event.hours for event in run.events)


def test_timers_run_out_in_virtual_time() -> None:
    """Of a duration of one hour and a timeout of one: exp(-1) of the runs outlast it."""
    of = small.robot((), small.activity("a", ()))
    only = Objective(name="x", activities=("a",), duration=1.0, timeout=3600)
    found = bench(world(compose(small.mission(of, only))), 4000, 1)
    low, high = interval(found.outcomes["failure"], 4000, NEVER)
    assert low <= 0.36787944 <= high
    assert max(run.hours for run in found.traces) <= 1.0 + 1e-12


# --- generated code ---


@pytest.mark.parametrize("target", ["python", "c"])
def test_generated_code_on_the_same_runs(target: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    if target == "c" and not shutil.which("gcc"):
        pytest.skip("needs gcc")
    controller = generate(ulysse_net)
    places = Places(Tables(document(controller, ulysse_net)))
    every = sorted(places.tables.known)
    runs = [["MISSION_EV_START", *random.Random(n).choices(every, k=30), "no_such_EV"] for n in range(20)]
    assert compare(Program(document(controller, ulysse_net), target, tmp_path), places, runs) is None
    wrong = Program(document(generate(ulysse_net, "flat"), ulysse_net), target, tmp_path)
    answers = wrong.answers(runs)

    class Damaged(Program):
        def __init__(self) -> None:
            pass

        def answers(self, runs: list[list[str]]) -> list[str]:
            return [
                *answers[:40],
                answers[40].replace("_EV_", "_"),
                *answers[41:],
            ]

    difference = compare(Damaged(), places, runs)
    assert difference is not None
    assert list(difference.events) == runs[1][: 41 - len(runs[0])]


BRANCHED = missions(events=1, facts=2, timeouts=1, objectives=3, sections=4, awkward_names=True)


@pytest.mark.long
@fewer(0.2)
@given(BRANCHED, st.integers(0, 2**32), st.booleans())
def test_scxml_in_lockstep(mission: Mission, seed: int, flat: bool) -> None:
    """On any mission, as python-statemachine runs it; a tenth of the events are impossible or unknown."""
    pytest.importorskip("statemachine.io.scxml.processor", reason="needs mcpn[scxml]")
    mission_net = compose(mission)
    try:
        controller = generate(mission_net, "flat" if flat else "hierarchical", max_states=200)
        statechart = Statechart(document(controller, mission_net))
    except (SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return
    places = Places(Tables(document(controller, mission_net)))
    rng = random.Random(seed)
    runs = [drawn(places, rng) for _ in range(3)]
    assert compare(statechart, places, runs) is None

    class Deaf(Statechart):
        """It misses the last event."""

        def answers(self, runs: list[list[str]]) -> list[str]:
            *told, _ = super().answers(runs)
            return [*told, told[-1] if told else "before"]

    run = next((run for run in runs if places.after(reached(places, run[:-1]), run[-1]) is not None), None)
    if run is not None and len(run) > 1:
        deaf = Deaf(document(controller, mission_net))
        difference = compare(deaf, places, [run])
        if deaf.answers([run]) == statechart.answers([run]):  # the last event did what the one before did
            assert difference is None
        else:
            assert difference is not None
            assert list(difference.events) == run


def drawn(places: Places, rng: random.Random) -> list[str]:
    """Up to thirty events at random."""
    place, events = places.start, list[str]()
    while len(events) < 30 and place.possible:
        noise = rng.random() < 0.1
        some = {*places.tables.known, "no_such_EV"} if noise else {*place.possible}
        events.append(rng.choice(sorted(some)))
        place = reached(places, events[-1:], place)
    return events


def reached(places: Places, events: list[str], place: ControllerPlace | None = None) -> ControllerPlace:
    place = place or places.start
    for event in events:
        step = places.after(place, event)
        place = place if step is None else step[0]
    return place


def test_the_command_runs_scxml(written: str) -> None:
    pytest.importorskip("statemachine.io.scxml.processor", reason="needs mcpn[scxml]")
    found = mcpn("bench", written, "--runs", "50", "--against", "scxml", "--json")
    assert found.returncode == 0, found.stderr
    told = {"target": "scxml", "agrees": True, "events": [], "expected": None, "found": None}
    assert json.loads(found.stdout)["against"] == told


def test_without_the_interpreter_of_scxml(ulysse_net: MissionNet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "statemachine.io.scxml.processor", None)
    with pytest.raises(LimitError, match="needs python-statemachine: pip install 'mcpn"):
        Statechart(document(generate(ulysse_net), ulysse_net))


# --- sequences ---


def test_sequences_take_every_edge_and_the_c_program_follows(ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net)
    tables = Tables(document(controller, ulysse_net))
    machines = [section.machine for section in tables.sections.values()]
    edges = sum(len(moves) for m in machines if isinstance(m, TypeTables) for moves in m.moves)
    assert sequences(tables).edges == edges
    assert mcpn("tests", str(ULYSSE), "-o", str(tmp_path / "out")).returncode == 0
    replayed, taken = Controller(tables), set[tuple[str | None, int, str]]()
    for event in (tmp_path / "out" / "events.txt").read_text().splitlines():
        if event:
            section = replayed.section
            if section is not None and event in tables.sections[section].number:
                taken.add((section, replayed.where.state, event))
            replayed.handle(event)
        else:
            replayed = Controller(tables)
    assert len(taken) == edges
    program = build(files(document(controller, ulysse_net), "c"), tmp_path / "c")
    events = (tmp_path / "out" / "events.txt").read_text().splitlines()
    expected = (tmp_path / "out" / "expected.txt").read_text().splitlines()
    assert [line.split(" |")[0] for line in run_lines(program, events)] == expected


def test_the_written_tests_pass_and_find_a_wrong_robot(tmp_path: Path) -> None:
    assert mcpn("tests", str(WATCH), "-o", str(tmp_path)).returncode == 0
    written = runpy.run_path(str(tmp_path / "test_controller.py"))
    controller = Controller.load(tmp_path / "controller.json")
    before = controller.snapshot()
    check, make, each = written["test_sequence"], written["Runtime"], written["SEQUENCES"]
    for sequence in each:
        controller.restore(before)
        check(make(controller), sequence)

    class Wrong(make):  # type: ignore[misc, valid-type]
        def handle(self, event: str) -> list[str]:
            found: list[str] = super().handle(event)
            return found[::-1]

    controller.restore(before)
    with pytest.raises(AssertionError, match="step 1: MISSION_EV_START"):
        check(Wrong(controller), each[0])


# --- the command ---


@pytest.fixture
def written(tmp_path: Path) -> str:
    path = tmp_path / "mission.xml"
    path.write_bytes(write_mission(one_sensor()))
    return str(path)


def test_the_command_s_traces_are_replayed(written: str, tmp_path: Path) -> None:
    said: dict[str, Any] = json.loads(
        mcpn("bench", written, "--runs", "200", "--traces", str(tmp_path / "t"), "--json").stdout
    )
    assert sum(of["count"] for of in said["outcomes"].values()) == 200
    assert all(of["agrees"] for of in said["outcomes"].values())
    assert len(said["traces"]) == 10
    replayed = mcpn("simulate", written, "--events", said["traces"][0], "--json")
    assert json.loads(replayed.stdout)["outcome"] == "failure"


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("1 OBJ_x_EV_OK\n", "which is no event of the mission"),
        ("0.5 GPS_EV_OOS x", "found '0.5 GPS_EV_OOS x', expected hours and an event"),
        ("# nothing\n-1 GPS_EV_OOS", ":2: found '-1 GPS_EV_OOS'"),
        ("soon GPS_EV_OOS", "found 'soon GPS_EV_OOS'"),
        ("1 dance", ":1: found 'dance', which is no event of the mission"),
    ],
)
def test_scripts_that_are_none(script: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "faults.txt"
    path.write_text(script)
    found = mcpn("bench", str(GLIDER), "--faults", str(path))
    assert found.returncode == 2
    assert message in found.stderr


def test_a_script_of_faults_is_played(written: str, tmp_path: Path) -> None:
    path = tmp_path / "faults.txt"
    path.write_text("0 MISSION_EV_START\n0 H_EV_OOS  # at once\n")
    said = json.loads(mcpn("bench", written, "--runs", "50", "--faults", str(path), "--json").stdout)
    assert said["no_risk"] == "a script of faults is played"
    assert said["outcomes"]["failure"]["count"] == 50


def test_a_mission_without_durations_runs_untimed() -> None:
    """Nothing fails in Ulysse but by chance of its objectives, of which it gives none: all succeed."""
    said = json.loads(mcpn("bench", str(ULYSSE), "--runs", "50", "--json").stdout)
    assert said["outcomes"]["success"]["count"] == 50
    assert (said["hours"], said["no_risk"][:27]) == (None, "objectives have no duration")
    assert said["outcomes"]["success"]["risk"] is None
    assert "mean hours" not in mcpn("bench", str(ULYSSE), "--runs", "5").stdout
