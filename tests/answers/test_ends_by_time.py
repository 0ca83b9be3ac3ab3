"""Ends of a mission by a time, beside the exponential of its chain's matrix, and judged by Storm."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import expm

from mcpn.answers.causes import ends_by_time
from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.ends_by_time import poisson, within
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.whole_chain import WholeChain, whole_chain
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.report.failures.drn import drn
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.test_whole_chain import (
    ENDS,
    EXPERIMENTS,
    RATED,
    long_fractions,  # noqa: F401  (a fixture of all tests here)
    needs_storm,
    objective,
    one_sensor,
    whole,
    worked,
)
from tests.commands import mcpn as command
from tests.commands import output
from tests.draws import composed, fewer
from tests.logic.automata import Automaton, read

try:
    import stormpy
except ImportError:
    stormpy = None


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
