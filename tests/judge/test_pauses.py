"""Blocks that pause: hand-written missions, what each comes to, and all that play them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Block, Each, Handler, Mission, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.writer import written
from mcpn.report.pictures.boxes import boxes
from mcpn.testing.judge.interpreter import DECLARED, Happening, Interpreter
from tests.commands import mcpn
from tests.draws import fewer
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN
from tests.judge.test_interpreter import play
from tests.judge.test_recovery import bad, ok
from tests.small import activity, mission, robot

RAIN: Happening = (DECLARED, "rain")
WIND: Happening = (DECLARED, "wind")
FOG: Happening = (DECLARED, "fog")
OUTSIDE = robot((), *(activity(name, ()) for name in "abcdef"), events=("rain", "wind", "fog"))


def one(name: str, runs: str = "", **routes: str) -> Objective:
    """An objective with one activity, that of its name by default."""
    return Objective(name=name, activities=(runs or name,), **routes)  # type: ignore[arg-type]


def pauses(by: str, on: str = "rain", *, once: bool = False) -> Handler:
    return Handler(event=on, pause=by, once=once)


def row(name: str, *blocks: Block, by: str = "s", on: str = "rain", **of: str) -> Recursive:
    """Blocks one after the other that pause."""
    return Recursive(name=name, blocks=blocks, handlers=(pauses(by, on),), **of)  # type: ignore[arg-type]


PLAIN = mission(OUTSIDE, row("r", one("a"), one("b"), failure="e"), one("s", "c"), one("d"), one("e"))
TRIES = mission(OUTSIDE, row("r", Objective(name="a", activities=("a",), retries=1)), one("s", "c"))
NESTED = mission(
    OUTSIDE,
    row("out", row("r", one("a"), one("b")), one("s", "c"), one("f"), by="t", on="wind", failure="e"),
    one("t", "d"),
    one("e"),
)
LONG = mission(
    OUTSIDE,
    row("r", one("a"), one("b")),
    Recursive(
        name="s",
        blocks=(one("c"), one("d", failure="abort")),
        abort="e",
        handlers=(Handler(event="rain", goto="f"),),
    ),
    one("e"),
    one("f", success="succeed"),
)
ONCE = mission(
    OUTSIDE,
    Recursive(
        name="r",
        blocks=(
            Recursive(name="q", blocks=(one("a"), one("b")), handlers=(pauses("s", once=True),)),
            one("s", "c"),
        ),
        handlers=(Handler(event="rain", goto="fail"),),
    ),
)
VALUES = mission(OUTSIDE, Each(name="v", values=("x", "y"), blocks=(row("r", one("a")), one("s", "c"))))
USED = Mission(
    name="m",
    robots=(OUTSIDE,),
    protocols=(Protocol(name="p", blocks=(row("r", one("a")), one("s", "c"))),),
    blocks=(
        Parallel(name="both", blocks=(Use(name="u", protocol="p"), one("b", "b"))),
        row("q", Objective(name="d", activities=("d",))),
        one("s", "e"),
    ),
)
BRANCHES = mission(
    OUTSIDE,
    Parallel(
        name="p",
        blocks=(Recursive(name="x", blocks=(one("a"), one("b"))), one("c")),
        handlers=(pauses("s"),),
        failure="e",
    ),
    one("s", "d"),
    one("f"),
    one("e"),
)
"""A parallel block that pauses."""
INSIDE = mission(
    OUTSIDE,
    row(
        "out",
        row("r", one("k", "e"), Parallel(name="p", blocks=(one("a"), one("b")))),
        one("s", "c"),
        by="t",
        on="wind",
        failure="e",
    ),
    one("t", "d"),
    one("e", "f"),
)
"""Pauses in a pause: a parallel block, and what shelters it, are stopped by what is around both."""
DEEP = mission(
    OUTSIDE,
    Parallel(
        name="p",
        blocks=(
            Recursive(
                name="x",
                blocks=(
                    Parallel(name="q", blocks=(one("a"), one("b")), handlers=(pauses("u", "wind"),)),
                    one("u", "d"),
                ),
            ),
            one("c"),
        ),
        handlers=(pauses("s"),),
    ),
    one("s", "e"),
)
"""A parallel block that pauses in a branch of one that does."""
LOOSE = mission(
    OUTSIDE,
    Parallel(
        name="p",
        blocks=(one("a"), one("b"), one("c")),
        success_when="2",
        failure_when="any",
        handlers=(pauses("s"), Handler(event="wind", goto="e")),
        failure="p",
        retries=1,
    ),
    Recursive(
        name="s",
        blocks=(
            Parallel(
                name="z", blocks=(one("d"), one("k", "e")), handlers=(Handler(event="wind", goto="abort"),)
            ),
        ),
        handlers=(Handler(event="rain", goto="e", once=True),),
    ),
    one("e", "f", success="succeed"),
)
"""Ends that are decided early, tries, a route back, and a parallel block in what is run meanwhile."""
WITHIN = mission(
    OUTSIDE,
    Parallel(name="p", blocks=(one("a"), one("b")), handlers=(pauses("s"),)),
    Recursive(
        name="s",
        blocks=(
            Recursive(
                name="x",
                blocks=(
                    Parallel(name="q", blocks=(one("c"), one("d")), handlers=(pauses("u", "wind"),)),
                    one("u", "e"),
                ),
                handlers=(Handler(event="fog", goto="succeed"),),
            ),
            one("v", "f"),
        ),
    ),
)
"""A parallel block that pauses in what runs while another one does, and is left for the end of that pause."""
ALL_AGAIN = {"p_try1.a", "p_try1.b", "p_try1.c"}
HOLDING = (BRANCHES, INSIDE, DEEP, LOOSE, WITHIN)
"""Blocks that pause and hold branches."""
MISSIONS = (PLAIN, TRIES, NESTED, LONG, ONCE, VALUES, USED, *HOLDING)


@pytest.mark.parametrize("of", MISSIONS)
def test_all_that_play_it_agree(of: Mission) -> None:
    verdict = Judge(of).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


@pytest.mark.parametrize(
    ("of", "events", "running"),
    [
        (PLAIN, [RAIN], {"s_at_a"}),
        (PLAIN, [RAIN, *ok("s_at_a")], {"a"}),
        (PLAIN, [RAIN, *ok("s_at_a"), RAIN], {"s_at_a"}),
        (PLAIN, [*ok("a"), RAIN, *ok("s_at_b")], {"b"}),
        (PLAIN, [*ok("a"), RAIN, *ok("s_at_b", "b")], {"d"}),
        (PLAIN, [RAIN, bad("s_at_a")], {"e"}),
        (TRIES, [bad("a_try1"), RAIN, *ok("s_at_a_try2")], {"a_try2"}),
        (NESTED, [RAIN], {"s_at_a"}),
        (NESTED, [RAIN, WIND], {"t_at_s_at_a"}),
        (NESTED, [RAIN, WIND, *ok("t_at_s_at_a")], {"s_at_a"}),
        (NESTED, [RAIN, WIND, *ok("t_at_s_at_a", "s_at_a")], {"a"}),
        (NESTED, [*ok("a"), WIND, *ok("t_at_b"), RAIN, *ok("s_at_b")], {"b"}),
        (NESTED, [*ok("a", "b"), WIND], {"t_at_f"}),
        (NESTED, [RAIN, WIND, bad("t_at_s_at_a")], {"e"}),
        (LONG, [*ok("a"), RAIN, *ok("s_at_b.c", "s_at_b.d")], {"b"}),
        (LONG, [RAIN, *ok("s_at_a.c"), bad("s_at_a.d")], {"e"}),
        (LONG, [RAIN, RAIN], {"f"}),
        (VALUES, [*ok("r_x.a"), RAIN], {"s_y_at_r_y_a"}),
        (VALUES, [*ok("r_x.a"), RAIN, *ok("s_y_at_r_y_a")], {"r_y.a"}),
        (USED, [RAIN, *ok("u.s_at_a")], {"u.a", "b"}),
        (USED, [RAIN, *ok("b")], {"u.s_at_a"}),
        (BRANCHES, [RAIN], {"s_at_p"}),
        (BRANCHES, [RAIN, *ok("s_at_p")], {"a", "c"}),
        (BRANCHES, [*ok("a", "c"), RAIN, *ok("s_at_p")], {"b"}),
        (BRANCHES, [*ok("a", "c"), RAIN, *ok("s_at_p"), RAIN, *ok("s_at_p", "b")], {"f"}),
        (BRANCHES, [bad("c"), RAIN, *ok("s_at_p", "a", "b")], {"e"}),
        (BRANCHES, [*ok("a"), RAIN, bad("s_at_p")], {"e"}),
        (INSIDE, [RAIN, *ok("s_at_k")], {"k"}),
        (INSIDE, [*ok("k", "a"), RAIN], {"s_at_p"}),
        (INSIDE, [*ok("k", "a"), RAIN, WIND], {"t_at_p"}),
        (INSIDE, [*ok("k", "a"), RAIN, WIND, *ok("t_at_p")], {"s_at_p"}),
        (INSIDE, [*ok("k", "a"), RAIN, WIND, *ok("t_at_p", "s_at_p")], {"b"}),
        (INSIDE, [*ok("k", "a"), RAIN, WIND, bad("t_at_p")], {"e"}),
        (INSIDE, [*ok("k", "b"), WIND, *ok("t_at_p")], {"a"}),
        (DEEP, [WIND], {"u_at_q", "c"}),
        (DEEP, [*ok("a"), WIND, RAIN], {"s_at_p"}),
        (DEEP, [*ok("a"), WIND, RAIN, *ok("s_at_p")], {"u_at_q", "c"}),
        (DEEP, [*ok("a"), WIND, RAIN, *ok("s_at_p", "u_at_q")], {"b", "c"}),
        (DEEP, [*ok("a"), WIND, RAIN, *ok("s_at_p", "c", "u_at_q")], {"b"}),
        (LOOSE, [*ok("p_try1.b"), RAIN], {"s_at_p_try1.d", "s_at_p_try1.k"}),
        (LOOSE, [*ok("p_try1.b"), RAIN, *ok("s_at_p_try1.d", "s_at_p_try1.k")], {"p_try1.a", "p_try1.c"}),
        (LOOSE, [*ok("p_try1.b"), RAIN, bad("s_at_p_try1.d"), bad("s_at_p_try1.k")], ALL_AGAIN),
        (LOOSE, [*ok("p_try1.b"), RAIN, RAIN], {"e"}),
        (WITHIN, [*ok("a"), RAIN, WIND], {"s_at_p.u_at_q"}),
        (WITHIN, [*ok("a"), RAIN, FOG], {"b"}),
        (WITHIN, [*ok("a"), RAIN, WIND, FOG], {"b"}),
        (WITHIN, [*ok("a"), RAIN, *ok("s_at_p.c"), WIND, *ok("s_at_p.u_at_q")], {"s_at_p.d"}),
    ],
)
def test_what_an_event_leads_to(of: Mission, events: list[Happening], running: set[str]) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running


@pytest.mark.parametrize("of", HOLDING)
def test_branches_that_have_ended_stay_ended(of: Mission) -> None:
    judge = Interpreter(of)
    found, stack, paused = {judge.initial}, [judge.initial], 0
    while stack:
        state = stack.pop()
        for happening in judge.possible(state):
            after = judge.after(state, happening)
            paused += bool(after.paused and after.ended)
            stack += [after] if after not in found else []
            found.add(after)
    assert paused, "some branch has ended while its block pauses"


@st.composite
def pauses_within_pauses(draw: st.DrawFn) -> Mission:
    """A block that pauses in what runs while another one does; each may be left for anywhere around."""
    ends = [None, "succeed", "fail", "abort"]

    def led(*siblings: str) -> str | None:
        return draw(st.sampled_from([*ends, *siblings]))

    def left(on: str, *siblings: str) -> tuple[Handler, ...]:
        to = led(*siblings)
        return (Handler(event=on, goto=to, once=draw(st.booleans())),) if to else ()

    def leaf(name: str, *siblings: str) -> Objective:
        to, late = led(*siblings), led(*siblings)
        return Objective(name=name, activities=(name,), success=to, failure=late)

    within, around = draw(st.permutations(["rain", "wind"]))
    branches = Objective(name="a", activities=("a",)), Objective(name="b", activities=("b",))
    inner = Parallel(name="q", blocks=branches, handlers=(pauses("c", within), *left("fog", "c")))
    inside: tuple[Block, ...] = (inner, leaf("c", "q"))
    if draw(st.booleans()):
        inside = (Recursive(name="x", blocks=inside, handlers=left("fog", "d")), leaf("d", "x"))
    on = draw(st.sampled_from(["fog", around]))
    by = Recursive(name="s", blocks=inside, failure=led("f"), handlers=left(on, "f"))
    branches = Objective(name="e", activities=("e",)), Objective(name="g", activities=("f",))
    outer = Parallel(name="p", blocks=branches, handlers=(pauses("s", around), *left("fog", "f")))
    return mission(OUTSIDE, outer, by, leaf("f", "p"))


@fewer(0.25)
@given(pauses_within_pauses())
def test_pauses_within_pauses_are_played_alike(of: Mission) -> None:
    assert Judge(of).judge().kind == "agree"


def test_a_pause_that_happens_once() -> None:
    judge = Interpreter(ONCE)
    _, state = play(judge, BEGIN, RAIN, *ok("s_at_a", "a"))
    assert state.running == {"b"}
    _, state = play(judge, BEGIN, RAIN, *ok("s_at_a"), RAIN)
    assert state.outcome == "failure"


def test_a_sibling_that_is_only_run_in_pauses_is_no_warning() -> None:
    assert [s.name for s in flatten(PLAIN).sections] == ["a", "b", "s_at_a", "s_at_b", "d", "e"]
    assert not [w.message for w in find_warnings(PLAIN) if "entered" in w.message or " s " in w.message]
    assert flatten(PLAIN).copies.held["r"] == ("a", "b")
    assert flatten(PLAIN).copies.held["s"] == ("s_at_a", "s_at_b")


@pytest.mark.parametrize("of", MISSIONS)
def test_each_copy_has_the_box_of_its_block(of: Mission) -> None:
    _, keys = boxes(of, flatten(of))
    named = {name: key for name, key in keys.items() if "_at_" not in name}
    pause_graphs = {name: key for name, key in keys.items() if name.startswith("s_at_") and "." not in name}
    assert len({*pause_graphs.values()}) <= 1
    assert {*pause_graphs.values()}.isdisjoint(named.values())


def test_copies_are_meant_by_the_name_of_the_sibling(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_bytes(written(PLAIN))
    both = "objective(s_at_a) | objective(s_at_b)"
    run = mcpn("ask", path, f"G (objective(s) <-> ({both}))", "EF objective(s_at_b)", "--json")
    assert [answer["holds"] for answer in json.loads(run.stdout)] == [True, True], run


def test_two_copies_of_one_name() -> None:
    use = Mission(
        name="m",
        robots=(OUTSIDE,),
        protocols=(Protocol(name="p", blocks=(one("a"),)),),
        blocks=(row("r", Use(name="u", protocol="p"), one("u_a", "b")), one("s", "c")),
    )
    with pytest.raises(InputError, match="two copies of s would be called s_at_u_a"):
        compose(use)
