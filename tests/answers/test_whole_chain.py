"""The chain of the whole mission as an automaton: read again and solved exactly, and judged by Storm.

A campaign (``tests/draws.py``) holds drawn missions against both::

    MCPN_CAMPAIGN=500 python -m pytest -m slow -s tests/answers/test_whole_chain.py
"""

from __future__ import annotations

import math
import pickle
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import asdict, fields, replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import expm

from mcpn.answers.causes import ends_by_time
from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.ends_by_time import poisson, within
from mcpn.answers.causes.interval_bounds import bounds
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.causes.slopes import slopes, slopes_of
from mcpn.answers.causes.whole_chain import WholeChain, whole_chain
from mcpn.answers.spaces import spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.language.datatypes import RATE, Interval
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, DeclaredEvent, Fault, Hardware, Robot
from mcpn.report.failures.drn import drn, objective_labels
from mcpn.report.failures.risk_numbers import print_slopes
from mcpn.spaces.engine_names import Engine
from mcpn.study import open_study
from mcpn.testing import Shape, missions
from tests import small
from tests.answers.dense import any_missions, interrupted_missions, with_numbers
from tests.answers.exact import scaled
from tests.commands import mcpn as command
from tests.commands import output
from tests.draws import campaign, composed, fewer
from tests.logic.automata import Automaton, judged, read
from tests.small import activity, robot

try:
    import stormpy
except ImportError:
    stormpy = None
needs_storm = pytest.mark.skipif(stormpy is None, reason="the extra storm is not installed")

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
T = TypeVar("T", Hardware, Fault)
R = TypeVar("R", Hardware, Fault, DeclaredEvent, Activity)
ENDS = ("success", "failure", "abort")
RATED = [
    "rover/mission.xml",
    "glider/mission.xml",
    *(f"roscon/problem{name}.xml" for name in ("1", "2", "2_published", "3", "4")),
]


@pytest.fixture(autouse=True)
def long_fractions() -> Iterator[None]:
    before = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(0)
    yield
    sys.set_int_max_str_digits(before)


def whole(mission_net: MissionNet) -> Prospects[Any]:
    return Prospects(mission_net, spaces_of(mission_net).space("explicit", "alternatives"))


def chain_of(mission: Mission) -> WholeChain:
    return whole_chain(whole(compose(mission)), number=decimal)


def one_sensor(**more: Any) -> Mission:
    h = Hardware(name="H", failure_rate=0.1, repair_rate=0.3)
    of = robot((h,), activity("a", ("H",)))
    return small.mission(of, objective(**more))


def objective(**more: Any) -> Objective:
    return replace(Objective(name="x", activities=("a",), duration=1.5), **more)


def test_one_objective_and_one_sensor() -> None:
    chain = chain_of(one_sensor(failure_probability=0.2))
    text = drn(chain).decode()
    # The sensor outlives a mean of 1.5 hours; 0.2 of the ends are failures. All is as the file says it.
    assert read(text).reaching("success") == Fraction(4, 5) / (1 + Fraction(1, 10) * Fraction(3, 2))
    assert read(text).reaching("failure") == 1 - read(text).reaching("success")
    assert "state 0 !23/30 init objective_x\n// objective(x) alternative(a)=a\n" in text


def test_labels_are_identifiers_that_differ() -> None:
    chain = chain_of(one_sensor())
    running = dict.fromkeys(("a.b", "a_b", "a b"), chain.running["x"])
    found = objective_labels(replace(chain, running=running))
    assert found == {"a.b": "objective_a_b", "a_b": "objective_a_b_2", "a b": "objective_a_b_3"}


@st.composite
def changing_facts(draw: st.DrawFn) -> Mission:
    """Small missions with a fact of the world, which events may change also before the start."""
    shape = Shape(hardware=1, producers=0, alternatives=2, events=2, sections=3, facts=1)
    return draw(with_numbers(draw(missions(shape))))


def agree(mission_net: MissionNet, engine: Engine, ends: Mapping[str, Fraction]) -> None:
    """Asserts that an engine has the exact numbers, failure as itself as well as success."""
    found = risk(Prospects(mission_net, spaces_of(mission_net).space(engine, "alternatives")))
    for end, exact in ends.items():
        assert (getattr(found, end) or 0.0) == pytest.approx(float(exact), rel=1e-9, abs=0), end


RATED_DRAWS = st.tuples(
    any_missions() | interrupted_missions() | changing_facts(), st.sampled_from([1.0, 1e-6])
)
"""Missions, and how many times as often as drawn their hardware fails."""


