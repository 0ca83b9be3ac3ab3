"""The chain of the whole mission as an automaton: read again and solved exactly, and judged by Storm.

A campaign (``tests/draws.py``) holds drawn missions against both::

    MCPN_CAMPAIGN=500 python -m pytest -m slow -s tests/answers/test_whole_chain.py
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.causes.whole_chain import WholeChain, whole_chain
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.report.failures.drn import drn, objective_labels
from mcpn.spaces.engine_names import Engine
from mcpn.study import open_study
from mcpn.testing import Shape, missions
from tests import small
from tests.answers.dense import any_missions, interrupted_missions, with_numbers
from tests.answers.exact import scaled
from tests.commands import mcpn as command
from tests.commands import output
from tests.draws import campaign, composed, fewer
from tests.logic.automata import judged, read
from tests.small import activity, robot

try:
    import stormpy
except ImportError:
    stormpy = None
needs_storm = pytest.mark.skipif(stormpy is None, reason="the extra storm is not installed")

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
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
def prospects_of(name: str) -> Prospects[Any]:
    """A worked mission, as ``auto`` takes it."""
    study = open_study(EXPERIMENTS / name)
    return Prospects(study.mission_net, study.alternatives())


@cache
def worked(name: str) -> tuple[Prospects[Any], bytes]:
    """The same, and its automaton."""
    prospects = prospects_of(name)
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
