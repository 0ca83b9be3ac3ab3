"""Hardware that fails on demand: numbers by hand, and against the dense solve that tests write."""

from __future__ import annotations

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import Risk, risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Each, Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.answers.dense import Dense, with_numbers
from tests.answers.test_risk_interrupted import assert_same
from tests.draws import fewer
from tests.logic.asked import ENGINES
from tests.shares import returns_early
from tests.small import activity, mission, robot

P, Q = 0.25, 0.5


def by(engine: Engine, of: Mission) -> Risk:
    found = compose(of)
    return risk(Prospects(found, spaces_of(found).space(engine, "alternatives")))


def does(name: str, runs: str, retries: int = 0) -> Objective:
    return Objective(name=name, activities=(runs,), duration=1.0, failure_probability=0.0, retries=retries)


def asking(*blocks: Objective | Each, repair: float | None = None) -> Mission:
    """Activity a prefers h to g, c needs h; both fail on demand alone."""
    hardware = (
        Hardware(name="h", demand_probability=P, repair_rate=repair),
        Hardware(name="g", demand_probability=Q),
    )
    return mission(robot(hardware, activity("a", ("h",), ("g",)), activity("c", ("h",))), *blocks)


ROUNDS = Each(name="v", values=("x", "y", "z"), blocks=(does("o", "c"),))
BY_HAND = pytest.mark.parametrize(
    ("of", "success", "degraded"),
    [
        (asking(does("one", "a")), 1 - P * Q, P * (1 - Q)),
        (asking(does("one", "c"), does("two", "c")), (1 - P) ** 2, 0.0),
        # h fails at the first or at the second start; g then starts once or twice.
        (
            asking(does("one", "a"), does("two", "a")),
            (1 - P) ** 2 + (1 - P) * P * (1 - Q) + P * (1 - Q) ** 2,
            (1 - P) * P * (1 - Q) + P * (1 - Q) + P * (1 - Q) ** 2,
        ),
        (asking(ROUNDS), (1 - P) ** 3, 0.0),
        # Nobody repairs: a second try finds h as the first has left it.
        (asking(does("one", "c", retries=5)), 1 - P, 0.0),
    ],
)


@pytest.mark.parametrize("engine", ENGINES)
@BY_HAND
def test_numbers_by_hand(engine: Engine, of: Mission, success: float, degraded: float) -> None:
    found = by(engine, of)
    assert found.success == pytest.approx(success)
    assert found.failure == pytest.approx(1 - success)
    assert found.degraded_modes == pytest.approx(degraded)


@pytest.mark.parametrize("engine", ENGINES)
def test_importance_of_what_is_never_asked_again(engine: Engine) -> None:
    found = by(engine, asking(does("one", "a")))
    assert found.importance == pytest.approx({"h": 1 - (1 - Q), "g": 1 - (1 - P)})


SMALL = st.one_of(
    missions(sections=4, hardware=2, producers=1),
    missions(sections=4, hardware=3, alternatives=3, own_hardware=True, shared_activities=False),
    missions(sections=4, hardware=2, producers=1, events=1, pauses=5),
    missions(sections=4, hardware=2, producers=1, aborts=3, early=3),
    missions(sections=4, hardware=2, producers=1, lasting=True, faults=1),
)


@fewer(0.5, least=8)
@given(SMALL, st.data())
def test_numbers_are_those_of_a_dense_solve(of: Mission, data: st.DataObject) -> None:
    found = compose(data.draw(with_numbers(of, demands=True)))
    try:
        graph = direct(found.net, max_states=300)
        computed = {
            engine: risk(Prospects(found, spaces_of(found).space(engine, "alternatives")))
            for engine in ENGINES
        }
    except (LimitError, ConfluenceError, DivergenceError) as error:
        returns_early(type(error).__name__)
        return
    asked = any(h.demand_probability for h in found.core.hardware)
    event(f"on demand: {asked}")
    numbers = Dense(found, graph).numbers()
    for each in computed.values():
        assert_same(each, numbers)