def has_the_numbers_of_its_automaton(drawn: tuple[Mission, float]) -> str:
    """Compares the engines with the automaton and, where it is installed, that with Storm; says the kind."""
    mission_net = composed(scaled(*drawn))
    try:
        text = drn(whole_chain(whole(mission_net).within(2000), decimal))
    except (SemanticsError, LimitError) as error:
        return type(error).__name__
    automaton = read(text.decode())
    ends = {end: automaton.reaching(end) for end in ENDS}
    agree(mission_net, "explicit", ends)
    with suppress(LimitError):  # a fact of more than two values, which events change
        agree(mission_net, "local", ends)
    if stormpy is None:
        return "solved"
    assert {end: judged(text, end) for end in ENDS} == ends
    return "by Storm"


@fewer(1)
@given(RATED_DRAWS)
def test_drawn_missions_have_the_numbers_of_their_automaton(drawn: tuple[Mission, float]) -> None:
    has_the_numbers_of_its_automaton(drawn)


@pytest.mark.slow
def test_campaign() -> None:
    found = campaign(RATED_DRAWS, has_the_numbers_of_its_automaton, 500)
    assert found["by Storm"] + found["solved"] > found["drawn"] / 3


@cache
def worked(name: str) -> tuple[Prospects[Any], bytes]:
    """A worked mission, as ``auto`` takes it, and its automaton."""
    study = open_study(EXPERIMENTS / name)
    prospects = Prospects(study.mission_net, study.alternatives())
    return prospects, drn(whole_chain(prospects, number=decimal))


@needs_storm
@pytest.mark.parametrize("factor", [1.0, 1e-6])
@pytest.mark.parametrize(
    "name", [*(pytest.param(name, marks=pytest.mark.slow) for name in RATED[:2]), *RATED[2:]]
)
def test_storm_agrees_on_the_worked_missions(name: str, factor: float) -> None:
    mission_net = compose(scaled(worked(name)[0].mission_net.mission, factor))
    text = drn(whole_chain(whole(mission_net), number=decimal))
    for engine in ("local", "explicit"):
        agree(mission_net, engine, {end: judged(text, end) for end in ENDS})


def test_the_command_writes_the_automaton(tmp_path: Path) -> None:
    target = tmp_path / "out.drn"
    found = output("convert", EXPERIMENTS / RATED[2], target, "--rates")
    assert target.read_bytes() == worked(RATED[2])[1]
    automaton = read(target.read_text())
    assert found["states"] == len(automaton.rates)
    assert found["warnings"] == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("ulysse/mission.xml", "out.drn", "--rates"), "has no duration"),
        (("rover/mission.xml", "out.drn", "--rates", "--max-states", "100"), "states, the limit is 100"),
        (("rover/mission.xml", "out.drn"), "found the suffix '.drn' without --rates"),
        (("rover/mission.xml", "out.net", "--rates"), "found --rates, expected a file .drn"),
    ],
)
def test_what_cannot_be_written_is_said(arguments: tuple[str, ...], said: str, tmp_path: Path) -> None:
    source, target, *more = arguments
    found = command("convert", EXPERIMENTS / source, tmp_path / target, *more)
    assert found.returncode == 2
    assert said in found.stderr
    assert not list(tmp_path.iterdir())


# --- by a time ---


def floats_of(mission: Mission) -> WholeChain:
    found = compose(mission)
    return whole_chain(Prospects(found, spaces_of(found).space("explicit", "alternatives")))


def by_exponential(automaton: Automaton, hours: float) -> dict[str, float]:
    """The ends by a time, by the dense exponential of the generator; the automaton is what was written."""
    size = len(automaton.rates)
    jumps = np.zeros((size, size))
    for state, ways in enumerate(automaton.ways):
        jumps[state, list(ways)] = [float(chance) for chance in ways.values()]
    leaving = np.array([float(rate) for rate in automaton.rates])
    slow = np.flatnonzero(leaving)
    # What never leaves the vanishing states again ends nowhere; of the others the system is regular.
    onto = {*slow.tolist()}
    while more := {s for s, ways in enumerate(automaton.ways) if s not in onto and not onto.isdisjoint(ways)}:
        onto |= more
    quick = np.array([state for state in sorted(onto) if not leaving[state]], dtype=int)
    at_once = np.zeros((size, len(slow)))
    at_once[slow] = np.eye(len(slow))
    within = np.eye(len(quick)) - jumps[np.ix_(quick, quick)]
    at_once[quick] = np.linalg.solve(within, jumps[np.ix_(quick, slow)])
    now = at_once[0] @ expm(hours * leaving[slow, None] * (jumps[slow] @ at_once - np.eye(len(slow))))
    said = {
        end: [end in automaton.labels[state] for state in slow] for end in ("success", "failure", "abort")
    }
    return {end: float(now[np.array(states, dtype=bool)].sum()) for end, states in said.items()}


