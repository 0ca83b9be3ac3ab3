"""Causes by brute force: for every subset of losses the interpreter, which draws no net, says what is left.

A campaign (``tests/draws.py``) says how many missions were asked, and of how many subsets::

    MCPN_CAMPAIGN=1000 python -m pytest -m slow -s tests/judge/test_causes.py
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.minimal_cut_sets import Moment
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.spaces.engine_names import Engine
from mcpn.testing import missions
from mcpn.testing.judge.interpreter import Undetermined
from tests.draws import campaign, fewer
from tests.judge.losses import Played
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

SMALL = st.one_of(
    fragile_missions(max_objectives=3, sections=4, hardware=3, producers=1, recovers=4, pauses=4, events=1),
    fragile_missions(max_objectives=3, sections=4, hardware=3, producers=2, reasons=5, aborts=2),
    fragile_missions(max_objectives=3, sections=4, hardware=3, producers=1, facts=1, guards=5, becoming=4),
    fragile_missions(max_objectives=2, sections=4, hardware=3, producers=2, timed_blocks=6, events=1),
    fragile_missions(max_objectives=2, sections=4, hardware=3, producers=1, faults=2, lasting=True),
    fragile_missions(max_objectives=2, sections=4, hardware=3, producers=1, late=True, lasting=True),
    missions(max_objectives=2, sections=4, hardware=2, producers=1, aborts=2, early=4, timeouts=2),
    missions(max_objectives=2, sections=4, hardware=2, producers=1, recovers=4, pauses=4, events=1),
    missions(max_objectives=2, sections=4, hardware=2, producers=1, faults=1, late=True, lasting=True),
).filter(lambda of: sum(hardware.faulty for hardware in of.hardware) > 1)


def asked(of: Mission, engine: Engine) -> int:
    """Holds an engine's cut sets against the interpreter; says of how many subsets, none if it is left."""
    try:
        played = Played(of)
        starts = {name: played.lost_at_start(name) for name in (None, *played.judge.objectives)}
        causes = Asked(compose(of), engine)
        found = {name: causes.cut_sets(name, Moment.START) for name in (None, *causes.prospects.objectives)}
    except (Undetermined, OverflowError, SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return 0
    assert causes.cut_sets(None, Moment.WHENEVER) == played.lost_whenever()
    for name, sets in found.items():
        assert sets == starts[name], name
    return len(played.subsets)


@fewer(0.35)
@given(SMALL, st.sampled_from(ENGINES))
def test_cut_sets_are_those_of_the_interpreter(of: Mission, engine: Engine) -> None:
    asked(of, engine)


@pytest.mark.slow
def test_campaign() -> None:
    def judge(drawn: tuple[Mission, Engine]) -> str:
        return f"with {asked(*drawn)} subsets"

    found = campaign(st.tuples(SMALL, st.sampled_from(ENGINES)), judge, 1000)
    assert found["with 0 subsets"] < found["drawn"] / 2


def test_losses_by_hand() -> None:
    """Of two ways one is left; the first objective needs the motor, the second may be reached without."""
    eyes = activity("look", ("camera",), ("sonar",))
    of = mission(
        robot(hw("motor", "camera", "sonar"), activity("go", ("motor",)), eyes),
        Objective(name="o", activities=("go",), failure="p"),
        Objective(name="p", activities=("look",)),
    )
    played = Played(of)
    assert played.lost_at_start("o") == [("motor",)]
    assert played.lost_at_start() == played.lost_at_start("p") == [("camera", "sonar")]
    assert played.lost_whenever() == [("camera", "sonar")]
