"""The bench beside the numbers of risk, which solve what it plays; sequences beside the tables."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.controller.chances import chances_of
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.mission.xml import read_mission
from mcpn.robot.bench.runs import bench, interval, one_run
from mcpn.robot.bench.world import World
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests import small
from tests.answers.dense import interrupted_missions, with_numbers
from tests.answers.test_demands import BY_HAND
from tests.conftest import ROOT
from tests.draws import fewer
from tests.shares import returns_early

GLIDER = ROOT / "experiments" / "glider" / "mission.xml"
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
    faults = [f"{h.name}_EV_{what}" for h in ulysse_net.core.hardware for what in ("OOS", "RD")]
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