def test_by_a_time_one_objective_and_one_sensor() -> None:
    chain = floats_of(one_sensor(failure_probability=0.2))
    for hours in (1e-9, 0.1, 8.0, 1e5):
        found, leaving = within(chain, hours), 1 / 1.5 + 0.1
        ended = -math.expm1(-hours * leaving)
        assert found.success == pytest.approx(0.8 / 1.5 / leaving * ended, rel=1e-11)
        assert found.failure == pytest.approx((0.2 / 1.5 + 0.1) / leaving * ended, rel=1e-11)
        assert found.abort is None
        assert found.error < 1e-11


@fewer(1)
@given(any_missions() | interrupted_missions(), st.sampled_from([0.01, 1.0, 20.0]))
def test_by_a_time_drawn_missions_are_as_the_exponential_says(mission: Mission, hours: float) -> None:
    mission_net = composed(mission)
    try:
        prospects = whole(mission_net)
        chain = whole_chain(prospects.within(2000))
    except (SemanticsError, LimitError):
        return
    assume(chain.states <= 100)
    found = within(chain, hours)
    dense = by_exponential(read(drn(whole_chain(prospects.within(2000), decimal)).decode()), hours)
    for end, value in dense.items():
        assert (getattr(found, end) or 0.0) == pytest.approx(value, rel=0, abs=found.error + 1e-11)


HOURS = [
    pytest.param(RATED[0], 8, marks=pytest.mark.slow),
    pytest.param(RATED[1], 24, marks=pytest.mark.slow),
    *((name, 2) for name in RATED[2:]),
]


def by_storm_in_time(target: Path, hours: float, end: str) -> float:
    """The probability that a mission whose automaton stands in a file has ended so by a time."""
    model = stormpy.build_model_from_drn[float](str(target))
    if not model.labeling.contains_label(end):
        return 0.0
    if model.convertible_to_ctmc:  # Storm asks of an automaton that it has vanishing states
        model = model.convert_to_ctmc()
    kind = "Pmax" if model.is_nondeterministic_model else "P"
    (asked,) = stormpy.parse_properties(f'{kind}=? [F<={hours} "{end}"]')
    return float(stormpy.model_checking(model, asked).get_value(model.initial_states[0]))


@needs_storm
@pytest.mark.parametrize(("name", "hours"), HOURS)
def test_by_a_time_storm_agrees(name: str, hours: int, tmp_path: Path) -> None:
    prospects, text = worked(name)
    target = tmp_path / "out.drn"
    target.write_bytes(text)
    found = within(whole_chain(prospects), hours)
    for end in ENDS:
        judged = by_storm_in_time(target, hours, end)
        assert (getattr(found, end) or 0.0) == pytest.approx(judged, rel=1e-9, abs=1e-13)


def test_the_command_tells_the_ends_by_a_time() -> None:
    arguments = ("causes", EXPERIMENTS / RATED[2], "--rates", "--within", "PT1M30S")
    found = output(*arguments)["within"]
    expected = within(whole_chain(worked(RATED[2])[0]), 0.025)
    assert found == {name: value for name, value in asdict(expected).items() if value is not None}
    assert f"success within PT1M30S  {expected.success:.6g}" in command(*arguments).stdout


def test_a_mission_that_has_ended_needs_no_more_steps() -> None:
    chain = floats_of(one_sensor())
    assert within(chain, 1e6).steps < 200


def test_a_stiff_mission_has_too_many_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ends_by_time, "MOST_STEPS", 500)
    there, back = objective(success="y", duration=1e-3), objective(name="y", success="x", duration=1e-3)
    again = floats_of(replace(one_sensor(), blocks=(there, back)))
    with pytest.raises(LimitError, match=r"^5 hours are \d+ steps .* the limit is 500 steps"):
        within(again, 5)


@pytest.mark.parametrize("mean", [1e-12, 0.5, 30.0, 1e4, 1e7])
def test_weights_are_poissons(mean: float) -> None:
    found = poisson(mean)
    assert math.fsum(found.weights) == pytest.approx(1, abs=1e-15)
    numbers = found.first + np.arange(len(found.weights))
    assert float(numbers @ found.weights) == pytest.approx(mean, rel=1e-9)  # its mean, and its variance
    assert float((numbers - mean) ** 2 @ found.weights) == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("text", ["8", "PT0S", "8h", "PT", "P" + "9" * 400 + "D", "-PT1H"])
