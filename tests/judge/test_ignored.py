"""Where declared events are ignored: every engine against the interpreter, in all of its states."""

from __future__ import annotations

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.model import Handler, Mission, Objective
from mcpn.mission.robot import DeclaredEvent, Robot
from mcpn.spaces.engines import Engine
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import DECLARED, Interpreter, Undetermined
from tests.draws import composed, fewer
from tests.small import activity, mission

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
MOST_STATES = 1_000


def ignored(of: Mission) -> dict[str, set[str]] | None:
    """By event what runs while it is ignored; ``None`` where there are too many states."""
    interpreter = Interpreter(of)
    found: dict[str, set[str]] = {e.name: set() for e in of.events if not e.sets}
    known, stack = {interpreter.initial}, [interpreter.initial]
    while stack:
        state = stack.pop()
        possible = interpreter.possible(state)
        for name, running in found.items():
            if (DECLARED, name) not in possible:
                running |= state.running
        for happened in possible:
            after = interpreter.after(state, happened)
            if after not in known:
                known.add(after)
                stack.append(after)
        if len(known) > MOST_STATES:
            return None
    return {name: running for name, running in found.items() if running}


@fewer(0.5)
@given(st.one_of(drawn.INTERRUPTED, drawn.ABORTED, drawn.EARLY, drawn.IN_ROUNDS, drawn.PAUSING))
def test_drawn_missions(of: Mission) -> None:
    try:
        expected = ignored(of)
    except Undetermined:
        expected = None
    event(f"decided: {expected is not None}; some: {bool(expected)}")
    if expected is None:
        return
    for engine in ENGINES:
        try:
            found = check(composed(of), engine=engine)
        except LimitError:
            return
        assert {each.event: {*each.objectives} for each in found.ignored} == expected, engine


def dive(*, required: bool, handled: bool) -> Mission:
    on = (Handler(event="leak", goto="up"),)
    robot = Robot(
        name="auv",
        events=(DeclaredEvent(name="leak", required=required),),
        activities=(activity("swim", ()),),
    )
    return mission(
        robot,
        Objective(name="down", activities=("swim",), handlers=on),
        Objective(name="across", activities=("swim",), handlers=on if handled else ()),
        Objective(name="up", activities=("swim",), handlers=on),
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_an_event_that_must_be_handled_fails_where_it_is_not(engine: Engine) -> None:
    said = {}
    for required in (False, True):
        for handled in (False, True):
            found = check(compose(dive(required=required, handled=handled)), engine=engine)
            said[required, handled] = found.passed, [each.sentence for each in found.ignored]
    across = ["leak is ignored while across runs"]
    assert said == {
        (False, False): (True, across),
        (False, True): (True, []),
        (True, False): (False, across),
        (True, True): (True, []),
    }
