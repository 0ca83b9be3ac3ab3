"""An abort that the failure of a safing objective leads to: every engine against the interpreter."""

from __future__ import annotations

import pytest
from hypothesis import event, given

from mcpn.answers.causes.find import find_causes
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Mission, Objective, Recursive
from mcpn.spaces.engine_names import Engine
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import FAILURE, SUCCESS, TIMEOUT, Interpreter, State, Undetermined
from tests.draws import composed, fewer
from tests.small import activity, hw, mission, robot

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
MOST_STATES = 1_000


def by_word_alone(of: Mission) -> set[str] | None:
    """The objectives by whose failure the mission aborts, and which should make the robot safe.

    Their success ends the mission in abort; or what succeeds after it leads to abort, and never to success.
    """
    interpreter = Interpreter(of)
    ended, badly, onward = dict[str, set[str]](), set[str](), dict[State, set[State]]()
    begun = dict[str, set[State]]()
    known, stack = {interpreter.initial}, [interpreter.initial]
    while stack:
        state = stack.pop()
        for what, name in interpreter.possible(state):
            after = interpreter.after(state, (what, name))
            if what == SUCCESS:
                onward.setdefault(state, set()).add(after)
                begun.setdefault(name, set()).add(after)
            if after.outcome == "abort" and state.outcome is None:
                ended.setdefault(what, set()).add(name)
                if what.startswith(FAILURE) or what == TIMEOUT:
                    badly |= failing(interpreter, state, name)
            if after not in known:
                known.add(after)
                stack.append(after)
        if len(known) > MOST_STATES:
            return None

    def outcomes(states: set[State]) -> set[str | None]:
        """The ends to which successes lead from some states."""
        seen, left = set(states), list(states)
        while left:
            fresh = onward.get(left.pop(), set()) - seen
            seen |= fresh
            left += fresh
        return {state.outcome for state in seen} - {None}

    def shelter(name: str) -> bool:
        if name in ended.get(SUCCESS, ()):
            return True
        ends = outcomes(begun.get(name, set()))
        return "abort" in ends and "success" not in ends

    return {name for name in badly if shelter(name)}


def failing(interpreter: Interpreter, state: State, name: str) -> set[str]:
    """The objectives that fail as one does, or as the time of a block is over: what runs in it."""
    if name not in interpreter.timed or name in interpreter.objectives:
        return {name}
    return {*interpreter.within(interpreter.timed[name], state) & state.running}


@fewer(0.5)
@given(drawn.ABORTED | drawn.IN_TIME)
def test_drawn_missions(of: Mission) -> None:
    try:
        expected = by_word_alone(of)
    except Undetermined:
        expected = None
    event(f"by word alone: {bool(expected)}")
    if expected is None:
        return
    for engine in ENGINES:
        try:
            verdict = check(composed(of), engine=engine).verdicts.get("abort_by_failure")
        except LimitError:
            return
        assert bool(verdict is not None and verdict.holds) is bool(expected), engine
        if verdict is not None and expected:
            ((*_, last),) = (run.events for run in verdict.runs)
            ends = flatten(of).timed_blocks()
            held = {block.name: block.held for block in ends}
            assert expected.intersection(held.get(last.element, [last.element]))
            try:
                causes = find_causes(composed(of), engine=engine)
            except LimitError as error:
                if "cannot tell one run of its objectives from the next" in str(error):
                    return
                raise
            assert {*causes.unsafe_aborts} == expected, engine


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


@pytest.mark.parametrize("engine", ENGINES)
def test_the_first_of_a_shelter_of_two(engine: Engine) -> None:
    """Where one of two objectives fails that make safe one after the other, nothing has been made safe."""
    of = mission(
        robot(hw("thrusters", "weight"), activity("swim", ("thrusters",)), activity("drop", ("weight",))),
        Objective(name="work", activities=("swim",), success="succeed", failure="shelter"),
        Recursive(
            name="shelter",
            blocks=(
                Objective(name="release", activities=("drop",)),
                Objective(name="up", activities=("swim",)),
            ),
            success="abort",
            failure="abort",
        ),
    )
    found = find_causes(compose(of), engine=engine)
    assert found.unsafe_aborts == ("release", "up")
    assert found.safety is not None
    assert found.safety.cut_sets == [("thrusters",)]  # while these work, the work succeeds without the weight
