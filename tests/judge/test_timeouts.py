"""Objectives whose time may be over: hand-written missions, what each comes to, and all that play them."""

from __future__ import annotations

import pytest

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.spaces.engine_names import SPACE_ENGINES
from mcpn.testing.judge.interpreter import SUCCESS, TIMEOUT, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN, ROBOT, one
from tests.judge.test_interpreter import play
from tests.small import mission


def timed(name: str, goto: str | None = None, **others: object) -> Objective:
    """An objective with the activity of its name, for a minute and a half."""
    return Objective(name=name, activities=(name,), timeout=90.0, timeout_goto=goto, **others)  # type: ignore[arg-type]


PLAIN = mission(ROBOT, timed("a", failure="c"), one("b"), one("c"))
GOTO = mission(ROBOT, timed("a", "c", failure="b"), one("b"), one("c"))
TRIES = mission(ROBOT, timed("a", failure="b", retries=1), one("b"))
TRIES_LEFT = mission(ROBOT, timed("a", "c", retries=2, repeat=2), one("b"), one("c"))
AGAIN = mission(ROBOT, timed("a", "a"), one("b"))
ABORTS = mission(ROBOT, timed("a", "abort"))
NAMED_SO = mission(ROBOT, Objective(name="timeout", activities=("a",), timeout=1, timeout_goto="b"), one("b"))
BRANCH = mission(
    ROBOT,
    Parallel(
        name="both",
        blocks=(timed("a", "succeed"), Recursive(name="r", blocks=(timed("b", "d"), one("c"), one("d")))),
        success="f",
        failure="e",
    ),
    one("e"),
    one("f"),
)
MISSIONS = (PLAIN, GOTO, TRIES, TRIES_LEFT, AGAIN, ABORTS, NAMED_SO, BRANCH)


@pytest.mark.parametrize("of", MISSIONS)
def test_all_that_play_it_agree(of: Mission) -> None:
    verdict = Judge(of).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


def late(name: str) -> Happening:
    return TIMEOUT, name


@pytest.mark.parametrize(
    ("of", "events", "running", "outcome"),
    [
        (PLAIN, [late("a")], {"c"}, None),
        (GOTO, [late("a")], {"c"}, None),
        (TRIES, [late("a_try1")], {"a_try2"}, None),
        (TRIES, [late("a_try1"), late("a_try2")], {"b"}, None),
        (TRIES_LEFT, [(SUCCESS, "a_1_try1"), late("a_2_try1")], {"c"}, None),
        (TRIES_LEFT, [late("a_1_try1")], {"c"}, None),
        (AGAIN, [late("a")], {"a"}, None),
        (ABORTS, [late("a")], set(), "abort"),
        (NAMED_SO, [late("timeout")], {"b"}, None),
        (BRANCH, [late("a"), late("b")], {"d"}, None),
        (BRANCH, [late("b"), late("a"), (SUCCESS, "d")], {"f"}, None),
    ],
)
def test_what_a_timeout_leads_to(
    of: Mission, events: list[Happening], running: set[str], outcome: str | None
) -> None:
    interpreter, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running
    assert state.outcome == outcome
    told = {name for what, name in interpreter.possible(state) if what == TIMEOUT}
    assert told == {name for name in running if interpreter.objectives[name].timeout}


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_verdicts_where_only_a_timeout_leads_on(engine: str) -> None:
    blocks = (timed("a", "b", success="fail", failure="fail"), one("b"))
    found = check(compose(mission(ROBOT, *blocks)), engine=engine)  # type: ignore[arg-type]
    (run,) = found.verdicts["success_reachable"].runs
    assert [str(e) for e in run.events] == ["MISSION_EV_START", "OBJ_a_EV_TIMEOUT", "OBJ_b_EV_OK"]
