"""Places where the language page could be read in two ways: the reading that it says, by all that play."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.logic.questions import Questions
from mcpn.mission.model import Block, Each, EntryGuard, FactRoute, Handler, Mission, Objective, Recursive
from mcpn.mission.robot import DeclaredEvent, Fact, FactChange
from mcpn.spaces.engine_names import Engine
from mcpn.testing.judge.interpreter import (
    DECLARED,
    FAILURE,
    OUT_OF_SERVICE,
    TIMEOUT,
    Happening,
    Interpreter,
)
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN
from tests.judge.test_interpreter import play
from tests.logic.asked import ENGINES
from tests.small import activity, hw, mission, robot

ROBOT = replace(
    robot((), *(activity(name, ()) for name in "abcd"), events=("rain",)),
    facts=(Fact(name="low"),),
)
SINKS = DeclaredEvent(name="sinks", sets=(FactChange(fact="low", to="true"),))
ROBOT = replace(ROBOT, events=(*ROBOT.events, SINKS))
STUCK: Happening = (f"{FAILURE} stuck", "a")


def one(name: str, **others: object) -> Objective:
    return Objective(name=name, activities=(name[0],), **others)  # type: ignore[arg-type]


def series(name: str, *blocks: Block, **others: object) -> Recursive:
    return Recursive(name=name, blocks=blocks, **others)  # type: ignore[arg-type]


def for_stuck(goto: str) -> tuple[FactRoute, ...]:
    return (FactRoute(on="failure", reason="stuck", goto=goto),)


LEFT = (Handler(when=("low",), goto="fail"),)
OBJECTIVE_LEFT_BY_FACTS = mission(
    ROBOT,
    series("r", one("a", failures=("stuck",), handlers=LEFT), routes=for_stuck("c"), failure="d"),
    one("c", success="succeed"),
    one("d", success="fail"),
)
"""The objective has facts by which it is left, and a reason; the block around it asks for the reason."""
REFUSED_ENTRY = mission(
    ROBOT,
    series(
        "r",
        one("a", failures=("stuck",), routes=for_stuck("b"), success="succeed"),
        one("b", guards=(EntryGuard(when=("low",), otherwise="fail"),)),
        routes=for_stuck("c"),
        failure="d",
    ),
    one("c", success="succeed"),
    one("d", success="fail"),
)
CAMERA = replace(
    robot(hw("camera"), activity("a", ("camera",)), activity("b", ("camera",))),
    hardware=(replace(hw("camera")[0], detected="late"),),
)
TIMED = mission(CAMERA, series("r", one("a"), timeout=9, timeout_goto="b"), one("b", success="succeed"))
TIMED_INSIDE = mission(CAMERA, one("a", timeout=9, timeout_goto="b"), one("b", success="succeed"))
LOST = (OUT_OF_SERVICE, "camera")


@pytest.mark.parametrize(
    ("of", "events", "running", "unnoticed"),
    [
        (OBJECTIVE_LEFT_BY_FACTS, [STUCK], {"c"}, set()),
        (OBJECTIVE_LEFT_BY_FACTS, [(FAILURE, "a")], {"d"}, set()),
        (OBJECTIVE_LEFT_BY_FACTS, [(DECLARED, "sinks")], {"d"}, set()),
        (REFUSED_ENTRY, [STUCK], {"d"}, set()),
        (REFUSED_ENTRY, [(DECLARED, "sinks"), STUCK], {"b"}, set()),
        (TIMED, [LOST, (TIMEOUT, "r")], {"b"}, {"camera"}),
        (TIMED_INSIDE, [LOST, (TIMEOUT, "a")], set(), set()),
    ],
)
def test_what_it_leads_to(
    of: Mission, events: list[Happening], running: set[str], unnoticed: set[str]
) -> None:
    interpreter, state = play(Interpreter(of), BEGIN, *events)
    seen = interpreter.seen(state)
    refused = {name for name in seen.running if name in seen.refused}
    assert seen.running - refused == running
    assert seen.unnoticed == unnoticed
    assert Judge(of).judge().kind == "agree"


REST = Handler(event="rain", pause="b")
PAUSED = mission(ROBOT, series("work", one("a"), one("c"), handlers=(REST,)), one("b"))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("G (block(work) & happens(rain) -> X (objective(b) & !block(work)))", True),
        ("EF (block(work) & objective(b))", False),
        ("G (objective(b) & happens(OBJ_b_EV_OK) -> X block(work))", True),
        ("G (objective(b_at_a) & happens(OBJ_b_EV_OK) -> X objective(a))", True),
    ],
)
def test_a_block_that_pauses_does_not_run(engine: Engine, formula: str, holds: bool) -> None:
    questions = Questions(spaces_of(compose(PAUSED)), engine=engine)
    assert questions.answer(formula).holds is holds


ROUNDS = mission(ROBOT, Each(name="e", values=("x", "y"), blocks=(one("a", repeat=2, retries=1),)))


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("a", {f"a_{v}_{n}_try{t}" for v in "xy" for n in (1, 2) for t in (1, 2)}),
        ("a_x", {f"a_x_{n}_try{t}" for n in (1, 2) for t in (1, 2)}),
        ("a_x_2", {"a_x_2_try1", "a_x_2_try2"}),
        ("a_x_2_try1", {"a_x_2_try1"}),
    ],
)
def test_a_longer_name_of_a_copy_means_fewer(name: str, meant: set[str]) -> None:
    questions = Questions(spaces_of(compose(ROUNDS)))
    every = " | ".join(f"objective({each})" for each in sorted(meant))
    assert questions.answer(f"AG (objective({name}) <-> ({every}))").holds


@pytest.mark.parametrize("name", ["a_2", "a_try1", "a_x_try1"])
def test_nothing_is_left_out_in_the_middle_of_a_copys_name(name: str) -> None:
    with pytest.raises(InputError, match=f"no objective is named {name}"):
        Questions(spaces_of(compose(ROUNDS))).formula(f"AG !objective({name})")


AFTER_HELP = mission(
    ROBOT, one("a", success="succeed", failure="b"), one("b", success="c"), one("c", success="succeed")
)
"""Only failure leads to ``b``, and only the success of that to ``c``."""
LED_NOWHERE = mission(ROBOT, one("a", success="succeed"), one("b"))
BY_A_GUARD = mission(
    ROBOT,
    one("d"),
    one("a", guards=(EntryGuard(when=("!low",), otherwise="b"),), success="succeed"),
    one("b", success="succeed"),
)


@pytest.mark.parametrize(("of", "holds"), [(AFTER_HELP, True), (LED_NOWHERE, False), (BY_A_GUARD, True)])
def test_who_helps_need_not_be_entered_while_nothing_fails(of: Mission, holds: bool) -> None:
    assert check(compose(of)).verdicts["nominal_success"].holds is holds