def test_a_time_that_is_none_is_said(text: str) -> None:
    found = command("causes", EXPERIMENTS / RATED[2], "--rates", "--within", text)
    assert found.returncode == 2
    assert "--within" in found.stderr
    assert "duration" in found.stderr


def test_a_time_is_asked_of_rates() -> None:
    found = command("causes", EXPERIMENTS / RATED[2], "--within", "PT1H")
    assert found.returncode == 2
    assert "expected --rates" in found.stderr


# --- by small changes ---


def changed(mission: Mission, name: str, by: float) -> Mission:
    """The mission with another failure rate of some hardware, or of a fault or an activity that crashes."""

    def at(element: T) -> T:
        known = getattr(element, "failure_rate", None)
        return replace(element, failure_rate=known + by) if known and element.name == name else element

    robots = tuple(
        replace(of, hardware=tuple(map(at, of.hardware)), faults=tuple(map(at, of.faults)))
        for of in mission.robots
    )
    return replace(mission, robots=robots)


STEP = 2.0**-20


@fewer(1)
@given(any_missions() | interrupted_missions())
def test_derivatives_are_those_of_exact_differences(mission: Mission) -> None:
    mission_net = composed(mission)
    try:
        chain = whole_chain(whole(mission_net).within(2000))
    except (SemanticsError, LimitError):
        return
    assume(chain.states <= 150)
    found = slopes(chain)
    crashes = {crash.name for crash in mission_net.mission.crashes}
    assert {*found} == {h.name for h in mission_net.mission.hardware if h.failure_rate and h.faulty}
    for name in sorted({*found} - crashes)[:2]:
        # (f(x+h) - f(x-h)) / 2h is off by terms of h²: Richardson takes out the first of them.
        wide, narrow = (
            (success(changed(mission, name, h)) - success(changed(mission, name, -h))) / (2 * decimal(h))
            for h in (2 * STEP, STEP)
        )
        assert found[name] == pytest.approx(float((4 * narrow - wide) / 3), rel=1e-9, abs=1e-12)


def success(mission: Mission) -> Fraction:
    return read(drn(chain_of(mission)).decode()).reaching("success")


def test_the_derivative_of_one_sensor() -> None:
    # Success is 0.8 / (1 + rate * 1.5); a repair comes too late.
    found = slopes(floats_of(one_sensor(failure_probability=0.2)))
    assert found == pytest.approx({"H": -0.8 * 1.5 / (1 + 0.15) ** 2}, rel=1e-12)


def test_the_command_tells_an_order_that_is_another(capsys: pytest.CaptureFixture[str]) -> None:
    """In the glider the radio is as important as the pump, but it is needed for a moment only."""
    found = output("causes", EXPERIMENTS / RATED[1], "--rates")
    assert found["slopes"] == pytest.approx(slopes(whole_chain(worked(RATED[1])[0])), rel=1e-9)
    importance = found["risk"]["importance"]
    assert importance["satellite_radio"] > importance["compass"]
    assert found["slopes"]["satellite_radio"] > found["slopes"]["compass"]

    numbers = risk(worked(RATED[1])[0])
    print_slopes(numbers, found["slopes"])
    shown = capsys.readouterr().out
    assert "they rank otherwise" in shown
    assert shown.index("derivative by compass") < shown.index("derivative by satellite radio")
    print_slopes(numbers, {"compass": -2.0, "satellite_radio": -3.0})
    assert capsys.readouterr().out == ""


def test_derivatives_of_too_many_states_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    prospects, _ = worked(RATED[0])
    assert slopes_of(prospects.within(100)) is None
    assert set(slopes_of(prospects) or {}) == set(prospects.hardware)


# --- rates in intervals ---


def with_intervals(mission: Mission, share: float) -> Mission:
    """The mission with an interval around each failure rate, and of each event and repair."""

    def around(element: R, *names: str) -> R:
        known = {name: getattr(element, name) for name in names}
        wide: dict[str, Any] = {n: Interval(r / share, r * share) for n, r in known.items() if r}
        return replace(element, **wide)

    def of(one: Robot) -> Robot:
        return replace(
            one,
            hardware=tuple(around(h, "failure_rate", "repair_rate") for h in one.hardware),
            faults=tuple(around(f, "failure_rate", "repair_rate") for f in one.faults),
            events=tuple(around(e, "rate") for e in one.events),
            activities=tuple(
                around(a, "failure_rate", "repair_rate", "detection_rate") for a in one.activities
            ),
        )

    return replace(mission, robots=tuple(map(of, mission.robots)))


