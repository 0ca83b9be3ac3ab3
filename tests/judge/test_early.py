"""Parallel blocks that do not await all of their branches: hand-written ones, each with what it comes to."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.model import Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.testing.judge.interpreter import DECLARED, FAILURE, SUCCESS, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN, ROBOT, one
from tests.judge.test_interpreter import play
from tests.small import activity, mission, robot


def both(*blocks: Block, **others: Any) -> Mission:
    """A parallel block, ``y`` after its success and ``z`` after its failure."""
    of = Parallel(name="both", blocks=blocks, success="f", failure="g", **others)
    return mission(ROBOT, of, one("f"), one("g"))


def on_leak(name: str, goto: str) -> Objective:
    """An objective that a leak ends."""
    return Objective(name=name, activities=(name,), handlers=(Handler(event="leak", goto=goto),))


THREE = one("a"), one("b"), one("c")
ANY = both(*THREE, success_when="any")
TWO = both(*THREE, success_when="2")
HASTY = both(*THREE, failure_when="any")
OPTIONAL = both(
    one("a"), Objective(name="b", activities=("b",), mandatory=False), one("c"), failure_when="any"
)
RACE = both(*THREE, success_when="any", failure_when="any")
AT_ONCE = both(
    on_leak("a", "fail"), on_leak("b", "succeed"), one("c"), success_when="any", failure_when="any"
)
LED_ON = both(
    on_leak("a", "succeed"),
    Recursive(
        name="r",
        blocks=(
            Objective(name="b", activities=("b",), handlers=(Handler(event="leak", goto="d"),)),
            one("d"),
        ),
    ),
    success_when="any",
)
INNER = Parallel(name="inner", blocks=(one("a"), one("b")), success_when="any")
NESTED = both(Recursive(name="r", blocks=(INNER, one("d"))), one("c"), success_when="any")
ABORTS = both(on_leak("a", "succeed"), on_leak("b", "abort"), one("c"), success_when="any", abort="g")
FAILS_TWO = both(
    one("a"), *(Objective(name=n, activities=(n,), mandatory=False) for n in "bc"), failure_when="2"
)
FAILS_ONE = both(one("a"), Objective(name="b", activities=("b",), mandatory=False), failure_when="1")
SECOND_FAILS = both(
    on_leak("a", "succeed"), on_leak("b", "fail"), one("c"), failure_when="2", impossible="fails"
)
DOOMED = both(*THREE, success_when="2", impossible="fails")
DOOMED_ALL = both(
    one("a"), Objective(name="b", activities=("b",), mandatory=False), one("c"), impossible="fails"
)
BOTH_COUNTS = both(
    on_leak("a", "fail"), on_leak("b", "fail"), on_leak("c", "succeed"), success_when="any", failure_when="2"
)
ALL_AT_ONCE = both(
    on_leak("a", "succeed"),
    *(replace(on_leak(n, "fail"), mandatory=False) for n in "bc"),
    failure_when="2",
)
ABORTS_INSIDE = both(
    on_leak("a", "fail"),
    Recursive(name="r", blocks=(Parallel(name="inner", blocks=(on_leak("b", "abort"), one("d"))),)),
    failure_when="any",
    abort="f",
)
"""One event fails ``a``, which ends the block at once, and aborts the inner block, and so the outer one."""
AGAIN = mission(ROBOT, Parallel(name="both", blocks=THREE, success_when="any", success="both"))


def decided_at_two_depths(**others: Any) -> Mission:
    """One event fails ``a``, and ends the inner block in success: early, or since all in it have ended."""
    rest = on_leak("d", "succeed") if not others else one("d")
    inner = Parallel(name="inner", blocks=(on_leak("b", "succeed"), rest), **others)
    branches = on_leak("a", "fail"), Recursive(name="r", blocks=(inner,))
    return both(*branches, success_when="any", failure_when="any")


BOTH_EARLY = decided_at_two_depths(success_when="any")


def beside_an_early_end(goto: str, leads: str, **others: Any) -> Mission:
    """One event ends ``a``, and fails an inner block at once, which leads somewhere."""
    inner = Parallel(name="inner", blocks=(on_leak("b", "fail"), one("d")), failure_when="any", failure=leads)
    return both(on_leak("a", goto), Recursive(name="r", blocks=(inner, one("e"))), **others)


ABORT_AFTER_SUCCESS = beside_an_early_end("succeed", "abort", success_when="any", abort="g")
ABORT_AFTER_FAILURE = beside_an_early_end("fail", "abort", failure_when="any", abort="f")
STOPPED_WITHIN = beside_an_early_end("succeed", "e", success_when="any")
"""The inner block leads to ``e``, which the outer one stops before it begins."""
DEEPEST = Parallel(name="deepest", blocks=(on_leak("b", "succeed"), one("d")), success_when="any")
DEEPER = Parallel(
    name="deeper", blocks=(Recursive(name="s", blocks=(DEEPEST,)), one("e")), success_when="any"
)
THREE_DEEP = both(
    on_leak("a", "fail"),
    Recursive(name="r", blocks=(DEEPER,)),
    success_when="any",
    failure_when="any",
)
INNER_OVER = decided_at_two_depths()
MISSIONS = {
    "both early": BOTH_EARLY,
    "abort after success": ABORT_AFTER_SUCCESS,
    "abort after failure": ABORT_AFTER_FAILURE,
    "stopped within": STOPPED_WITHIN,
    "three deep": THREE_DEEP,
    "inner over": INNER_OVER,
    "any": ANY,
    "two": TWO,
    "hasty": HASTY,
    "optional": OPTIONAL,
    "race": RACE,
    "at once": AT_ONCE,
    "led on": LED_ON,
    "nested": NESTED,
    "aborts": ABORTS,
    "aborts inside": ABORTS_INSIDE,
    "again": AGAIN,
    "two fail": FAILS_TWO,
    "one fails": FAILS_ONE,
    "a second fails": SECOND_FAILS,
    "doomed": DOOMED,
    "doomed with all": DOOMED_ALL,
    "both counts": BOTH_COUNTS,
    "all at once": ALL_AT_ONCE,
}


@pytest.mark.parametrize("name", MISSIONS)
def test_all_that_play_it_agree(name: str) -> None:
    verdict = Judge(MISSIONS[name]).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


OK: dict[str, Happening] = {name: (SUCCESS, name) for name in "abcdf"}
BAD: dict[str, Happening] = {name: (FAILURE, name) for name in "abcdf"}
LEAK = (DECLARED, "leak")


@pytest.mark.parametrize(
    ("of", "events", "running"),
    [
        (ANY, [OK["b"]], {"f"}),
        (ANY, [BAD["a"], BAD["b"]], {"c"}),
        (ANY, [BAD["a"], BAD["b"], BAD["c"]], {"g"}),
        (TWO, [OK["a"]], {"b", "c"}),
        (TWO, [OK["a"], BAD["c"], OK["b"]], {"f"}),
        (TWO, [BAD["a"], BAD["c"]], {"b"}),
        (TWO, [BAD["a"], BAD["c"], OK["b"]], {"g"}),
        (HASTY, [BAD["b"]], {"g"}),
        (HASTY, [OK["a"], OK["b"]], {"c"}),
        (OPTIONAL, [BAD["b"]], {"a", "c"}),
        (OPTIONAL, [BAD["b"], OK["a"], OK["c"]], {"f"}),
        (RACE, [BAD["b"]], {"g"}),
        (RACE, [OK["b"]], {"f"}),
        (AT_ONCE, [LEAK], {"f"}),
        (LED_ON, [LEAK], {"f"}),
        (NESTED, [OK["b"]], {"c", "d"}),
        (NESTED, [OK["b"], OK["d"]], {"f"}),
        (ABORTS, [LEAK], {"g"}),
        (ABORTS_INSIDE, [LEAK], {"f"}),
        (BOTH_EARLY, [LEAK], {"f"}),
        (ABORT_AFTER_SUCCESS, [LEAK], {"g"}),
        (ABORT_AFTER_FAILURE, [LEAK], {"f"}),
        (STOPPED_WITHIN, [LEAK], {"f"}),
        (THREE_DEEP, [LEAK], {"f"}),
        (INNER_OVER, [LEAK], {"f"}),
        (AGAIN, [OK["b"]], {"a", "b", "c"}),
        (FAILS_TWO, [BAD["b"]], {"a", "c"}),
        (FAILS_TWO, [BAD["b"], BAD["c"]], {"g"}),
        (FAILS_TWO, [BAD["a"], OK["c"]], {"b"}),
        (FAILS_TWO, [BAD["a"], BAD["c"]], {"g"}),
        (FAILS_TWO, [BAD["b"], OK["a"], BAD["c"]], {"f"}),  # all have ended, and every mandatory one well
        (FAILS_TWO, [BAD["b"], OK["a"], OK["c"]], {"f"}),
        (FAILS_ONE, [BAD["b"]], {"g"}),
        (FAILS_ONE, [OK["a"], BAD["b"]], {"f"}),
        (FAILS_ONE, [OK["b"], BAD["a"]], {"g"}),
        (SECOND_FAILS, [LEAK], {"g"}),
        (DOOMED, [BAD["a"]], {"b", "c"}),
        (DOOMED, [BAD["a"], BAD["c"]], {"g"}),
        (DOOMED, [BAD["a"], OK["c"], OK["b"]], {"f"}),
        (DOOMED_ALL, [BAD["b"]], {"a", "c"}),
        (DOOMED_ALL, [BAD["c"]], {"g"}),
        (BOTH_COUNTS, [LEAK], {"f"}),
        (ALL_AT_ONCE, [LEAK], {"f"}),
    ],
)
def test_what_an_early_end_leads_to(of: Mission, events: list[Happening], running: set[str]) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running


def test_too_many_ways_to_succeed_are_an_error() -> None:
    names = [f"a{i}" for i in range(20)]
    of = robot((), *(activity(name, ()) for name in names))
    block = Parallel(name="wide", blocks=tuple(one(name) for name in names), success_when="10")
    with pytest.raises(LimitError, match="parallel block wide: 184756 ways in which 10 branches succeed"):
        compose(mission(of, block))
