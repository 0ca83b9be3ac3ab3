"""The interpreter says what the language page says, on missions small enough to be followed by hand."""

from __future__ import annotations

import ast
from dataclasses import replace

import pytest

from mcpn.mission.model import Each, Handler, Mission, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.robot import DeclaredEvent, Hardware, Parameter, Software
from mcpn.testing.judge.interpreter import (
    DECLARED,
    FAILURE,
    OUT_OF_SERVICE,
    REPAIRED,
    START,
    SUCCESS,
    Happening,
    Interpreter,
    State,
    Undetermined,
)
from tests.conftest import ROOT
from tests.small import activity, hw, mission, robot

BEGIN = (START, "")


def play(of: Mission | Interpreter, *happenings: Happening) -> tuple[Interpreter, State]:
    """The state after some events, each of which must be possible."""
    interpreter = of if isinstance(of, Interpreter) else Interpreter(of)
    state = interpreter.initial
    for happened in happenings:
        assert happened in interpreter.possible(state), happened
        state = interpreter.after(state, happened)
    return interpreter, state


def mode(of: Mission | Interpreter, *happenings: Happening) -> dict[str, str]:
    interpreter, state = play(of, *happenings)
    return dict(interpreter.seen(state).mode)


def out(name: str) -> Happening:
    return OUT_OF_SERVICE, name


def back(name: str) -> Happening:
    return REPAIRED, name


def ok(name: str) -> Happening:
    return SUCCESS, name


def fail(name: str) -> Happening:
    return FAILURE, name


def event(name: str) -> Happening:
    return DECLARED, name


@pytest.mark.parametrize("module", ["blocks", "robot", "interpreter"])
def test_the_interpreter_knows_the_model_alone(module: str) -> None:
    tree = ast.parse((ROOT / "mcpn" / "testing" / "judge" / f"{module}.py").read_text())
    found = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Import)]
    known = {
        "mcpn.mission.model",
        "mcpn.mission.robot",
        "mcpn.testing.judge.blocks",
        "mcpn.testing.judge.robot",
    }
    assert {name for name in found if name.split(".")[0] in ("mcpn", "tests")} <= known


ONE = mission(robot(hw("h", "g"), activity("a", ("h",), ("g",))), Objective(name="o", activities=("a",)))


def test_the_first_alternative_that_is_possible_runs_and_goes_on() -> None:
    assert mode(ONE, BEGIN) == {"a": "a_0"}
    assert mode(ONE, BEGIN, out("h")) == {"a": "a_1"}
    assert mode(ONE, BEGIN, out("h"), back("h")) == {"a": "a_1"}
    assert mode(ONE, BEGIN, out("h"), back("h"), out("g")) == {"a": "a_0"}


def test_a_refused_activity_stays_refused_and_its_objective_can_only_fail() -> None:
    interpreter, state = play(ONE, BEGIN, out("h"), out("g"), back("h"))
    assert interpreter.seen(state).refused == {"a"}
    assert interpreter.possible(state) == {fail("o"), out("h"), back("g")}
    assert interpreter.after(state, fail("o")).outcome == "failure"


def test_an_activity_that_switches_back_returns() -> None:
    of = robot(hw("h", "g"), replace(activity("a", ("h",), ("g",)), switch_back=True))
    found = mission(of, Objective(name="o", activities=("a",)))
    assert mode(found, BEGIN, out("h"), back("h")) == {"a": "a_0"}


def two_consumers() -> Mission:
    of = robot(
        (*hw("h"), Hardware(name="g", shared=True)),
        activity("d", ("h",), (), produces=("s",)),
        activity("a", ("s", "g")),
        activity("b", ("g",), ("s",)),
        activity("c", ("s",)),
    )
    return mission(of, Objective(name="o", activities=("a", "b")), Objective(name="p", activities=("c",)))


def test_a_producer_goes_on_if_somebody_needs_it_at_the_end_of_the_reaction() -> None:
    """As g fails ``a`` leaves the data and ``b`` comes to it: the producer keeps its alternative."""
    before = BEGIN, out("h"), back("h")
    assert mode(two_consumers(), *before) == {"d": "d_1", "a": "a", "b": "b_0"}
    assert mode(two_consumers(), *before, out("g")) == {"d": "d_1", "b": "b_1"}


def test_the_next_objective_begins_when_all_has_stopped() -> None:
    """A producer that both need stops in between, so that it begins with its best alternative."""
    assert mode(two_consumers(), BEGIN, out("h"), back("h"), ok("o")) == {"d": "d_0", "c": "c"}


