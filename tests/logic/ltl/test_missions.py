"""What paths of missions satisfy, on every engine and by tableaux."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest
from hypothesis import event, given, reject
from hypothesis import strategies as st

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, InputError, LimitError
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.ltl.formulas import Happens, SomePath, normal
from mcpn.logic.questions import Questions
from mcpn.mission.model import Mission
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engine_names import SPACE_ENGINES, Asked
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.ltl import tableau
from tests.logic.ltl.test_paths import fits
from tests.logic.test_ctl import names, satisfy


@fewer(0.6)
@given(missions(max_sections=4) | missions(max_sections=4, late=True), st.data())
def test_every_engine_and_tableaux_agree_on_missions(mission: Mission, data: st.DataObject) -> None:
    mission_net = compose(mission)
    net = mission_net.net
    try:
        graph = by_reduction(explore(net, max_states=500))
    except (LimitError, ConfluenceError, DivergenceError):
        reject()
    spaces: list[Space[Any]] = [ArraySpace(graph), DiagramAlternatives(reach(net))]
    with suppress(LimitError):
        spaces.append(composite_space(mission_net))
        event("by composition")
    edges = {
        graph.marking(s): [(e.transition, graph.marking(e.target)) for e in ArraySpace(graph).edges(s)]
        for s in range(graph.states)
    }
    written = data.draw(tableau.formulas(*names(net), leaves=4))
    if not fits(written, edges):
        return
    expected = tableau.satisfying(written, net, edges)
    event(f"some {bool(expected)}, all {len(expected) == len(edges)}")
    alone = SomePath(normal(tableau.read(written, net)))
    for space in spaces:
        assert satisfy(Evaluation(space), alone) == expected
        assert Evaluation(space).holds(alone) == (graph.marking(0) in expected)


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("formula", "fair", "holds"),
    [
        ("G (objective(diving) -> F (success | failure))", (), False),  # a sensor fails and recovers for ever
        ("G (objective(diving) -> F (success | failure))", ("progress",), True),
        ("F G (success | failure)", ("progress",), True),
        ("G (happens(GPS_sensor_EV_OOS) -> X oos(GPS_sensor))", (), True),
        ("G (happens(GPS_sensor_EV_OOS) -> X X oos(GPS_sensor))", (), False),
        ("!objective(filming) W happens(OBJ_transect.diving_EV_OK)", (), True),
        ("G !happens(OBJ_transect.diving_EV_FAIL)", (), False),
        ("E (!oos(GPS_sensor) U success)", (), True),
        ("G F oos(GPS_sensor) -> G F happens(GPS_sensor_EV_OOS)", (), False),  # it never returns
    ],
)
def test_formulas_of_runs_of_ulysse(
    ulysse_net: MissionNet, engine: Asked, formula: str, fair: tuple[str, ...], holds: bool
) -> None:
    questions = Questions(spaces_of(ulysse_net), engine=engine, fair=fair)
    assert questions.answer(formula).holds is holds


def test_what_happens_is_said_of_a_step(ulysse_net: MissionNet) -> None:
    meaning = MissionNames(ulysse_net).word("happens", "GPS_sensor_EV_OOS")
    assert isinstance(meaning, Happens)
    assert meaning.transitions
    with pytest.raises(InputError, match="no event is named"):
        MissionNames(ulysse_net).word("happens", "nothing")
