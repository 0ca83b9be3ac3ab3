"""Bounds of success where rates are known as intervals: every choice of rates lies between them."""

from __future__ import annotations

import pickle
from copy import deepcopy
from dataclasses import fields, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.interval_bounds import bounds
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.whole_chain import whole_chain
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.language.datatypes import RATE, Interval
from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, DeclaredEvent, Fault, Hardware, Robot
from mcpn.report.failures.drn import drn
from tests import small
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.test_whole_chain import (
    EXPERIMENTS,
    RATED,
    long_fractions,  # noqa: F401  (a fixture of all tests here)
    objective,
    whole,
)
from tests.commands import mcpn as command
from tests.commands import output
from tests.draws import composed, fewer
from tests.logic.automata import read
from tests.small import activity, robot

R = TypeVar("R", Hardware, Fault, DeclaredEvent, Activity)


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
