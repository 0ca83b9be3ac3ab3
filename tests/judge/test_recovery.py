"""Blocks that recover: hand-written missions, what each comes to, and all that play them."""

from __future__ import annotations

import pytest

from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Each, Handler, Mission, Objective, Recursive
from mcpn.mission.static.warnings import find_warnings
from mcpn.testing.judge.interpreter import DECLARED, FAILURE, SUCCESS, TIMEOUT, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN, ROBOT, one
from tests.judge.test_interpreter import play
from tests.small import mission

LEAK: Happening = (DECLARED, "leak")


def again(name: str, times: int = 1, **others: object) -> Objective:
    """An objective with the activity of its name that recovers by b."""
    return Objective(name=name, activities=(name,), recover="b", times=times, **others)  # type: ignore[arg-type]


TWICE = mission(ROBOT, again("a", 2, failure="d"), one("b"), one("c"), one("d"))
TRIES = mission(ROBOT, again("a", retries=1, repeat=2), one("b"), one("c"))
TIMED = mission(ROBOT, again("a", timeout=5.0, timeout_goto=None), one("b"), one("c"))
LATE = mission(ROBOT, again("a", timeout=5.0, timeout_goto="c"), one("b"), one("c"))
SHARED = mission(ROBOT, again("a"), one("b"), again("c"), one("d"))
BLOCKS = mission(
    ROBOT,
    Recursive(name="r", blocks=(one("a"), one("c")), recover="s"),
    Recursive(
        name="s",
        blocks=(one("b"), one("d", failure="abort")),
        abort="g",
        handlers=(Handler(event="leak", goto="f"),),
    ),
    one("e"),
    one("f", success="succeed"),
    one("g"),
)
ROUNDS = mission(ROBOT, Each(name="v", values=("x", "y"), blocks=(again("a"), one("b"), one("c"))))
FIRST = mission(ROBOT, one("b"), again("a"), one("c"))
AROUND = mission(
    ROBOT, Recursive(name="r", blocks=(again("a"), one("b"))), one("c", success="r", failure="succeed")
)
PAUSED = mission(
    ROBOT,
    again("a", failure="d", retries=1, handlers=(Handler(event="leak", pause="e"),)),
    one("b"),
    one("c"),
    one("d"),
    one("e"),
)
"""Recovers, and pauses for another block."""
LATE_HELP = mission(
    ROBOT,
    again("a", failure="d", handlers=(Handler(event="leak", pause="e"),)),
    Objective(name="b", activities=("b",), timeout=5.0, timeout_goto="c"),
    one("c"),
    one("d"),
    Objective(name="e", activities=("e",), timeout=5.0, timeout_goto="c", failure="c"),
)
"""What runs for a block, in pauses and to recover, leads elsewhere when its time is over."""
MISSIONS = (PAUSED, LATE_HELP, TWICE, TRIES, TIMED, LATE, SHARED, BLOCKS, ROUNDS, FIRST, AROUND)


@pytest.mark.parametrize("of", MISSIONS)
def test_all_that_play_it_agree(of: Mission) -> None:
    verdict = Judge(of).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


def ok(*names: str) -> list[Happening]:
    return [(SUCCESS, name) for name in names]


def bad(name: str) -> Happening:
    return FAILURE, name


@pytest.mark.parametrize(
    ("of", "events", "running"),
    [
        (TWICE, [bad("a_run1")], {"b_a1"}),
        (TWICE, [bad("a_run1"), bad("b_a1")], {"d"}),
        (TWICE, [bad("a_run1"), *ok("b_a1", "a_run2")], {"c"}),
        (TWICE, [bad("a_run1"), *ok("b_a1"), bad("a_run2"), *ok("b_a2"), bad("a_run3")], {"d"}),
        (TRIES, [*ok("a_run1_1_try1"), bad("a_run1_2_try1")], {"a_run1_2_try2"}),
        (TRIES, [bad("a_run1_1_try1"), bad("a_run1_1_try2"), *ok("b_a1")], {"a_run2_1_try1"}),
        (TIMED, [(TIMEOUT, "a_run1")], {"b_a1"}),
        (LATE, [(TIMEOUT, "a_run1")], {"c"}),
        (SHARED, [bad("a_run1"), *ok("b_a1", "a_run2"), bad("c_run1")], {"b_c1"}),
        (SHARED, ok("a_run1", "c_run1"), {"d"}),
        (BLOCKS, [*ok("r_run1.a"), bad("r_run1.c")], {"s_r1.b"}),
        (BLOCKS, [bad("r_run1.a"), *ok("s_r1.b"), bad("s_r1.d")], {"g"}),
        (BLOCKS, [bad("r_run1.a"), (DECLARED, "leak")], {"f"}),
        (BLOCKS, [bad("r_run1.a"), *ok("s_r1.b", "s_r1.d", "r_run2.a", "r_run2.c")], {"e"}),
        (ROUNDS, [bad("a_x_run1"), *ok("b_x_a1", "a_x_run2", "c_x"), bad("a_y_run1")], {"b_y_a1"}),
        (FIRST, ok("b"), {"a_run1"}),
        (PAUSED, [LEAK, bad("e_at_a_run1_try1")], {"d"}),
        (PAUSED, [LEAK, *ok("e_at_a_run1_try1"), bad("a_run1_try1"), bad("a_run1_try2")], {"b_a1"}),
        (LATE_HELP, [LEAK, (TIMEOUT, "e_at_a_run1")], {"c"}),
        (LATE_HELP, [LEAK, bad("e_at_a_run1")], {"d"}),
        (LATE_HELP, [bad("a_run1"), (TIMEOUT, "b_a1")], {"c"}),
        (AROUND, [bad("a_run1"), *ok("b_a1", "a_run2", "c"), bad("a_run1")], {"b_a1"}),
    ],
)
def test_what_a_failure_leads_to(of: Mission, events: list[Happening], running: set[str]) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running


def test_a_sibling_that_only_recovers_is_no_warning() -> None:
    unused = {f"activity {name} is never started" for name in "efgz"}
    told = {warning.message for warning in find_warnings(TWICE)}
    assert not {message for message in told if "entered" in message}
    assert unused <= told
    assert [s.name for s in flatten(TWICE).sections] == [
        "a_run1",
        "b_a1",
        "a_run2",
        "b_a2",
        "a_run3",
        "c",
        "d",
    ]
