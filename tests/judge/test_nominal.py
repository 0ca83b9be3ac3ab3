"""What a mission does while nothing fails: every engine against the interpreter, all orders of successes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.model import Block, FactRoute, Handler, Mission, Objective, Recursive
from mcpn.mission.robot import Fact, Hardware
from mcpn.spaces.engine_names import Engine
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import Undetermined
from tests.draws import fewer
from tests.judge.nominal import WhileNothingFails, cut_short, played, said
from tests.small import activity, mission, robot

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def judged(of: Mission) -> str:
    """All engines say what the interpreter finds; how that is."""
    try:
        found = played(of)
    except Undetermined:
        return "undetermined"
    if found is None:
        return "too large"
    for engine in ENGINES:
        try:
            checked = check(compose(of), engine=engine)
        except LimitError:
            return "too large"
        if not (checked.verdicts["safe"].holds and checked.verdicts["confluent"].holds):
            return "not confluent"
        agrees(engine, checked.verdicts["nominal_success"], found)
    words = ("dead end" * bool(found.ends), "goes on" * found.circles, "left out" * bool(found.left_out))
    return ", ".join(filter(None, words)) or "succeeds"


def agrees(engine: str, verdict: Any, found: WhileNothingFails) -> None:
    assert verdict.holds is found.holds, (engine, verdict, found)
    assert {*verdict.left_out} == found.left_out, (engine, verdict, found)
    assert (verdict.cycle is not None) is (found.circles and not found.ends), (engine, verdict, found)
    for run in verdict.runs:
        assert not [e for e in run.events if e.what.name not in ("START", "SUCCESS", "REPAIRED")]


@given(said(st.one_of(drawn.ANY, drawn.EARLY, drawn.APART, drawn.SHARING, drawn.IN_ROUNDS)))
def test_drawn_missions(of: Mission) -> None:
    event(judged(of))


@given(said(st.one_of(drawn.INTERRUPTED, drawn.ABORTED, drawn.TIMED, drawn.LASTING, drawn.CRASHING)))
def test_missions_with_events_aborts_timeouts_and_what_is_out_at_first(of: Mission) -> None:
    event(judged(of))


@given(said(st.one_of(drawn.RECOVERING, drawn.PAUSING, drawn.LED, drawn.PAUSING_APART)))
def test_missions_with_blocks_that_are_run_for_others(of: Mission) -> None:
    event(judged(of))


@fewer(0.5)
@given(said(st.one_of(drawn.WORLD, drawn.WORLD_ABORTED, drawn.PAUSING_FACTS)))
def test_missions_with_facts(of: Mission) -> None:
    event(judged(of))


WHOLES = (drawn.IN_TIME, drawn.PAUSING_IN_TIME, drawn.LEFT_BY_FACTS, drawn.LEFT_BY_FACTS_APART)


@fewer(0.25)
@given(said(st.one_of(*WHOLES, drawn.NAMED, drawn.GUARDED, drawn.MIXED_APART)))
def test_missions_with_blocks_that_are_stopped_as_a_whole(of: Mission) -> None:
    event(judged(of))


@fewer(0.5)
@given(said(cut_short(st.one_of(*WHOLES, drawn.NAMED, drawn.MIXED_APART, drawn.PAUSING, drawn.EARLY))))
def test_missions_of_which_some_routes_end_all_around_them(of: Mission) -> None:
    event(judged(of))


def one(name: str, **others: Any) -> Objective:
    return Objective(name=name, activities=("do",), **others)


def of(*blocks: Block, hardware: tuple[Hardware, ...] = (Hardware(name="h"),), **others: Any) -> Mission:
    do = replace(activity("do", ("h",)), requires=others.pop("requires", ()))
    own = robot(hardware, do, events=("rain",))
    own = replace(own, facts=(Fact(name="dry"),)) if others.pop("facts", False) else own
    return mission(own, *blocks, **others)


def twice(*handlers: Handler) -> Mission:
    """Two tries of a block in which every end leads to its success."""
    calm = Recursive(name="calm", blocks=(one("a", failure="succeed"),), handlers=handlers)
    return of(Recursive(name="rows", retries=1, blocks=(calm,)), facts=True)


def ended_by_fact(goto: str) -> Handler:
    return Handler(when=("dry",), goto=goto)


MEANT: dict[str, tuple[Mission, str]] = {
    "a helper behind the last block": (of(one("dig", failure="move"), one("move", success="dig")), "goes on"),
    "its success ends all": (
        of(one("dig", failure="move", success="succeed"), one("move", success="dig")),
        "succeeds",
    ),
    "an end of success that is an abort": (of(one("dig", success="abort")), "dead end"),
    "a block that no route leads to": (of(one("a", success="succeed"), one("b")), "left out"),
    "a block that no route leads to, and in it what no route in it leads to": (
        of(
            one("a", success="succeed"),
            Recursive(
                name="rows",
                timeout=9.0,
                blocks=(one("first", success="fail", failure="first"), one("then", failure="abort")),
            ),
        ),
        "left out",
    ),
    "a try of what cannot fail": (twice(), "left out"),
    "a try of what cannot fail, and which a fact may end": (twice(ended_by_fact("succeed")), "left out"),
    "a try of what a fact may let fail": (twice(ended_by_fact("fail")), "succeeds"),
    "left out on purpose": (of(one("a", success="succeed"), one("b", nominal="optional")), "succeeds"),
    "a block with a time, which is left by a failure that is meant": (
        of(
            Recursive(
                name="search",
                blocks=(one("a", success="fail"),),
                failure="succeed",
                handlers=(Handler(event="rain", goto="b"),),
                timeout=9.0,
            ),
            one("b"),
        ),
        "succeeds",
    ),
    "a patrol": (of(one("a", success="b"), one("b", success="a")), "goes on"),
    "a patrol that is meant": (
        of(one("a", success="b"), one("b", success="a", nominal="endless")),
        "succeeds",
    ),
    "a patrol, and a loop beside": (
        of(
            one("a", success="b"),
            Recursive(name="b", nominal="endless", blocks=(one("x"),), success="c"),
            one("c", success="c"),
        ),
        "goes on",
    ),
    "what is out of service at first": (
        of(one("a"), hardware=(Hardware(name="h", initial="oos"),)),
        "succeeds",
    ),
    "what a fact forbids": (of(one("a"), requires=("dry",), facts=True), "dead end"),
    "a shelter": (
        of(
            Recursive(
                name="rows",
                handlers=(Handler(event="rain", pause="cover"),),
                blocks=(one("row"),),
                success="succeed",
            ),
            one("cover"),
        ),
        "succeeds",
    ),
    "a shelter that leads back to what no route leads to": (
        of(
            Recursive(
                name="rows",
                handlers=(Handler(event="rain", pause="cover"),),
                blocks=(one("row", success="succeed"), one("other")),
                success="succeed",
            ),
            one("cover"),
        ),
        "left out",
    ),
    "an event that is always handled inside": (
        of(
            Recursive(
                name="rows",
                blocks=(
                    Recursive(
                        name="again",
                        success="succeed",
                        failure="abort",
                        handlers=(Handler(event="rain", goto="succeed"),),  # never, for row handles it
                        blocks=(
                            one(
                                "row",
                                success="row",
                                failure="abort",
                                handlers=(Handler(event="rain", goto="row"),),
                            ),
                        ),
                    ),
                ),
            ),
            one("b"),
        ),
        "goes on, left out",
    ),
    "what facts choose": (
        of(
            one("a", routes=(FactRoute(when=("dry",), goto="b"),), success="succeed"),
            one("b"),
            facts=True,
        ),
        "succeeds",
    ),
}


@pytest.mark.parametrize("name", MEANT)
def test_what_is_meant(name: str) -> None:
    found, expected = MEANT[name]
    assert judged(found) == expected


def test_what_is_left_out_and_what_goes_round_is_named() -> None:
    left = check(compose(MEANT["a block that no route leads to"][0])).verdicts["nominal_success"]
    assert left.left_out == ("b",)
    assert 'never enters b; where that is meant, write nominal="optional"' in left.explanation
    loop = check(compose(MEANT["a helper behind the last block"][0])).verdicts["nominal_success"]
    assert "goes on for ever: dig, move, and so on" in loop.explanation
    assert (list(map(str, loop.runs[0].events)), loop.cycle) == (
        ["MISSION_EV_START", "OBJ_dig_EV_OK", "OBJ_move_EV_OK"],
        1,
    )
