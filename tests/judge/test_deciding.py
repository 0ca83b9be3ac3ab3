"""Facts choose among routes, one inside the other: engines and controllers beside the interpreter."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import event, given

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.logic.questions import Questions
from mcpn.mission.model import FactRoute, Mission, Objective, Recursive
from mcpn.mission.robot import DeclaredEvent, Fact, FactChange
from mcpn.spaces.engine_names import Engine
from tests.judge.deciding import deciding
from tests.judge.test_lockstep import check
from tests.logic.asked import ENGINES
from tests.small import activity, mission, robot


@given(deciding())
def test_routes_in_routes_are_chosen_by_facts(of: Mission) -> None:
    event(f"facts of {len(of.facts[0].values)} values")
    assert check(of) == "agree"


def go(name: str, *routes: FactRoute, **others: str) -> Objective:
    return Objective(name=name, activities=("go",), routes=routes, **others)  # type: ignore[arg-type]


def when(word: str, goto: str) -> FactRoute:
    return FactRoute(when=(word,), goto=goto)


OPENED = DeclaredEvent(name="wind", sets=(FactChange(fact="door", to="open"),))
GRAB = DeclaredEvent(name="grab", sets=(FactChange(fact="held", to="true"),))
ROBOT = replace(
    robot((), activity("go", ())),
    facts=(Fact(name="door", values=("closed", "ajar", "open")), Fact(name="held")),
    events=(OPENED, GRAB),
)
INNER = Recursive(
    name="outer", blocks=(go("x", when("held", "fail")),), routes=(when("door=open", "b"), when("held", "c"))
)
NESTED = mission(ROBOT, INNER, go("a", success="succeed"), go("b", success="succeed"), go("c"))
"""The route of the inner objective comes first, then those of what it stands in; ``c`` is never chosen."""


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("EF objective(a)", True),
        ("EF objective(b)", True),  # by the route of the block around, behind that of the inner one
        ("EF objective(c)", False),  # the inner route has taken it
        ("G (fact(held) & happens(OBJ_x_EV_OK) -> X failure)", True),
        ("G (!fact(held) & fact(door)=open & happens(OBJ_x_EV_OK) -> X objective(b))", True),
        ("G (!fact(held) & fact(door)=closed & happens(OBJ_x_EV_OK) -> X objective(a))", True),
    ],
)
def test_what_routes_in_routes_say(engine: Engine, formula: str, holds: bool) -> None:
    assert (
        Questions(spaces_of(compose(NESTED)), on="alternatives", engine=engine).answer(formula).holds is holds
    )


def test_conditions_that_exclude_each_other_choose_nothing() -> None:
    """A route to the end of the block around meets the routes of that, under its own condition too."""
    inner = Recursive(name="outer", blocks=(go("x", when("door=closed", "succeed")),))
    of = mission(ROBOT, replace(inner, routes=(when("door=open", "b"),)), go("a"), go("b"))
    questions = Questions(spaces_of(compose(of)), on="alternatives")
    closed = "fact(door)=closed & happens(OBJ_x_EV_OK)"
    assert questions.answer(f"G ({closed} -> X objective(a))").holds
    assert questions.answer(f"EF ({closed.partition(' ')[0]} & objective(a))").holds