def test_a_producer_that_another_branch_needs_goes_on_meanwhile() -> None:
    of = robot(hw("h"), activity("d", ("h",), (), produces=("s",)), *(activity(x, ("s",)) for x in "abc"))
    series = Recursive(
        name="r", blocks=(Objective(name="p", activities=("b",)), Objective(name="q", activities=("c",)))
    )
    found = mission(of, Parallel(name="both", blocks=(Objective(name="o", activities=("a",)), series)))
    assert mode(found, BEGIN, out("h"), back("h"), ok("p")) == {"d": "d_1", "a": "a", "c": "c"}


def test_consumers_of_a_refused_producer_are_in_error() -> None:
    of = robot(hw("h"), activity("d", ("h",), produces=("s",)), activity("a", ("s",), ()))
    found = mission(of, Objective(name="o", activities=("a",)))
    assert mode(found, BEGIN) == {"d": "d", "a": "a_0"}
    assert mode(found, BEGIN, out("h")) == {"a": "a_1"}


def branches(*first: Objective, beside: Objective) -> Parallel:
    return Parallel(name="both", blocks=(Recursive(name="r", blocks=first), beside))


def test_a_busy_alternative_is_waited_for() -> None:
    of = robot(hw("h"), activity("a", ()), activity("b", ("h",), ()), activity("c", ("h",)))
    first = Objective(name="o", activities=("a",)), Objective(name="p", activities=("b",))
    found = mission(of, branches(*first, beside=Objective(name="q", activities=("c",))))
    interpreter, state = play(found, BEGIN, ok("o"))
    assert interpreter.seen(state).waiting == {("b", "b_0")}
    assert ok("p") not in interpreter.possible(state)
    assert mode(interpreter, BEGIN, ok("o"), ok("q")) == {"b": "b_0"}
    # What fails is out of service for who waits as well: the next alternative is tried.
    assert mode(interpreter, BEGIN, ok("o"), out("h")) == {"b": "b_1"}


def test_exclusive_software_is_waited_for() -> None:
    of = robot(hw(), activity("d", (), produces=("s",)), activity("a", ()), activity("b", ("s",)))
    of = replace(of, software=(Software(name="s", exclusive=True),))
    of = replace(of, activities=(*of.activities, activity("c", ("s",))))
    first = Objective(name="o", activities=("a",)), Objective(name="p", activities=("b",))
    found = mission(of, branches(*first, beside=Objective(name="q", activities=("c",))))
    interpreter, state = play(found, BEGIN, ok("o"))
    assert interpreter.seen(state).waiting == {("b", "b")}
    assert mode(interpreter, BEGIN, ok("o"), ok("q")) == {"d": "d", "b": "b"}


def test_who_asks_at_the_same_moment_is_not_determined() -> None:
    of = robot(hw("h"), activity("a", ("h",)), activity("b", ("h",)))
    with pytest.raises(Undetermined):
        play(mission(of, Objective(name="o", activities=("a", "b"))), BEGIN)


def test_an_activity_of_another_branch_is_waited_for() -> None:
    of = robot(hw(), activity("a", ()), activity("b", ()))
    first = Objective(name="o", activities=("b",)), Objective(name="p", activities=("a",))
    found = mission(of, branches(*first, beside=Objective(name="q", activities=("a",))))
    interpreter, state = play(found, BEGIN, ok("o"))
    assert state.pending == {"p"}
    assert state.running == {"q"}
    _, state = play(interpreter, BEGIN, ok("o"), ok("q"))
    assert not state.pending
    assert state.running == {"p"}
    assert interpreter.seen(state).ended == {"q"}


A = robot(hw(), activity("a", ()), events=("leak",))


def test_names_routes_rounds_and_tries() -> None:
    inner = Objective(name="o", activities=("a",), retries=1)
    each = Each(name="v", values=("x", "y"), blocks=(Use(name="u", protocol="P", failure="succeed"),))
    found = replace(mission(A, each), protocols=(Protocol(name="P", blocks=(inner,)),))
    _, state = play(found, BEGIN)
    assert state.running == {"u_x.o_try1"}
    interpreter, state = play(found, BEGIN, fail("u_x.o_try1"), ok("u_x.o_try2"))
    assert state.running == {"u_y.o_try1"}
    _, state = play(interpreter, BEGIN, ok("u_x.o_try1"), fail("u_y.o_try1"), fail("u_y.o_try2"))
    assert state.outcome == "success"


def test_a_block_in_rounds_fails_with_the_first_round_that_does() -> None:
    found = mission(A, Objective(name="o", activities=("a",), repeat=2, retries=1))
    assert set(Interpreter(found).objectives) == {"o_1_try1", "o_1_try2", "o_2_try1", "o_2_try2"}
    _, state = play(found, BEGIN, ok("o_1_try1"), fail("o_2_try1"), fail("o_2_try2"))
    assert state.outcome == "failure"


