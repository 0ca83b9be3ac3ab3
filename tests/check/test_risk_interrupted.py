"""Numbers of risk of missions that declared events interrupt, against a dense solve that the tests write.

``MCPN_CAMPAIGN`` says how many missions the campaign draws (2,000 if not set), ``MCPN_CAMPAIGN_SEED`` which::

    MCPN_CAMPAIGN=2000 python -m pytest -m slow -s tests/check/test_risk_interrupted.py
"""

from __future__ import annotations

import os
import sys
from collections import Counter

import pytest
from hypothesis import HealthCheck, Phase, assume, given, seed, settings
from hypothesis import strategies as st

from mcpn.check.causes.prospects import Prospects
from mcpn.check.causes.risk import Risk, risk
from mcpn.check.spaces import space_of
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.net.compose import compose
from mcpn.space.arrays import ArraySpace
from mcpn.space.stable.alternatives import direct
from tests.check.dense import Dense, Numbers, any_missions, interrupted_missions
from tests.draws import MOST_TRANSITIONS, fewer

DRAWN = st.one_of(interrupted_missions(), any_missions())
MOST_STATES = 300


def assert_same(found: Risk, numbers: Numbers) -> None:
    assert found.success == pytest.approx(numbers.success, rel=1e-9, abs=1e-11)
    assert found.failure == pytest.approx(numbers.failure, rel=1e-9, abs=1e-11)
    assert found.degraded_modes == pytest.approx(numbers.degraded_modes, rel=1e-9, abs=1e-11)
    assert found.importance == pytest.approx(dict(numbers.importance), rel=1e-9, abs=1e-11)


def judge(mission: Mission) -> str:
    """Compares the numbers of each engine with those of the dense solve; says what kind of mission it was."""
    found = compose(mission)
    if len(found.net.transitions) > MOST_TRANSITIONS:
        return "too large"
    try:
        graph = direct(found.net, max_states=MOST_STATES)
    except (LimitError, ConfluenceError, DivergenceError) as error:
        return type(error).__name__
    numbers = Dense(found, graph).numbers()
    assert_same(risk(Prospects(found, ArraySpace(graph))), numbers)
    for engine in ("symbolic", "local"):
        assert_same(risk(Prospects(found, space_of(found, engine, "alternatives"))), numbers)
    handled = {i.event for section in found.graph.all_sections() for i in section.interruptions}
    rates = {event.name for event in mission.events if event.rate}
    if not handled:
        return "no interruption"
    return "interruptions with rates" if handled & rates else "interruptions without rates"


@fewer(0.2)
@given(DRAWN)
def test_numbers_are_those_of_a_dense_solve(mission: Mission) -> None:
    assume(judge(mission).partition(" ")[0] in ("no", "interruptions"))


@pytest.mark.slow
def test_campaign() -> None:
    number = int(os.environ.get("MCPN_CAMPAIGN", "2000"))
    found = Counter[str]()

    @seed(int(os.environ.get("MCPN_CAMPAIGN_SEED", "1")))
    @settings(
        max_examples=number,
        phases=[Phase.generate, Phase.shrink],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(DRAWN)
    def judged(mission: Mission) -> None:
        found["drawn"] += 1
        found[judge(mission)] += 1

    judged()
    sys.stderr.write(f"\n{', '.join(f'{count} {what}' for what, count in found.most_common())}\n")
    assert found["interruptions with rates"] > number / 10
    assert found["interruptions without rates"] > number / 10
