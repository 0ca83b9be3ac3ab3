"""Claims of missions of all elements, against an interpreter that draws no net and knows no formula.

A campaign (``tests/draws.py``) says how many claims of which kinds were judged on how many missions::

    MCPN_CAMPAIGN=500 python -m pytest -m slow -s tests/judge/test_claimed.py
"""

from __future__ import annotations

import sys
from collections import Counter
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.claims import Claim, claims_of, claims_of_causes
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.spaces.engine_names import Engine
from mcpn.study import Study
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import Undetermined
from tests.draws import campaign, composed, fewer
from tests.judge.asked import Runs
from tests.judge.claimed import Judged
from tests.logic.asked import ENGINES
from tests.shares import returns_early

MOST_STATES = 300
OF = (
    drawn.INTERRUPTED,
    drawn.ABORTED,
    drawn.EARLY,
    drawn.COMMON_CAUSES,
    drawn.LASTING,
    drawn.CRASHING,
    drawn.LATE,
    drawn.PAUSING,
    drawn.TIMED,
    drawn.LED,
    drawn.LEFT_BY_FACTS,
    drawn.WORLD,
    drawn.GUARDED,
    drawn.IN_ROUNDS,
    drawn.RECOVERING,
    drawn.ENDS_AT_ONCE,
)
MISSIONS = st.integers(0, len(OF) - 1).flatmap(OF.__getitem__)


def made(mission: Mission, engine: Engine) -> tuple[list[Claim], Prospects[Any] | None]:
    """The claims of a mission, and where it may still lead."""
    study = Study(composed(mission))
    checked = study.verdicts(engine=engine)
    if checked.alternatives is None:
        return [], None
    causes = study.causes(engine=engine)
    losses = claims_of_causes(causes, fmeca(causes.prospects))
    return [*claims_of(checked), *losses], causes.prospects


def judged(mission: Mission, engine: Engine) -> Counter[str]:
    """Holds each claim against the interpreter, and says how many of each kind."""
    counted = Counter[str]()
    try:
        Runs(mission, MOST_STATES)
        claims, prospects = made(mission, engine)
    except (Undetermined, OverflowError, SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return counted
    if prospects is None:
        return counted
    meant = prospects.mission_net.graph.copies.meant
    judge = Judged(mission, MOST_STATES, prospects.hardware, meant)
    for claim in claims:
        if claim.kind.startswith(("any_lost", "most_lost")) and claim.subject == ("the start",):
            number = int(claim.refers_to[0].partition(" ")[0])
            with suppress(OverflowError):  # more losses or states than are played one by one
                so = judge.numbers(claim.kind, number)
                assert so is None or claim.holds is so, (claim.key, number)
                counted[claim.kind] += so is not None
        if claim.formula and claim.holds is not None:
            said = judge.says(claim.kind, claim.subject, claim.assumes.help == "declared")
            if said is not None:
                assert claim.holds is said, claim.key
                counted[claim.kind] += 1
    return counted


@fewer(0.3)
@given(MISSIONS, st.sampled_from(ENGINES))
def test_claims_are_so(mission: Mission, engine: Engine) -> None:
    judged(mission, engine)


@pytest.mark.slow
def test_campaign() -> None:
    kinds = Counter[str]()

    def judge(drawn: tuple[Mission, Engine]) -> str:
        found = judged(*drawn)
        kinds.update(found)
        return "judged" if found else "not judged"

    found = campaign(st.tuples(MISSIONS, st.sampled_from(ENGINES)), judge, 500)
    told = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
    sys.stderr.write(f"{kinds.total()} claims: {told}\n")
    assert found["judged"] > found["drawn"] / 4
