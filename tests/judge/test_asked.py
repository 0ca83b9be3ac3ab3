"""Requirements on missions in which names mean copies, against an interpreter that draws no net.

A campaign (``tests/draws.py``) draws missions in which names are shared, and says how many were asked what::

    MCPN_CAMPAIGN=600 python -m pytest -m slow -s tests/judge/test_asked.py
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.requirements import answer_requirements, asked_of
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Mission
from mcpn.mission.requirement import Requirement
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.engines import Choice
from mcpn.testing.elements import LED
from mcpn.testing.judge.interpreter import Undetermined
from tests.draws import campaign, fewer
from tests.judge.asked import Claim, Runs, claims
from tests.judge.named import ambiguous, meant
from tests.logic.asked import ENGINES
from tests.shares import returns_early

MOST_STATES = 300
SHARED = LED.filter(lambda mission: bool(ambiguous(mission)))
"""Siblings that are reached by routes and by pauses or recoveries too."""
ASKED = 8
"""Requirements of one mission."""


def asked(mission: Mission, data: st.DataObject) -> list[Claim]:
    """What is claimed of a drawn mission; none where it cannot be played, or is large."""
    try:
        runs = Runs(mission, MOST_STATES)
    except (Undetermined, OverflowError) as error:
        returns_early(type(error).__name__)
        return []
    reached = {objective.name for objective in flatten(mission).walk()}
    known = {".".join(path): frozenset(copies) for path, copies in meant(mission).items() if copies & reached}
    shared = [name for name in ambiguous(mission) if name in known]
    event(f"a name of one and of all: {bool(shared)}")
    x = data.draw(st.sampled_from(sorted(shared or known)))
    y = data.draw(st.sampled_from(sorted(known)))
    every = [*claims(runs, x, known[x], y, known[y])]
    return data.draw(st.permutations(every))[:ASKED]


def asked_and_answered(mission: Mission, engine: Engine, data: st.DataObject) -> int:
    """Compares answers with what is claimed; says of how many requirements."""
    if not (claimed := asked(mission, data)):
        return 0
    said = tuple(Requirement(name=f"r{i}", formula=claim.formula) for i, claim in enumerate(claimed))
    mission_net = compose(replace(mission, requirements=said))
    try:
        space, _ = spaces_of(mission_net).stable(Choice(engine))
    except (SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return 0
    answers = answer_requirements(mission_net, asked_of(mission_net), space)
    for claim, answer in zip(claimed, answers, strict=True):
        assert answer.holds is claim.so, claim.formula
    return len(claimed)


@fewer(0.5)
@given(LED | SHARED, st.sampled_from(ENGINES), st.data())
def test_requirements_are_met_as_the_interpreter_finds(
    mission: Mission, engine: Engine, data: st.DataObject
) -> None:
    asked_and_answered(mission, engine, data)


@pytest.mark.slow
def test_campaign() -> None:
    def judge(drawn: tuple[Mission, Engine, st.DataObject]) -> str:
        return f"asked {asked_and_answered(*drawn)}"

    found = campaign(st.tuples(SHARED, st.sampled_from(ENGINES), st.data()), judge, 600)
    assert found[f"asked {ASKED}"] > found["drawn"] / 4
