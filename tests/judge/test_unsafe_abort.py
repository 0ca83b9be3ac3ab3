"""An abort that the failure of what should make safe leads to: every engine against the interpreter."""

from __future__ import annotations

import pytest
from hypothesis import event, given

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.model import Mission, Objective
from mcpn.spaces.engines import Engine
from mcpn.testing import elements as drawn
from tests.draws import composed, fewer
from tests.judge.interpreter import FAILURE, SUCCESS, TIMEOUT, Interpreter, Undetermined
from tests.small import activity, hw, mission, robot

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
MOST_STATES = 1_000


def by_word_alone(of: Mission) -> bool | None:
    """Whether an objective ends the mission in abort by its success and by its failure."""
    interpreter = Interpreter(of)
    well, badly = set[str](), set[str]()
    known, stack = {interpreter.initial}, [interpreter.initial]
    while stack:
        state = stack.pop()
        for what, name in interpreter.possible(state):
            after = interpreter.after(state, (what, name))
            if after.outcome == "abort" and state.outcome is None:
                well |= {name} if what == SUCCESS else set()
                badly |= {name} if what in (FAILURE, TIMEOUT) else set()
            if after not in known:
                known.add(after)
                stack.append(after)
        if len(known) > MOST_STATES:
            return None
    return bool(well & badly)


@fewer(0.5)
@given(drawn.ABORTED)
def test_drawn_missions(of: Mission) -> None:
    try:
        expected = by_word_alone(of)
    except Undetermined:
        expected = None
    event(f"by word alone: {expected}")
    if expected is None:
        return
    for engine in ENGINES:
        try:
            verdict = check(composed(of), engine=engine).verdicts.get("abort_by_failure")
        except LimitError:
            return
        assert (verdict is not None and verdict.holds) is expected, engine


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("failure", "unsafe"), [("abort", True), ("up", False), ("fail", False)])
def test_a_shelter(engine: Engine, failure: str, unsafe: bool) -> None:
    of = mission(
        robot(hw("thrusters"), activity("swim", ("thrusters",))),
        Objective(name="work", activities=("swim",), success="succeed", failure="up"),
        Objective(name="up", activities=("swim",), success="abort", failure=failure),
    )
    verdict = check(compose(of), engine=engine).verdicts["abort_by_failure"]
    assert verdict.holds is unsafe
    if unsafe:
        assert "up" in verdict.explanation
        (run,) = verdict.runs
        assert str(run.events[-1]) == "OBJ_up_EV_FAIL"
