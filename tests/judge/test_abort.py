"""Missions that abort: hand-written ones, each with what it comes to, and all that play them in lockstep."""

from __future__ import annotations

import pytest

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Block, Each, Handler, Mission, Objective, Parallel, Recursive
from mcpn.spaces.engine_names import SPACE_ENGINES
from mcpn.testing.judge.interpreter import DECLARED, FAILURE, START, SUCCESS, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_interpreter import play
from tests.small import activity, hw, mission, robot

BEGIN = (START, "")
ROBOT = robot(
    hw("h", "g"),
    *(activity(name, ("h",)) if name == "a" else activity(name, ()) for name in "abcdefgz"),
    events=("leak", "call"),
)
ABORTS = (Handler(event="leak", goto="abort"),)


def one(name: str, **routes: str | None) -> Objective:
    """An objective with the activity of its name."""
    return Objective(name=name, activities=(name,), **routes)  # type: ignore[arg-type]


def both(*blocks: Block, abort: str | None = None, success: str | None = "succeed") -> Mission:
    """A parallel block, and an objective after it."""
    of = Parallel(name="both", blocks=blocks, abort=abort, success=success, failure="z")
    return mission(ROBOT, of, one("z"))


OUT = both(Recursive(name="r", blocks=(one("a", failure="abort"), one("b"))), one("c"))
ROUTED = both(Recursive(name="r", blocks=(one("a", failure="abort"), one("b"))), one("c"), abort="z")
INNER = Parallel(name="inner", blocks=(Recursive(name="q", blocks=(one("a", failure="abort"),)), one("b")))
NESTED = both(Recursive(name="r", blocks=(INNER, one("d"))), one("c"), abort="z")
CAUGHT = both(
    Recursive(
        name="r",
        blocks=(Parallel(name="inner", blocks=INNER.blocks, abort="d", success="succeed"), one("d")),
    ),
    one("c"),
)
AT_ONCE = both(
    Recursive(name="r", blocks=(one("a", success="succeed"), one("b"))),
    Recursive(name="s", blocks=(Objective(name="c", activities=("c",), handlers=ABORTS),)),
    Recursive(
        name="t",
        blocks=(
            Objective(name="d", activities=("d",), handlers=(Handler(event="leak", goto="e"),)),
            one("e"),
        ),
    ),
    abort="z",
)
WIDE = tuple(
    Recursive(name=f"r{n}", blocks=(Objective(name=n, activities=(n,), handlers=ABORTS if n < "d" else ()),))
    for n in "bcdefgz"
)
TWICE = mission(
    robot((), *(activity(name, ()) for name in "bcdefgz"), events=("leak",)),
    Parallel(name="both", blocks=WIDE, abort="both"),
)
TRIES = mission(
    ROBOT,
    Recursive(name="r", blocks=(one("a", failure="abort"),), retries=2, abort="b", success="succeed"),
    one("b", success="abort"),
)
VALUES = mission(
    ROBOT,
    Each(name="e", values=("x", "y"), blocks=(one("a", failure="abort"),), abort="b", success="succeed"),
    one("b"),
)
CHILD = both(Recursive(name="r", blocks=(one("a", failure="abort"),), abort="fail"), one("b"))
WAITING = both(
    Recursive(name="r", blocks=(one("a", failure="abort"), one("b"))),
    Recursive(name="s", blocks=(one("c"), Objective(name="d", activities=("a",)))),
    abort="z",
)
MISSIONS = {
    "out": OUT,
    "routed": ROUTED,
    "nested": NESTED,
    "caught inside": CAUGHT,
    "one event aborts here and leads on there": AT_ONCE,
    "two branches of a wide block abort into it": TWICE,
    "tries": TRIES,
    "values": VALUES,
    "a child": CHILD,
    "another branch waits": WAITING,
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (MISSIONS[name] is TWICE))  # has thousands of states
        for name in MISSIONS
    ],
)
def test_all_that_play_it_agree(name: str) -> None:
    verdict = Judge(MISSIONS[name]).judge()
    assert verdict.kind in ("agree", "undetermined" if name == "another branch waits" else "agree")
    assert "modular controller" in verdict.pairs


FAILS: dict[str, Happening] = {name: (FAILURE, name) for name in "abcd"}
LEAK = (DECLARED, "leak")


@pytest.mark.parametrize(
    ("of", "events", "running", "outcome"),
    [
        (OUT, [FAILS["a"]], set(), "abort"),
        (ROUTED, [FAILS["a"]], {"z"}, None),
        (NESTED, [FAILS["a"]], {"z"}, None),
        (CAUGHT, [FAILS["a"]], {"c", "d"}, None),
        (AT_ONCE, [LEAK], {"z"}, None),
        (AT_ONCE, [(SUCCESS, "c")], {"a", "d"}, None),
        (TWICE, [LEAK], set("bcdefgz"), None),
        (TRIES, [(FAILURE, "r_try1.a")], {"b"}, None),
        (VALUES, [(SUCCESS, "a_x"), (FAILURE, "a_y")], {"b"}, None),
        (CHILD, [FAILS["a"]], {"b"}, None),
        (CHILD, [FAILS["a"], (SUCCESS, "b")], {"z"}, None),
        (WAITING, [(SUCCESS, "c"), FAILS["a"]], {"z"}, None),
    ],
)
def test_what_an_abort_leads_to(
    of: Mission, events: list[Happening], running: set[str], outcome: str | None
) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert {*state.running, *state.pending} == running
    assert state.outcome == outcome


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_verdicts_of_a_mission_that_aborts(engine: str) -> None:
    blocks = (one("a", success="succeed", failure="abort"),)
    found = check(compose(mission(ROBOT, *blocks)), engine=engine)  # type: ignore[arg-type]
    safe = {"can_always_end_safely": True, "abort_reachable": True, "failure_reachable": False}
    assert {name: found.verdicts[name].holds for name in safe} == safe
    assert found.passed
    (run,) = found.verdicts["abort_reachable"].runs
    assert [str(event) for event in run.events] == ["MISSION_EV_START", "OBJ_a_EV_FAIL"]
    unsafe = mission(ROBOT, one("a", success="succeed", failure="b"), one("b", success="abort", failure="c"))
    lost = mission(ROBOT, *unsafe.blocks, one("c", success="fail"))
    found = check(compose(lost), engine=engine)  # type: ignore[arg-type]
    assert found.failing == ["can_always_end_safely"]
    assert found.verdicts["can_always_finish"].holds
    (run,) = found.verdicts["can_always_end_safely"].runs
    assert [str(event) for event in run.events][-1] == "OBJ_b_EV_FAIL"


def test_a_mission_without_abort_has_the_verdicts_that_it_had() -> None:
    found = check(compose(mission(ROBOT, one("a"))))
    assert "can_always_end_safely" not in found.verdicts
    assert "abort_reachable" not in found.verdicts
    assert compose(found.mission_net.mission).abort is None


def test_an_abort_that_no_route_reaches_is_none() -> None:
    blocks = (one("a", success="succeed"), one("b", failure="abort"))
    assert not flatten(mission(ROBOT, *blocks)).aborts
