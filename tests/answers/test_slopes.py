"""Derivatives of success by failure rates, beside differences in exact fractions."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

import pytest
from hypothesis import assume, given

from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.risk import risk
from mcpn.answers.causes.slopes import slopes, slopes_of
from mcpn.answers.causes.whole_chain import whole_chain
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.robot import Fault, Hardware
from mcpn.report.failures.drn import drn
from mcpn.report.failures.risk_numbers import print_slopes
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.test_ends_by_time import floats_of
from tests.answers.test_whole_chain import (
    EXPERIMENTS,
    RATED,
    chain_of,
    long_fractions,  # noqa: F401  (a fixture of all tests here)
    one_sensor,
    prospects_of,
    whole,
)
from tests.commands import output
from tests.draws import composed, fewer
from tests.logic.automata import read

T = TypeVar("T", Hardware, Fault)


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
    crashes = {crash.name for crash in mission_net.core.crashes}
    assert {*found} == {h.name for h in mission_net.core.hardware if h.failure_rate and h.faulty}
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
    assert found["slopes"] == pytest.approx(slopes(whole_chain(prospects_of(RATED[1]))), rel=1e-9)
    importance = found["risk"]["importance"]
    assert importance["satellite_radio"] > importance["compass"]
    assert found["slopes"]["satellite_radio"] > found["slopes"]["compass"]

    numbers = risk(prospects_of(RATED[1]))
    print_slopes(numbers, found["slopes"])
    shown = capsys.readouterr().out
    assert "they rank otherwise" in shown
    assert shown.index("derivative by compass") < shown.index("derivative by satellite radio")
    print_slopes(numbers, {"compass": -2.0, "satellite_radio": -3.0})
    assert capsys.readouterr().out == ""


def test_derivatives_of_too_many_states_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    prospects = prospects_of(RATED[0])
    assert slopes_of(prospects.within(100)) is None
    assert set(slopes_of(prospects) or {}) == set(prospects.hardware)
