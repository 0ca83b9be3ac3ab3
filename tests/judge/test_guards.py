"""Blocks that are entered only where facts are so: hand-written missions, errors, and all that play them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import event, given

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.logic.questions import Questions
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import EntryGuard, Handler, Mission, Objective, Recursive, walk
from mcpn.mission.robot import DeclaredEvent, Fact, FactChange
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.validate import find_errors
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import Engine
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import FAILURE, SUCCESS, Interpreter
from tests.draws import fewer
from tests.judge.deciding import deciding
from tests.judge.test_interpreter import play
from tests.judge.test_lockstep import check
from tests.logic.asked import ENGINES
from tests.small import activity, mission, robot


@given(deciding(guards=True))
def test_guards_are_asked_by_whatever_leads_there(of: Mission) -> None:
    event(f"guarded: {sum(bool(block.guards) for block in walk(of.blocks))}")
    assert check(of) == "agree"


@fewer(0.5)
@given(drawn.GUARDED)
def test_missions_with_guards(of: Mission) -> None:
    event(f"guarded: {any(block.guards for block in walk(of.blocks))}")
    check(of)


def enter(when: str, otherwise: str) -> EntryGuard:
    return EntryGuard(when=tuple(when.split()), otherwise=otherwise)


def go(name: str, *guards: EntryGuard, **others: object) -> Objective:
    return Objective(name=name, activities=("go",), guards=guards, **others)  # type: ignore[arg-type]


ROBOT = replace(
    robot((), activity("go", ())),
    facts=(Fact(name="door", values=("closed", "ajar", "open")), Fact(name="held")),
    events=(
        DeclaredEvent(name="wind", sets=(FactChange(fact="door", to="open"),)),
        DeclaredEvent(name="grab", sets=(FactChange(fact="held", to="true"),)),
        DeclaredEvent(name="call"),
    ),
)
DOORS = mission(
    ROBOT,
    go("a", failure="c", handlers=(Handler(event="call", goto="b"),)),
    go("b", enter("door=open", "c"), enter("held", "fail"), retries=1),
    go("c", enter("held", "d"), success="b"),
    go("d", success="succeed"),
)
"""b asks whatever leads to it; its second try is not asked. c leads on to d, by its own guard."""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("G (happens(OBJ_a_EV_OK) & fact(door)=open & fact(held) -> X objective(b_try1))", True),
        ("G (happens(OBJ_a_EV_OK) & fact(door)=open & !fact(held) -> X failure)", True),
        ("G (happens(OBJ_a_EV_OK) & fact(door)=closed & fact(held) -> X objective(c))", True),
        ("G (happens(OBJ_a_EV_OK) & fact(door)=closed & !fact(held) -> X objective(d))", True),
        ("G (happens(call_EV) & objective(a) & fact(door)=closed & fact(held) -> X objective(c))", True),
        ("G (happens(OBJ_a_EV_FAIL) & !fact(held) -> X objective(d))", True),
        ("G (happens(OBJ_b_try1_EV_FAIL) -> X objective(b_try2))", True),
        ("EF objective(b_try2)", True),
        ("EF (objective(b_try1) & fact(door)=closed)", False),
    ],
)
def test_what_guards_say(engine: Engine, formula: str, holds: bool) -> None:
    questions = Questions(spaces_of(compose(DOORS)), on="alternatives", engine=engine)
    assert questions.answer(formula).holds is holds


def test_nothing_of_a_guard_is_in_the_graph() -> None:
    """A mission has the sections that it would have without guards; they are cases of what leads to them."""
    plain = mission(ROBOT, *(replace(block, guards=()) for block in DOORS.blocks))
    found, others = flatten(DOORS), flatten(plain)
    assert {s.name for s in found.sections} == {s.name for s in (*others.sections, *others.unreached)}
    assert [of for of, _ in found.sections[0].cases][:4] == ["success"] * 3 + ["failure"]


def test_the_interpreter_tells_it() -> None:
    of = Interpreter(DOORS)
    assert play(of, ("start", ""), (SUCCESS, "a"))[1].running == {"d"}
    assert play(of, ("start", ""), ("declared", "grab"), (FAILURE, "a"))[1].running == {"c"}


WRITTEN = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><fact name="door" values="open closed"/><activity name="go"/></robot>
  <objective name="x" activities="go"/>
  <objective name="y" activities="go">
    <enter when="door=open" else="w"/>
  </objective>
  <objective name="z" activities="go" success="succeed"/>
  <objective name="w" activities="go"/>
</mission>
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('else="w"', 'else="v"', "m.xml:5: the guard of y when door=open leads to v"),
        ('else="w"', 'else="y"', "lead to each other, so that no block might be entered: y -> y"),
        (
            "door=open",
            "door=ajar",
            "m.xml:5: a guard of y asks for door=ajar: ajar, expected one of open, closed",
        ),
        ("door=open", "dor=open", "m.xml:5: a guard of y asks for the fact dor, which is not declared"),
        ("door=open", "door=open door=closed", "at once"),
        (
            "/>\n  </objective>",
            '/><enter when="door=closed" else="w"/>\n  </objective>',
            "m.xml:4: the guards of y ask for door=open and door=closed at once",
        ),
        (
            '"x" activities="go"/>',
            '"x" activities="go"><enter when="door=open" else="y"/></objective>',
            "m.xml:3: x has a guard (enter), though it is the first of its series",
        ),
        (
            '"z" activities="go"',
            '"z" activities="go" recover="y"',
            "m.xml:5: y has a guard (enter), though it is run for another block",
        ),
        ('else="w"', "", "m.xml:5: "),
        (
            '<objective name="w" activities="go"/>',
            '<objective name="w" activities="go"><enter when="door=open" else="y"/></objective>',
            "lead to each other, so that no block might be entered: y -> w -> y",
        ),
    ],
)
def test_what_no_guard_may_be(old: str, new: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    assert old in WRITTEN
    path.write_text(WRITTEN.replace(old, new, 1))
    with pytest.raises(InputError) as found:
        read_mission(path)
    assert message in str(found.value)


def test_a_branch_has_none(tmp_path: Path) -> None:
    branches = """<parallel name="p"><objective name="b" activities="go"/><objective name="y" """
    text = WRITTEN.replace('<objective name="y" ', branches, 1).replace(
        "</objective>", "</objective></parallel>"
    )
    (tmp_path / "m.xml").write_text(text)
    with pytest.raises(InputError, match=r"y has a guard .* child of a parallel block: guards stand on p"):
        read_mission(tmp_path / "m.xml")


def test_a_guard_that_never_holds_is_told() -> None:
    """So is one of a block in a protocol or in a round: conditions are of facts, wherever they stand."""
    inner = Recursive(name="rounds", blocks=(go("x"), go("y", enter("door=ajar", "succeed"))), repeat=2)
    of = mission(ROBOT, inner)
    assert not find_errors(of)
    assert "y is never entered: door is never ajar" in [w.message for w in find_warnings(of)]
