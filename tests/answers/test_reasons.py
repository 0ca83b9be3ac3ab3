"""Failures that have names: their causes against brute force, numbers of risk against dense solves."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError
from mcpn.mission.model import FactRoute, Mission, Objective, Recursive
from mcpn.mission.reasons import probabilities, reasons_of
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.answers.dense import Dense, with_numbers
from tests.answers.test_cutsets import agree_on_all_causes, confirm, small
from tests.answers.test_risk_interrupted import assert_same, by
from tests.draws import campaign, fewer
from tests.logic.asked import ENGINES, Asked
from tests.small import activity, hw, mission, robot

DRAWN = missions(sections=5, hardware=2, producers=1, alternatives=2, reasons=8, recovers=3, aborts=1)
APART = missions(
    sections=6,
    depth=3,
    hardware=2,
    producers=1,
    reasons=8,
    early=3,
    own_hardware=True,
    shared_activities=False,
)


def numbered(of: Mission) -> int:
    """How many failures with a name some objective of a mission may have."""
    return sum(len(section.reasons) for section in compose(of).graph.walk())


def causes(drawn: tuple[Mission, Engine]) -> str:
    of, engine = drawn
    found = small(of, 400)
    if found is None:
        return "too large"
    confirm(Asked(found, engine))
    return "named" if numbered(of) else "plain"


@given(st.tuples(DRAWN | APART, st.sampled_from(ENGINES)))
def test_cut_sets_are_those_of_brute_force(drawn: tuple[Mission, Engine]) -> None:
    event(causes(drawn))


@fewer(0.3)
@given(DRAWN | APART)
def test_engines_agree_on_all_causes(of: Mission) -> None:
    agree_on_all_causes(of)


def solved(of: Mission) -> str:
    found = compose(of)
    try:
        graph = direct(found.net, max_states=300)
    except Exception:  # contended, or too many states
        return "not listed"
    numbers = Dense(found, graph).numbers()
    for engine in ENGINES:
        try:
            told = risk(Prospects(found, spaces_of(found).space(engine, "alternatives")))
        except LimitError as error:
            if "cannot tell one run of its objectives from the next" in str(error):
                return "led back into"
            raise
        assert_same(told, numbers)
    return "shares" if any(any(s.shares[1:]) for s in found.graph.walk()) else "none"


RATED = APART.flatmap(with_numbers)


@given(RATED)
def test_numbers_are_those_of_a_dense_solve(of: Mission) -> None:
    event(solved(of))


@pytest.mark.slow
def test_campaign() -> None:
    assert campaign(RATED, solved, 400)["shares"] > 100
    assert campaign(st.tuples(DRAWN | APART, st.sampled_from(ENGINES)), causes, 400)["named"] > 100


STUCK = FactRoute(on="failure", reason="stuck", goto="free")


def drive(*routes: FactRoute, retries: int = 0, **more: object) -> MissionNet:
    """A drive that may get stuck, half of its failures, and what frees the robot, which never fails."""
    go = Objective(name="go", activities=("go",), duration=2.0, routes=routes, retries=retries, **more)  # type: ignore[arg-type]
    free = Objective(name="free", activities=("rock",), duration=0.5, success="succeed")
    of = robot(hw("wheels"), activity("go", ("wheels",)), activity("rock", ()))
    return compose(mission(of, Recursive(name="drive", blocks=(go, free), success="succeed")))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("retries", "routed", "success"),
    [
        (0, False, 0.6),
        (0, True, 0.7),
        (1, False, 0.6 + 0.4 * 0.6),
        # Stuck is freed at once; else it is tried again.
        (1, True, 0.6 + 0.1 + 0.3 * (0.6 + 0.1)),
    ],
)
def test_a_part_of_the_failures_is_freed(engine: Engine, retries: int, routed: bool, success: float) -> None:
    found = drive(*[STUCK] * routed, retries=retries, failures=("stuck=0.1", "lost"), failure_probability=0.4)
    numbers = risk(Prospects(found, spaces_of(found).space(engine, "alternatives")))
    assert numbers.success == pytest.approx(success)
    assert numbers.failure == pytest.approx(1 - success)


@pytest.mark.parametrize(
    ("said", "whole", "failures", "parts"),
    [
        (None, 0.0, (), (0.0,)),
        (0.3, 0.3, (), (0.3,)),
        (None, 0.3, ("a=0.1", "b=0.2", "c"), (0.0, 0.1, 0.2, 0.0)),
        (0.3, 0.3, ("a=0.1", "b=0.2"), (0.0, 0.1, 0.2)),
        (0.5, 0.5, ("a=0.1",), (0.4, 0.1)),
    ],
)
def test_parts_are_exact_as_the_file_says_them(
    said: float | None, whole: float, failures: tuple[str, ...], parts: tuple[float, ...]
) -> None:
    of = Objective(name="x", activities=("a",), failures=failures, failure_probability=said)
    found = probabilities(of, reasons_of(of, {}))
    assert found == (whole, parts)
    assert sum(Fraction(repr(part)) for part in found[1]) == Fraction(repr(whole))


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_lost_fails_for_no_reason(engine: Engine) -> None:
    """The route of a reason is followed as often as the reason comes about, not where the wheels are gone."""
    found = drive(STUCK, failures=("stuck=0.1",)).mission
    wheels = replace(found.hardware[0], failure_rate=0.5, repairable=False)
    numbers = by(engine, replace(found, robots=(replace(found.robots[0], hardware=(wheels,)),)))
    # As often as it ends the wheels are lost; nine of ten ends succeed, one is freed.
    assert numbers.success == pytest.approx(0.5)
    assert numbers.failure == pytest.approx(0.5)


def test_the_table_says_where_a_reason_leads() -> None:
    rows = fmeca(Asked(drive(STUCK, failures=("stuck", "lost")), "explicit").prospects)
    (row,) = (row for row in rows if row.objective == "go")
    said = (
        "the objective's failure ends the mission in failure, the objective's failure leads to free for stuck"
    )
    assert row.compensation == said
