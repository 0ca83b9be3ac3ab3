"""Where declared events are ignored: every engine against the interpreter, in all of its states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.verdicts.as_written import led_to_by_events
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Handler, Mission, Objective, Parallel, Protocol, Use
from mcpn.mission.robot import DeclaredEvent, Robot
from mcpn.spaces.engine_names import Engine
from mcpn.testing import elements as drawn
from mcpn.testing import missions
from mcpn.testing.judge.blocks import WrittenBlock
from mcpn.testing.judge.interpreter import DECLARED, Interpreter, Undetermined
from tests.draws import composed, fewer
from tests.small import activity, mission

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
MOST_STATES = 1_000
LEADING = missions(
    sections=7,
    objectives=4,
    hardware=1,
    producers=1,
    parallel=False,
    protocols=False,
    events=3,
    aborts=5,
    pauses=2,
)
"""Series whose handlers lead to siblings, or abort."""
OF = (LEADING, drawn.INTERRUPTED, drawn.ABORTED, drawn.EARLY, drawn.IN_ROUNDS, drawn.PAUSING)


def led_to(interpreter: Interpreter, event: str) -> set[str]:
    """The blocks that handlers of an event lead to, as written; of an abort where it is caught."""
    found = set[str]()
    for name, leaf in interpreter.objectives.items():
        assert leaf.name == name
        for node in around(leaf):
            for handler in node.handlers:
                if handler.event != event:
                    continue
                # A handler of the mission has no parent: it names blocks of the mission.
                target, outer = handler.goto or handler.pause, node.parent
                while target == ABORT and outer is not None:
                    target, outer = outer.abort, outer.parent
                if target not in (None, SUCCEED, FAIL, ABORT):
                    found.add(target)
    return found


def around(node: WrittenBlock | None) -> Iterator[WrittenBlock]:
    """A block, then those that it stands in."""
    while node is not None:
        yield node
        node = node.parent


def changing_nothing(of: Mission) -> dict[str, tuple[set[str], set[str]]] | None:
    """By event what runs while it is ignored, and of what it leads to while it is answered already.

    Returns:
        ``None`` where there are too many states.
    """
    interpreter = Interpreter(of)
    found = {e.name: (set[str](), set[str]()) for e in of.events if not e.sets}
    leads = {name: led_to(interpreter, name) for name in found}
    known, stack = {interpreter.initial}, [interpreter.initial]
    while stack:
        state = stack.pop()
        possible = interpreter.possible(state)
        for name, (unseen, answering) in found.items():
            if (DECLARED, name) not in possible:
                leaves = (interpreter.objectives[running] for running in state.running)
                here = {leaf.name for leaf in leaves if {n.written for n in around(leaf)} & leads[name]}
                answering |= here
                unseen |= set() if here else state.running
        for happened in possible:
            after = interpreter.after(state, happened)
            if after not in known:
                known.add(after)
                stack.append(after)
        if len(known) > MOST_STATES:
            return None
    return {name: both for name, both in found.items() if any(both)}


@fewer(0.5)
@given(st.one_of(OF))
def test_drawn_missions(of: Mission) -> None:
    try:
        expected = changing_nothing(of)
    except Undetermined:
        expected = None
    told = [sum(map(bool, each)) for each in zip(*(expected or {}).values(), strict=True)]
    event(f"decided: {expected is not None}; ignored, answered: {told}")
    if expected is None:
        return
    for engine in ENGINES:
        try:
            found = check(composed(of), engine=engine)
        except LimitError:
            return
        said = {each.event: ({*each.objectives}, {*each.answering}) for each in found.changing_nothing}
        assert said == expected, engine
        assert {each.event for each in found.ignored} == {name for name, both in expected.items() if both[0]}


def dive(*, required: bool, handled: bool, again: bool = True) -> Mission:
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
        Objective(name="up", activities=("swim",), handlers=on if again else ()),
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_an_event_that_must_be_handled_fails_where_it_is_not(engine: Engine) -> None:
    said = {}
    for required in (False, True):
        for handled in (False, True):
            found = check(compose(dive(required=required, handled=handled)), engine=engine)
            said[required, handled] = found.passed, [(each.event, each.objectives) for each in found.ignored]
    across = [("leak", ("across",))]
    assert said == {
        (False, False): (True, across),
        (False, True): (True, []),
        (True, False): (False, across),
        (True, True): (True, []),
    }


def test_what_an_event_leads_to_answers_it() -> None:
    """On its way up a robot is not told to come up, whatever sent it there."""
    found = check(compose(dive(required=True, handled=True, again=False)))
    assert found.passed
    assert found.ignored == ()
    (leak,) = found.changing_nothing
    assert (leak.objectives, leak.answering) == ((), ("up",))


def test_an_abort_leads_to_where_it_is_caught() -> None:
    """Also out of the use of a protocol, and past a branch; an exit of the mission answers nothing."""
    on = (Handler(event="leak", goto="abort"),)
    swim = Objective(name="swim", activities=("swim",), handlers=on)
    robot = Robot(name="auv", events=(DeclaredEvent(name="leak"),), activities=(activity("swim", ()),))
    for abort, expected in (("up", {("", "up")}), ("abort", set())):
        both = Parallel(name="both", blocks=(Use(name="one", protocol="dive"),), abort=abort)
        of = mission(robot, both, Objective(name="up", activities=("swim",)))
        of = replace(of, protocols=(Protocol(name="dive", blocks=(swim,)),))
        assert led_to_by_events(of)["leak"] == expected
