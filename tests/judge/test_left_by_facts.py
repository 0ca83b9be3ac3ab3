"""Blocks that are left as facts become so: hand-written missions, what each comes to; what is wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import (
    Block,
    EntryGuard,
    FactRoute,
    Handler,
    Mission,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.robot import DeclaredEvent, Fact, FactChange
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.writer import save_mission
from mcpn.mission.xml import read_mission
from mcpn.testing.judge.interpreter import DECLARED, FAILURE, SUCCESS, TIMEOUT, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN
from tests.judge.test_interpreter import play
from tests.small import activity, hw, mission, robot

NAMES = "abcdefg"
ROBOT = replace(
    robot(hw("h"), *(activity(name, ("h",) if name == "b" else ()) for name in NAMES), events=("leak",)),
    facts=(Fact(name="low"), Fact(name="door", values=("closed", "open"))),
)
ROBOT = replace(
    ROBOT,
    events=(
        *ROBOT.events,
        DeclaredEvent(name="sinks", sets=(FactChange(fact="low", to="true"),)),
        DeclaredEvent(name="charged", sets=(FactChange(fact="low", to="false"),)),
        DeclaredEvent(
            name="both", sets=(FactChange(fact="low", to="true"), FactChange(fact="door", to="open"))
        ),
    ),
)
SINKS: Happening = (DECLARED, "sinks")
CHARGED: Happening = (DECLARED, "charged")
LEAK: Happening = (DECLARED, "leak")


def left(goto: str, *when: str) -> Handler:
    return Handler(when=when or ("low",), goto=goto)


def one(name: str, *handlers: Handler, lowers: str = "", **others: object) -> Objective:
    """An objective with the activity of its name, whose success, or failure, may make the fact true."""
    sets = (FactChange(fact="low", to="true", on=lowers),) if lowers else ()
    return Objective(name=name, activities=(name,), handlers=handlers, sets=sets, **others)  # type: ignore[arg-type]


def block(name: str, *blocks: Block, handlers: tuple[Handler, ...] = (), **others: object) -> Recursive:
    return Recursive(name=name, blocks=blocks, handlers=handlers, **others)  # type: ignore[arg-type]


def both(name: str, *blocks: Block, **others: object) -> Parallel:
    return Parallel(name=name, blocks=blocks, **others)  # type: ignore[arg-type]


END = one("g", failure="g")
OPENING = Objective(name="c", activities=("c",), sets=(FactChange(fact="door", to="open", on="start"),))
PLAIN = mission(ROBOT, one("a", left("g"), success="succeed"), END)
SERIES = mission(
    ROBOT, block("r", one("a"), one("b", lowers="success"), one("c"), handlers=(left("g"),), failure="d"),
    one("d", success="succeed"), END,
)  # fmt: skip
LAST = mission(
    ROBOT, block("r", one("a", lowers="success"), handlers=(left("g"),), success="d"),
    one("d", success="succeed"), END,
)  # fmt: skip
TRIES = mission(ROBOT, one("a", left("g"), lowers="failure", retries=2, success="succeed"), END)
BRANCHES = mission(
    ROBOT,
    both("p", block("r", one("a"), one("b"), handlers=(left("succeed"),)), one("c", lowers="success")),
    END,
)
FIRST_WINS = mission(
    ROBOT,
    both(
        "p", one("a", left("fail")), one("c", lowers="success"), success_when="any", success="g", failure="d"
    ),
    one("d", success="succeed"),
    END,
)  # fmt: skip


def side_by_side(first: Handler, second: Handler, *, last: Handler | None = None) -> Mission:
    """Branches that one fact leaves at the same moment; ``g`` after success, ``d`` after failure."""
    handlers = (first, second) if last is None else (first, second, last)
    branches = (one(name, handler) for name, handler in zip("abc", handlers, strict=False))
    return mission(
        ROBOT,
        both("p", *branches, success_when="any", failure_when="any", success="g", failure="d"),
        one("d", success="succeed"),
        END,
    )


ABORTS_BESIDE = side_by_side(left("succeed"), left("abort"))
FAILS_BESIDE = side_by_side(left("fail"), left("succeed"))
TWO_FACTS = side_by_side(left("succeed"), left("abort", "door=open"), last=left("fail"))
FIRST_THE_END = mission(
    ROBOT,
    both("p", one("a", left("abort")), one("c", lowers="success"), success_when="any", success="g"),
    END,
)
"""The success of ``c`` ends the block before the fact that it makes true leaves ``a``."""
AROUND = mission(
    ROBOT,
    block(
        "r",
        both("p", one("a", left("abort")), one("c", left("succeed")), success_when="any"),
        handlers=(left("g"),),
        success="succeed",
    ),
    END,
)
NESTED = mission(
    ROBOT,
    block(
        "r",
        block("s", one("a"), handlers=(left("c"),)),
        one("b"),
        one("c"),
        handlers=(left("fail", "door=open"), left("g")),
    ),
    one("d", success="succeed"),
    END,
)
GUARDED = mission(
    ROBOT,
    one("a", lowers="failure", failure="b"),
    one("b", left("c"), guards=(EntryGuard(when=("!low",), otherwise="d"),), success="a"),
    one("c", success="a"),
    one("d", success="a"),
)
TARGET = mission(
    ROBOT,
    one("a", left("b"), success="succeed"),
    replace(one("b", success="succeed"), guards=(EntryGuard(when=("door=open",), otherwise="g"),)),
    END,
)
AGAIN = mission(ROBOT, block("r", one("a"), one("b"), handlers=(left("r"),)))
HANDLED = mission(
    ROBOT,
    block("r", one("a"), handlers=(left("g"), Handler(event="leak", goto="d")), timeout=9, timeout_goto="d"),
    one("d", success="succeed"),
    END,
)
USED = replace(
    mission(ROBOT, Use(name="u", protocol="p", handlers=(left("g"),), success="succeed"), END),
    protocols=(Protocol(name="p", blocks=(one("a"), one("b", left("a", "door=open")))),),
)
DONE = mission(ROBOT, block("r", one("a"), one("b"), handlers=(left("g", "done(a)"),)), END)
DONE = replace(DONE, blocks=(replace(DONE.blocks[0], success="succeed"), END))
MISSIONS = {
    "plain": PLAIN,
    "series": SERIES,
    "last": LAST,
    "tries": TRIES,
    "branches": BRANCHES,
    "first wins": FIRST_WINS,
    "aborts beside": ABORTS_BESIDE,
    "fails beside": FAILS_BESIDE,
    "two facts": TWO_FACTS,
    "first the end": FIRST_THE_END,
    "around": AROUND,
    "nested": NESTED,
    "guarded": GUARDED,
    "target": TARGET,
    "again": AGAIN,
    "handled": HANDLED,
    "used": USED,
    "done": DONE,
}


@pytest.mark.parametrize("of", MISSIONS.values(), ids=MISSIONS)
def test_all_that_play_it_agree(of: Mission) -> None:
    verdict = Judge(of).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


@pytest.mark.parametrize(
    ("of", "events", "running", "outcome"),
    [
        (PLAIN, [SINKS], {"g"}, None),
        # What facts are as it is entered does not count, be it in the reaction that made them so.
        (GUARDED, [(SUCCESS, "a"), SINKS], {"c"}, None),
        (GUARDED, [(FAILURE, "a")], {"d"}, None),
        # What an objective in it sets leaves it, before the next one begins.
        (SERIES, [(SUCCESS, "a"), (SUCCESS, "b")], {"g"}, None),
        (SERIES, [(SUCCESS, "a"), SINKS], {"g"}, None),
        # Its own end at the same moment counts first.
        (LAST, [(SUCCESS, "a")], {"d"}, None),
        (TRIES, [(FAILURE, "a_try1")], {"g"}, None),
        (TRIES, [SINKS], {"g"}, None),
        (BRANCHES, [(SUCCESS, "a"), (SUCCESS, "c")], {"g"}, None),
        (BRANCHES, [(SUCCESS, "a"), SINKS], {"c"}, None),
        (FIRST_WINS, [(SUCCESS, "c")], {"g"}, None),
        (FIRST_WINS, [SINKS], {"c"}, None),
        (FIRST_WINS, [SINKS, (FAILURE, "c")], {"d"}, None),
        # All that facts leave side by side counts, whatever the order.
        (ABORTS_BESIDE, [SINKS], set(), "abort"),
        (FAILS_BESIDE, [SINKS], {"g"}, None),
        (TWO_FACTS, [SINKS], {"g"}, None),
        (TWO_FACTS, [(DECLARED, "both")], set(), "abort"),
        (FIRST_THE_END, [(SUCCESS, "c")], {"g"}, None),
        (AROUND, [SINKS], {"g"}, None),
        # The outermost block counts, then the first condition that fits.
        (NESTED, [SINKS], {"g"}, None),
        (NESTED, [(DECLARED, "both")], set(), "failure"),
        # Where it leads is guarded as ever.
        (TARGET, [SINKS], {"g"}, None),
        (TARGET, [(DECLARED, "both")], {"b"}, None),
        (AGAIN, [(SUCCESS, "a"), SINKS], {"a"}, None),
        (AGAIN, [SINKS, (SUCCESS, "a")], {"b"}, None),
        (HANDLED, [LEAK], {"d"}, None),
        (HANDLED, [(TIMEOUT, "r")], {"d"}, None),
        (HANDLED, [SINKS], {"g"}, None),
        (USED, [(SUCCESS, "u.a"), SINKS], {"g"}, None),
        (USED, [(SUCCESS, "u.a"), (DECLARED, "both")], {"g"}, None),
        (DONE, [(SUCCESS, "a")], {"g"}, None),
    ],
)
def test_what_it_leads_to(
    of: Mission, events: list[Happening], running: set[str], outcome: str | None
) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running
    assert state.outcome == outcome


def test_one_that_holds_as_it_is_entered_stays() -> None:
    of = mission(ROBOT, one("a", lowers="success"), one("b", left("g")), END)
    _, state = play(Interpreter(of), BEGIN, (SUCCESS, "a"))
    assert state.running == {"b"}
    _, state = play(Interpreter(of), BEGIN, (SUCCESS, "a"), CHARGED, SINKS)
    assert state.running == {"g"}
    assert Judge(of).judge().kind == "agree"


def test_other_missions_have_no_place_for_it() -> None:
    plain = mission(ROBOT, one("a"), END)
    assert not any("became" in place.name for place in compose(plain).net.places)
    assert any("became" in place.name for place in compose(PLAIN).net.places)
    assert len(list(flatten(SERIES).section("r").outcomes)) == 3


PAUSES = Handler(event="leak", pause="d")
WRONG: dict[str, tuple[Mission, str]] = {
    "nothing": (
        mission(ROBOT, one("a", Handler(goto="g")), END),
        "an <on> of a has neither event nor when; expected one of them",
    ),
    "both": (
        mission(ROBOT, one("a", Handler(event="leak", when=("low",), goto="g")), END),
        "an <on> of a has both event and when; expected one of them",
    ),
    "a pause": (
        mission(ROBOT, one("a", Handler(when=("low",), pause="g")), END),
        "<on when> of a has pause: as facts become so a block is left, by goto",
    ),
    "once": (
        mission(ROBOT, one("a", Handler(when=("low",), goto="g", once=True)), END),
        "<on when> of a has once: as facts become so a block is left, by goto",
    ),
    "nowhere": (mission(ROBOT, one("a", Handler(when=("low",))), END), "<on when> of a leads nowhere"),
    "elsewhere": (mission(ROBOT, one("a", left("x")), END), "<on when> of a leads to x; expected one of"),
    "from a branch": (
        mission(ROBOT, both("p", one("a", left("g")), one("b")), END),
        "<on when> of a leads to g; expected one of succeed, fail, abort",
    ),
    "an unknown fact": (
        mission(ROBOT, one("a", left("g", "high")), END),
        "<on when> of a asks for the fact high, which is not declared",
    ),
    "an unknown value": (
        mission(ROBOT, one("a", left("g", "door=ajar")), END),
        "<on when> of a asks for door=ajar: ajar, expected one of closed, open",
    ),
    "what cannot be": (
        mission(ROBOT, one("a", left("g", "low", "!low")), END),
        "<on when> of a asks for low=true and low=false at once",
    ),
    "the mission": (
        replace(PLAIN, handlers=(left("g"),)),
        "m is left when facts become so (on when), though it is the mission: put its blocks into an",
    ),
    "what recovers": (
        mission(ROBOT, one("a", left("g"), recover="d"), one("d"), END),
        "a is left when facts become so (on when), though it recovers by d: put it into an objective",
    ),
    "copies with a time": (
        mission(ROBOT, one("a", left("g"), retries=1, timeout=9, timeout_goto="g"), END),
        "though it has copies, each with a timeout_goto",
    ),
    "a reason": (
        mission(
            ROBOT,
            replace(
                block("r", one("a", failures=("stuck",)), handlers=(left("g"),)),
                routes=(FactRoute(on="failure", reason="stuck", goto="g"),),
            ),
            END,
        ),
        "a route of r names the reason stuck, though r has <on when>",
    ),
    "what is set at a start": (
        mission(ROBOT, one("a", left("g")), one("b", lowers="start"), END),
        "objective b sets low to true as it starts, and a is left when it becomes so (on when)",
    ),
    "what is set at a start in a branch": (
        mission(ROBOT, one("a", left("g")), both("p", one("b"), block("r", OPENING)), END),
        "objective c sets door to open as it starts in a branch of a <parallel>, and a is left by facts",
    ),
    "a handler of what changes facts": (
        mission(ROBOT, one("a", Handler(event="sinks", goto="g")), END),
        "the event sinks changes facts: it interrupts nothing by itself; handle what the facts become",
    ),
}


@pytest.mark.parametrize("of", WRONG)
def test_what_is_wrong_is_said(of: str) -> None:
    wrong, message = WRONG[of]
    with pytest.raises(InputError) as error:
        flatten(wrong)
    assert message in str(error.value)


@pytest.mark.parametrize(
    "of",
    [
        mission(ROBOT, one("a", left("g"), PAUSES), one("d"), END),
        mission(ROBOT, block("r", block("a", one("b"), handlers=(left("fail"),)), handlers=(PAUSES,)),
                one("d"), END),
        mission(ROBOT, block("r", both("p", one("a", left("fail")), one("b")), handlers=(PAUSES,)),
                one("d"), END),
    ],
)  # fmt: skip
def test_what_pauses_is_refused_with_its_line(of: Mission, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    save_mission(of, path)
    read = read_mission(path)
    with pytest.raises(InputError, match=r"m\.xml:\d+: a is left when facts become so \(on when\), and an"):
        flatten(read)


def test_what_never_comes_about_is_warned_of() -> None:
    never = mission(ROBOT, one("a", left("g", "door=closed", "low")), END)
    never = replace(never, robots=(replace(ROBOT, events=ROBOT.events[:1]),))
    said = [str(problem) for problem in find_warnings(never)]
    assert "<on when> of a never leads away: low is never true" in said
