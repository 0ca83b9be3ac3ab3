"""The judge, which draws no net, gives the same before and after each pass."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.mission.model import Each, EntryGuard, FactRoute, Handler, Mission, Recursive, walk
from mcpn.mission.passes import PASSES, core
from mcpn.mission.passes.pauses import runs_for
from mcpn.mission.robot import Activity
from mcpn.testing.elements import (
    COMMON_CAUSES,
    CRASHING,
    EARLY,
    GUARDED,
    IN_ROUNDS,
    IN_TIME,
    INTERRUPTED,
    LED,
    LEFT_BY_FACTS,
    NAMED,
    PAUSING,
    PAUSING_IN_TIME,
    RECOVERING,
    TIMED,
)
from mcpn.testing.judge.interpreter import Happening, Interpreter, State, Undetermined
from tests.draws import fewer
from tests.judge.test_early import ANY, DOOMED, DOOMED_ALL, FAILS_ONE, FAILS_TWO, RACE, SECOND_FAILS
from tests.judge.test_guards import DOORS, ROBOT, go
from tests.judge.test_pauses import MISSIONS as PAUSE
from tests.judge.test_pauses import pauses_within_pauses
from tests.judge.test_reasons import ANOTHER_WAY, OUTER, PLAIN, TRIES
from tests.small import mission

MOST_STATES = 40
WRITTEN_OUT = st.one_of(
    IN_ROUNDS,
    IN_TIME,
    TIMED,
    LED,
    LEFT_BY_FACTS,
    NAMED,
    GUARDED,
    INTERRUPTED,
    RECOVERING,
    PAUSING,
    PAUSING_IN_TIME,
    EARLY,
    COMMON_CAUSES,
    CRASHING,
)


def whole_names_copied(of: Mission) -> bool:
    """Whether blocks have copies still that hold names written out: the page says no names of such copies."""
    every = [*walk(of.blocks)]
    helpers = {block.recover for block in every} | {h.pause for block in every for h in block.handlers}
    helpers -= {runs_for(block) for block in every if block.resumes}
    copied = [
        b
        for b in every
        if isinstance(b, Each) or b.retries or b.repeat is not None or b.recover or b.name in helpers
    ]
    whole = any(block.name != block.own for block in copied)
    return whole or any(inner.copy or inner.own != inner.written for inner in walk(tuple(copied)))


def after(interpreter: Interpreter, state: State, happening: Happening) -> State | None:
    try:
        return interpreter.after(state, happening)
    except Undetermined:
        return None


def alike(one: Interpreter, other: Interpreter) -> int:
    """Holds one interpreter against another, over the first stable states; how many of them there were."""
    first = one.initial, other.initial
    known, stack = {first}, [first]
    while stack:
        here, there = stack.pop()
        assert one.seen(here) == other.seen(there)
        possible = one.possible(here)
        assert possible == other.possible(there)
        for happening in sorted(possible):
            ways = after(one, here, happening), after(other, there, happening)
            assert (ways[0] is None) == (ways[1] is None), happening
            if ways[0] is not None and ways[1] is not None and len(known) < MOST_STATES:
                pair = ways[0], ways[1]
                stack += [pair] if pair not in known else []
                known.add(pair)
    return len(known)


@fewer(0.4)
@given(WRITTEN_OUT)
def test_the_judge_gives_the_same_before_and_after_each_pass(of: Mission) -> None:
    judge, last = Interpreter(of), of
    for rewrite in PASSES:
        rewritten = core(of, until=rewrite.__name__)
        changed = rewritten.blocks != last.blocks or rewritten.robots != last.robots
        if changed and not whole_names_copied(rewritten):
            alike(judge, Interpreter(rewritten))
        last = rewritten


@fewer(0.2)
@given(COMMON_CAUSES)
def test_the_judge_gives_the_same_before_and_after_common_causes_are_hardware(of: Mission) -> None:
    assume(of.faults)
    rewritten = core(of, until="faults")
    assert not rewritten.faults
    written = core(of, until="parameters")
    assume(not whole_names_copied(written))
    assert alike(Interpreter(written), Interpreter(rewritten)) > 1


@fewer(0.2)
@given(CRASHING)
def test_the_judge_gives_the_same_before_and_after_crashes_are_resources(of: Mission) -> None:
    written = core(of, until="faults")
    assume(not whole_names_copied(written))
    rewritten = core(of, until="crashes")
    assume(rewritten.crashes)
    assert not any(a.faulty or any(way.faulty for way in a.alternatives) for a in rewritten.activities)
    assert alike(Interpreter(written), Interpreter(rewritten)) > 1


def test_the_judge_gives_the_same_before_and_after_reasons_stand_on_objectives() -> None:
    for each in (PLAIN, TRIES, OUTER, ANOTHER_WAY):
        of = replace(each.robots[0], activities=tuple(map(lost, each.robots[0].activities)))
        written = core(replace(each, robots=(of,)), until="parameters")
        rewritten = core(written, until="reasons")
        assert rewritten.blocks != written.blocks
        assert not any(activity.failures for activity in rewritten.activities)
        assert alike(Interpreter(written), Interpreter(rewritten)) > 3


def lost(activity: Activity) -> Activity:
    return replace(activity, failures=("lost", "cold")) if activity.name == "a" else activity


def test_the_judge_gives_the_same_before_and_after_routes_for_reasons_are_on_all_that_they_leave() -> None:
    for of in (TRIES, OUTER, ANOTHER_WAY):
        written = core(of, until="pauses")
        rewritten = core(written, until="named_failures")
        assert rewritten.blocks != written.blocks
        assert alike(Interpreter(written), Interpreter(rewritten)) > 3


def test_the_judge_gives_the_same_before_and_after_what_is_done_is_a_fact() -> None:
    """Whichever round has done it, and whether it is asked for by a route, a guard or ``<on when>``."""
    again = FactRoute(when=("!done(x)",), goto="w", on="failure"), FactRoute(when=("done(v)",), goto="fail")
    within = Recursive(name="w", blocks=(go("x", failure="succeed"), go("v")), repeat=2, routes=again)
    left = go("l", handlers=(Handler(when=("done(v)",), goto="b"),), success="w")
    of = mission(ROBOT, left, within, go("b", EntryGuard(when=("done(l)",), otherwise="fail")))
    rewritten = core(of, until="done")
    assert [fact.name for fact in rewritten.every_fact][-3:] == ["done(v)", "done(x)", "done(l)"]
    assert alike(Interpreter(of), Interpreter(rewritten)) > 10
    assert alike(Interpreter(of), Interpreter(core(rewritten, until="successors"))) > 10


def test_the_judge_gives_the_same_before_and_after_early_ends_are_counted() -> None:
    for each in (ANY, RACE, FAILS_TWO, FAILS_ONE, SECOND_FAILS, DOOMED, DOOMED_ALL):
        assert alike(Interpreter(each), Interpreter(core(each, until="early_ends"))) > 1


def test_the_judge_gives_the_same_before_and_after_guards_are_written_out() -> None:
    """They are asked after all outcomes, abort and time among them, on an event, and as facts become so."""
    hold = EntryGuard(when=("held",), otherwise="d"), EntryGuard(when=("door=open",), otherwise="fail")
    leaves = Handler(event="call", goto="b"), Handler(when=("door=ajar",), goto="b")
    within = Recursive(name="w", blocks=(go("x", failure="abort"),), abort="b", success="b")
    timed = go("t", timeout=5.0, timeout_goto="b", success="succeed", failure="w")
    of = mission(
        ROBOT, go("a", handlers=leaves, failure="b", success="t"), timed, within, go("b", *hold), go("d")
    )
    for each in (of, DOORS):
        rewritten = core(each, until="guards")
        assert not [block for block in walk(rewritten.blocks) if block.guards]
        assert alike(Interpreter(each), Interpreter(rewritten)) > 10


def same_with_pauses_written_out(of: Mission) -> int:
    rewritten = core(of, until="pauses")
    left = [block for block in walk(rewritten.blocks) if block.resumes]
    assert left
    assert {h.pause for block in walk(rewritten.blocks) for h in block.handlers if h.pause} >= {
        *map(runs_for, left)
    }
    return alike(Interpreter(of), Interpreter(rewritten))


def test_the_judge_gives_the_same_before_and_after_pauses_are_written_out() -> None:
    for each in PAUSE:
        assert same_with_pauses_written_out(each) > 3


@fewer(0.1)
@given(pauses_within_pauses())
def test_the_judge_gives_the_same_before_and_after_pauses_in_pauses_are_written_out(of: Mission) -> None:
    assert same_with_pauses_written_out(of) > 3