def chosen(mission: Mission, draw: Any) -> Mission:
    """The mission with a number, drawn, of each interval, its ends more often than others."""

    def at(element: R) -> R:
        intervals = {
            f.name: rate for f in fields(element) if isinstance(rate := getattr(element, f.name), Interval)
        }
        shares = {name: draw(st.sampled_from([0.0, 0.0, 0.3, 1.0, 1.0])) for name in intervals}
        rates: dict[str, Any] = {
            n: (1 - s) * intervals[n].low + s * intervals[n].high for n, s in shares.items()
        }
        return replace(element, **rates)

    def of(one: Robot) -> Robot:
        parts: dict[str, Any] = {
            name: tuple(map(at, getattr(one, name)))
            for name in ("hardware", "faults", "events", "activities")
        }
        return replace(one, **parts)

    return replace(mission, robots=tuple(map(of, mission.robots)))


@fewer(1)
@given(any_missions() | interrupted_missions(), st.sampled_from([1.0, 1.5, 10.0]), st.data())
def test_bounds_hold_for_every_choice_of_rates(mission: Mission, share: float, data: st.DataObject) -> None:
    loose = with_intervals(mission, share)
    composed(mission)
    try:
        prospects = explicit(loose)
        found = bounds(prospects.within(2000))
    except (SemanticsError, LimitError):
        return
    assume(prospects.space.everything.count() <= 400)
    for _ in range(3):
        automaton = read(drn(whole_chain(explicit(chosen(loose, data.draw)), number=decimal)).decode())
        for end, (low, high) in found.items():
            exact = automaton.reaching(end)
            assert low <= exact <= high
            if share == 1.0:
                assert high - low <= 1e-9 * high


def explicit(mission: Mission) -> Prospects[Any]:
    return whole(compose(mission))


def test_bounds_of_one_sensor_are_the_least() -> None:
    h = Hardware(name="H", failure_rate=Interval(0.05, 0.2), repair_rate=0.3)
    found = bounds(explicit(small.mission(robot((h,), activity("a", ("H",))), objective())))
    assert found["success"] == pytest.approx((1 / (1 + 0.2 * 1.5), 1 / (1 + 0.05 * 1.5)), rel=1e-11)
    assert found["failure"] == pytest.approx((0.075 / 1.075, 0.3 / 1.3), rel=1e-11)


def test_an_interval_is_a_number_with_bounds() -> None:
    rate = Interval(1e-5, 1e-3)
    assert float(rate) == pytest.approx(1e-4)
    assert rate != float(rate)
    assert rate == Interval(1e-5, 1e-3)
    assert pickle.loads(pickle.dumps(rate)).high == 1e-3
    assert deepcopy(rate) == rate
    assert RATE.read(RATE.write(rate)) == rate


LEG = """<mission xmlns="urn:mcpn:mission:1" name="leg">
  <robot name="boat">
    <hardware name="gps" failure_rate="{}"/>
    <activity name="driving" consumes="gps"/>
  </robot>
  <objective name="survey" activities="driving" duration="6"/>
</mission>"""


def test_the_command_tells_bounds_that_are_bounds_as_printed(tmp_path: Path) -> None:
    path = tmp_path / "leg.xml"
    path.write_text(LEG.format("1e-5..1e-4"))
    found = output("causes", path, "--rates")
    least, most = 1 / (1 + Fraction(6, 10**4)), 1 / (1 + Fraction(6, 10**5))
    low, high = found["bounds"]["success"]
    assert low <= least < most <= high
    assert high - low == pytest.approx(float(most - least), rel=1e-6)
    shown = command("causes", path, "--rates").stdout
    (line,) = (line for line in shown.splitlines() if line.startswith("success for all rates"))
    _, low, _, high = line.rsplit(maxsplit=3)
    assert Fraction(low) <= least < most <= Fraction(high)
    assert "geometric means of intervals: failure_rate of gps 3.16228e-05" in shown
    assert "bounds" not in output("causes", EXPERIMENTS / RATED[2], "--rates")
    bench = command("bench", path, "--runs", "10").stdout
    assert "geometric means of intervals: failure_rate of gps" in bench


@pytest.mark.parametrize("text", ["0 .. 1", "2 .. 1", "1 ..", ".. 1", "1 .. 1e999", "1 ... 2", "1 .. 2 .. 3"])
def test_what_is_no_interval_is_said(text: str, tmp_path: Path) -> None:
    path = tmp_path / "leg.xml"
    path.write_text(LEG.format(text))
    found = command("check", path)
    assert found.returncode == 2
    assert "leg.xml:3" in found.stderr
    assert "interval" in found.stderr
    if text == "2 .. 1":
        assert "failure_rate of gps is 2.0 .. 1.0, expected" in found.stderr
