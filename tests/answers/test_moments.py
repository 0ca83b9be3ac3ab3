"""Formulas of losses at one moment: of several at their worst moments by plain search, of entries by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.claims import claims_of_causes
from mcpn.answers.claims.moments import Moments
from mcpn.answers.claims.parts import FormulaParts
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Handler, Mission, Objective
from mcpn.spaces.engine_names import Engine
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.asked import ENGINES
from tests.logic.oracle import Play, coming_home, fragile_missions
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

SEVERAL = (
    fragile_missions(max_hardware=3, max_objectives=2, max_sections=3, lasting=True)
    | missions(max_hardware=3, max_objectives=2, max_sections=3, events=1, timeouts=2)
    | coming_home()
)


def asked(of: Mission, engine: Engine) -> tuple[int, int]:
    """How many sets of losses have a formula, and how many of these leave no way at their worst moments."""
    study = Study(of)
    causes = study.causes(engine="explicit")
    moments, net = Moments(FormulaParts(causes.prospects)), study.mission_net
    play = Play(net)
    begins, ended = play.marks("MISSION_begin"), [play.marks(f"MISSION_{end}") for end in net.ends]
    safe = [f"MISSION_{end}" for end in ("success", "abort") if end in net.ends]
    worst = [m for m in play.forced() if not begins(m)]
    number = lose = 0
    for lost in play.subsets():
        there = [m for m in worst if play.out(m) == lost]
        running = [m for m in there if not any(end(m) for end in ended)]
        unsafe = [m for m in there if not any(play.marks(end)(m) for end in safe)]
        defeated = any(not play.mission_survives(m, lost) for m in running)
        goals = {"losses_defeat": defeated}
        if net.abort is not None:
            goals["losses_endanger"] = any(not play.mission_survives(m, lost, safe) for m in unsafe)
        for kind, expected in goals.items():
            if formula := moments.lost_at_worst(kind, sorted(lost)):
                assert study.ctl(formula, engine=engine).holds is expected, (kind, lost, formula)
                number, lose = number + 1, lose + expected
    return number, lose


@fewer(0.2)
@given(SEVERAL, st.sampled_from(ENGINES))
def test_several_losses_at_their_worst_moments(of: Mission, engine: Engine) -> None:
    try:
        number, lose = asked(of, engine)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    event(f"formulas {number > 0}, some hold {lose > 0}, some fail {lose < number}")


SEE = robot(hw("eye", "ear"), activity("look", ("eye",), ("ear",)), activity("wait", ()))
BOTH_AT_WORST = mission(
    SEE,
    Objective(name="search", activities=("look",), failure="rest"),
    Objective(name="follow", activities=("look",), success="succeed", failure="fail"),
    Objective(name="rest", activities=("wait",)),
)
"""Without eye and ear from the start on it rests, and succeeds; lost while it follows, they leave no way."""
AGAIN = mission(
    replace(SEE, events=robot((), events=("rain",)).events),
    Objective(name="search", activities=("look",), failure="search", success="rest"),
    Objective(name="rest", activities=("wait",), handlers=(Handler(event="rain", goto="search"),)),
)


@pytest.mark.parametrize("engine", ENGINES)
def test_formulas_of_small_missions(engine: Engine) -> None:
    """What a search that begins again has lost is lost to it; from the rest on nothing is needed."""
    expected = {
        "loss_at_entry_defeats: ear and eye together, search": True,
        "loss_at_entry_defeats: ear, search": False,
        "loss_at_entry_defeats: eye, search": False,
        "loss_at_entry_defeats: ear, rest": False,
        "loss_at_entry_defeats: eye, rest": False,
    }
    worst = {"losses_defeat: ear and eye together": True}
    for of, kinds, wanted in ((AGAIN, "loss_at_entry", expected), (BOTH_AT_WORST, "losses_defeat", worst)):
        study = Study(of)
        claims = [c for c in claims_of_causes(study.causes(engine=engine)) if c.kind.startswith(kinds)]
        assert {claim.key: claim.holds for claim in claims} == wanted
        for claim in claims:
            assert claim.formula
            judge = ENGINES[ENGINES.index(engine) - 1]
            assert study.ctl(claim.formula, engine=judge).holds is claim.holds, claim.key
