"""Causes and numbers of risk of blocks that pause and hold branches, against brute force and dense solves."""

from __future__ import annotations

from itertools import count

from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.mission.model import Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from tests.answers.dense import Dense, with_numbers
from tests.answers.test_cutsets import agree_on_all_causes, confirm
from tests.answers.test_risk_interrupted import assert_same
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.small import activity, hw, robot


@st.composite
def missions_with_paused_branches(draw: st.DrawFn) -> Mission:
    """A block of two branches that pauses, perhaps in a block that pauses, too.

    Args:
        draw: Given by hypothesis.
    """
    ways: st.SearchStrategy[list[tuple[str, ...]]] = st.sampled_from(
        [[()], [("h0",)], [("h1",)], [("h0",), ("h1",)]]
    )
    own: dict[str, list[tuple[str, ...]]] = {"a": [("h0",)], "b": draw(ways), "s": draw(ways), "e": [()]}
    numbers = count()

    def one(runs: str) -> Objective:
        return Objective(name=f"{runs}{next(numbers)}", activities=(runs,))

    # The branches share no hardware, so that nothing contends.
    own["b"] = [()] if ("h0",) in own["b"] else own["b"]
    series = [one("a") for _ in range(draw(st.integers(1, 2)))]
    branches = (Recursive(name="x", blocks=tuple(series)), one("b"))
    routes = st.sampled_from([None, "p", "end", "succeed", "abort"])
    pause = Handler(event="rain", pause="shelter", once=draw(st.booleans()))
    early = draw(st.sampled_from(["all", "any"]))
    block = Parallel(
        name="p", blocks=branches, failure_when=early, handlers=(pause,), failure=draw(routes), abort="end"
    )
    left = st.sampled_from([(), (Handler(event="wind", goto="end"),), (Handler(event="wind", goto="p"),)])
    shelter = Objective(name="shelter", activities=("s",), handlers=draw(left))
    end = Objective(name="end", activities=("e",), success="succeed")
    blocks: tuple[Block, ...] = (block, shelter, end)
    if draw(st.booleans()):
        around = Recursive(name="out", blocks=blocks, handlers=(Handler(event="wind", pause="wait"),))
        blocks = (around, one("e"), Objective(name="wait", activities=("s",)))
    activities = [activity(name, *ways) for name, ways in own.items()]
    of = robot(hw("h0", "h1"), *activities, events=("rain", "wind"))
    return Mission(name="m", robots=(of,), blocks=blocks)


@fewer(0.3)
@given(missions_with_paused_branches(), st.sampled_from(ENGINES))
def test_cut_sets_are_those_of_brute_force(of: Mission, engine: Engine) -> None:
    confirm(Asked(compose(of), engine))


@fewer(0.2)
@given(missions_with_paused_branches())
def test_engines_agree_on_all_causes(of: Mission) -> None:
    agree_on_all_causes(of)


@fewer(0.3)
@given(missions_with_paused_branches(), st.data())
def test_numbers_are_those_of_a_dense_solve(of: Mission, data: st.DataObject) -> None:
    found = compose(data.draw(with_numbers(of)))
    numbers = Dense(found, direct(found.net, max_states=2000)).numbers()
    for engine in ENGINES:
        assert_same(risk(Prospects(found, spaces_of(found).space(engine, "alternatives"))), numbers)