def test_a_parallel_block_needs_its_mandatory_children() -> None:
    one, other = (
        Objective(name="o", activities=("a",)),
        Objective(name="p", activities=("b",), mandatory=False),
    )
    of = robot(hw(), activity("a", ()), activity("b", ()))
    interpreter, state = play(mission(of, Parallel(name="both", blocks=(one, other))), BEGIN, fail("p"))
    assert interpreter.seen(state).ended == {"p"}
    assert interpreter.after(state, ok("o")).outcome == "success"
    assert interpreter.after(state, fail("o")).outcome == "failure"


def test_the_innermost_handler_counts_and_one_that_happens_once_then_does_not() -> None:
    handler = Handler(event="leak", goto="o", once=True)
    inner = Objective(name="o", activities=("a",), handlers=(handler,))
    found = replace(mission(A, inner), handlers=(Handler(event="leak", goto="succeed"),))
    interpreter, state = play(found, BEGIN, event("leak"))
    assert state.running == {"o"}
    assert interpreter.after(state, event("leak")).outcome == "success"


@pytest.mark.parametrize("copies", ["each", "use", "repeat", "retries"])
def test_a_handler_written_once_happens_once_in_all_its_copies(copies: str) -> None:
    handler = Handler(event="leak", goto="fail" if copies == "retries" else "succeed", once=True)
    inner = Objective(name="o", activities=("a",), handlers=(handler,))
    blocks: tuple[Each | Use | Recursive, ...]
    if copies == "each":
        blocks = (Each(name="v", values=("x", "y"), blocks=(inner,)),)
    elif copies == "use":
        blocks = Use(name="u", protocol="P"), Use(name="w", protocol="P")
    elif copies == "repeat":
        blocks = (Recursive(name="r", blocks=(inner,), repeat=2),)
    else:
        blocks = (Recursive(name="r", blocks=(inner,), retries=1),)
    found = replace(mission(A, *blocks), protocols=(Protocol(name="P", blocks=(inner,)),))
    interpreter, state = play(found, BEGIN, event("leak"))
    assert len(state.running) == 1
    assert event("leak") not in interpreter.possible(state)


def test_branches_that_handle_one_event_by_one_handler_all_take_it() -> None:
    handler = Handler(event="leak", goto="succeed", once=True)
    protocol = Protocol(
        name="P",
        parameters=(),
        blocks=(Objective(name="o", activities=("a",), handlers=(handler,)),),
    )
    of = replace(A, events=(DeclaredEvent(name="leak"),))
    one = Recursive(
        name="r", blocks=(Objective(name="before", activities=("b",)), Use(name="u", protocol="P"))
    )
    of = replace(of, activities=(*of.activities, activity("b", ())))
    # Both uses start the activity a: the second is about to begin, which is handled as well.
    found = mission(of, Parallel(name="both", blocks=(one, Use(name="w", protocol="P"))))
    found = replace(found, protocols=(protocol,))
    interpreter, state = play(found, BEGIN, ok("before"))
    assert state.running == {"w.o"}
    assert state.pending == {"u.o"}
    assert interpreter.after(state, event("leak")).outcome == "success"


def parameters(found: Mission) -> dict[str, dict[str, str]]:
    """By objective the parameters in force."""
    return {name: dict(leaf.parameters) for name, leaf in Interpreter(found).objectives.items()}


def test_the_innermost_parameter_counts() -> None:
    def p(value: str, name: str = "k") -> tuple[Parameter, ...]:
        return (Parameter(name=name, value=value),)

    plain, own = (
        Objective(name="o", activities=("a",)),
        Objective(name="w", activities=("a",), parameters=p("own")),
    )
    inner = Protocol(name="Q", parameters=p("Q"), blocks=(replace(plain, name="q"),))
    outer = Protocol(name="P", parameters=p("P"), blocks=(plain, own, Use(name="i", protocol="Q")))
    use = Use(name="u", protocol="P", parameters=p("use"))
    found = replace(mission(A, use, Use(name="v", protocol="P")), protocols=(inner, outer))
    assert parameters(found) == {
        "u.o": {"k": "use"},
        "u.w": {"k": "own"},
        "u.i.q": {"k": "use"},
        "v.o": {"k": "P"},
        "v.w": {"k": "own"},
        "v.i.q": {"k": "Q"},
    }
    values = Each(name="k", values=("x",), blocks=(Use(name="v", protocol="P"), use))
    found = replace(mission(A, values), protocols=(inner, outer))
    assert parameters(found) == {
        "v_x.o": {"k": "x"},
        "v_x.w": {"k": "own"},
        "v_x.i.q": {"k": "x"},
        "u_x.o": {"k": "use"},
        "u_x.w": {"k": "own"},
        "u_x.i.q": {"k": "use"},
    }
