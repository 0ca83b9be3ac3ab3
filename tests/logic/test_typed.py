"""Typed formulas: the same answers as the space gives, each with a run, and no space where none is needed."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.answers.spaces_by_engine import MissionSpaces, spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event, What
from mcpn.logic.answering import answer_typed
from mcpn.logic.questions import Questions
from mcpn.logic.session import Answer
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.engine_names import Engine, On
from mcpn.spaces.engines import NoSpace
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.run import without_detours
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.formulas import edges_of, formulas, satisfying, text
from tests.nets.nets import nets, reachable, state_machines

GRAPHS: tuple[On, ...] = ("markings", "alternatives")
ENGINES: tuple[Engine, ...] = ("explicit", "symbolic")
ANY_NETS = nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0])


def end_of(net: PetriNet, answer: Answer) -> Marking:
    """The marking that the shown run ends in; each firing is allowed by the net's own rule."""
    marking = net.initial
    for t, after in answer.witness.run.steps():
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
        assert marking == tuple(after)
    assert answer.witness.space.marking(answer.witness.end) == marking
    return marking


@given(ANY_NETS, st.data())
def test_typed_formulas_are_answered_as_every_marking_says(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    drawn = formulas([p.name for p in net.places], [t.name for t in net.transitions])
    asked = data.draw(st.lists(drawn | drawn.map(lambda inner: ("EF", inner)), min_size=2, max_size=3))
    answers = answer_typed(Questions(net), [text(formula) for formula in asked])
    for formula, answer in zip(asked, answers, strict=True):
        assert answer.formula == text(formula)
        assert answer.holds == (net.initial in satisfying(formula, net, edges))
        assert answer.techniques
        end = end_of(net, answer)
        if isinstance(answer.choice, NoSpace):
            event("without the space")
        if formula[0] == "EF" and answer.holds:  # what is inside may be shown further on
            shown = [net.initial, *(tuple(after) for _, after in answer.witness.run.steps())]
            assert satisfying(formula[1], net, edges).intersection(shown)
        assert end in edges


@fewer(0.5)
@given(missions(), st.sampled_from(["markings", "alternatives"]), st.data())
def test_searches_answer_of_missions_as_their_spaces_do(
    mission: Mission, on: On, data: st.DataObject
) -> None:
    """Small missions are listed at once; here they are asked as large ones are, by search first."""
    found = compose(mission)
    net = found.net
    try:
        explore(net, max_states=3000)
        spaces = Questions(spaces_of(found), on=on, engine="explicit")
        _ = spaces.space
    except (LimitError, SemanticsError):
        assume(False)
    names = [p.name for p in net.places], [t.name for t in net.transitions]
    inner = data.draw(formulas(*names, leaves=3))
    places = data.draw(st.lists(st.sampled_from(names[0]), min_size=1, max_size=2, unique=True))
    marked = " & ".join(f'"{place}"' for place in places)
    asked = [
        "EF success",
        f"EF ({marked})",
        f"EF ({text(inner)})",
        text(inner),
        "EF deadlock",
        "EF (!stable)",
    ]
    with patch.object(MissionSpaces, "few", lambda *_: False):
        answers = answer_typed(Questions(spaces_of(found), on=on), asked)
    for answer in answers:
        assert answer.holds == spaces.answer(answer.formula).holds, answer.formula
        end = end_of(net, answer)
        if on == "alternatives":
            assert not any(net.transitions[t].internal for t in net.enabled(end))
        if isinstance(answer.choice, NoSpace):
            event(f"without the space, {on}")
    for answer, goal in zip(answers[:2], ([net.places[found.success].name], places), strict=True):
        if answer.holds:
            assert all(end_of(net, answer)[net.place_index[place]] for place in goal)


@fewer(0.5)
@given(missions(), st.data())
def test_a_run_without_detours_is_one_to_the_same_end(mission: Mission, data: st.DataObject) -> None:
    net = compose(mission).net
    marking, run = net.initial, list[int]()
    for choice in data.draw(st.lists(st.integers(0, 50), max_size=40)):
        if not (enabled := net.enabled(marking)):
            break
        run.append(enabled[choice % len(enabled)])
        marking = net.fire(marking, run[-1])
    goal = data.draw(st.sampled_from([p for p, tokens in enumerate(marking) if tokens]))
    shorter = without_detours(net, run, lambda at: at[goal] > 0)
    at = net.initial
    for t in shorter:
        assert t in net.enabled(at)
        at = net.fire(at, t)
    assert at[goal]
    assert sum(net.transitions[t].event is not None for t in shorter) <= sum(
        net.transitions[t].event is not None for t in run
    )


def test_what_leads_nowhere_is_left_out() -> None:
    builder = NetBuilder("n", priorities=True)
    builder.place("works", initial=1)
    builder.place("broken")
    builder.place("go", initial=1)
    builder.place("there")
    failed, repaired = Event(What.OUT_OF_SERVICE, "h"), Event(What.REPAIRED, "h")
    builder.transition("fail", consume=["works"], produce=["broken"], event=failed)
    builder.transition("repair", consume=["broken"], produce=["works"], event=repaired)
    builder.transition("leave", consume=["go"], produce=["there"], event=Event(What.DECLARED, "leave"))
    net = builder.build()
    fail, repair, leave = range(3)
    there = net.place_index["there"]
    long = (fail, repair, fail, leave, repair)
    assert without_detours(net, long, lambda at: at[there] > 0) == (leave,)
    broken = net.place_index["broken"]
    kept = without_detours(net, (fail, repair, fail, leave), lambda at: at[there] > 0 and at[broken] > 0)
    assert sorted(kept) == [fail, leave]


def ring(count: int) -> PetriNet:
    """Philosophers that may each take one fork: more markings than anything lists."""
    builder = NetBuilder("ring")
    for i in range(count):
        for place, tokens in (("think", 1), ("left", 0), ("eat", 0), ("fork", 1)):
            builder.place(f"{place}{i}", initial=tokens)
    for i in range(count):
        other = f"fork{(i + 1) % count}"
        builder.transition(f"take{i}", consume=[f"think{i}", f"fork{i}"], produce=[f"left{i}"])
        builder.transition(f"eat{i}", consume=[f"left{i}", other], produce=[f"eat{i}"])
        builder.transition(f"done{i}", consume=[f"eat{i}"], produce=[f"think{i}", f"fork{i}", other])
    return builder.build()


def no_space(*_: object, **__: object) -> Any:
    raise AssertionError("no space is needed")


@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("EF deadlock", True),
        ("AG !deadlock", False),
        ("EF (eat3 & eat17)", True),
        ("EF (eat3 & eat4)", False),
        ("AG (tokens(eat3, left3) <= 1) & EF eat1", True),
        ("!EF eat2 | EF (eat5 & eat9)", True),
        ("EX left0", True),
        ("think0", True),
        ("EG !eat0 -> AG think0", False),
    ],
)
def test_a_search_answers_without_the_space(formula: str, holds: bool) -> None:
    net = ring(40)
    needed = "EG" in formula  # a path that stays: no search finds one
    with patch("mcpn.spaces.registry.Spaces.going_on", lambda *_: iter(())):
        if needed:
            answer = Questions(net).answer(formula)
        else:
            with patch("mcpn.spaces.registry.Spaces.space", no_space):
                answer = Questions(net).answer(formula)
            assert isinstance(answer.choice, NoSpace)
    assert answer.holds is holds
    end = end_of(net, answer)
    if formula in ("EF deadlock", "AG !deadlock"):
        assert not net.enabled(end)


def test_formulas_of_one_call_share_a_search_and_keep_their_order() -> None:
    asked = ["EF (eat1 & eat5)", "EF deadlock", "think0 & EF deadlock", "EF deadlock"]
    with (
        patch("mcpn.spaces.registry.Spaces.space", no_space),
        patch("mcpn.spaces.registry.Spaces.going_on", lambda *_: iter(())),
    ):
        found = answer_typed(Questions(ring(30)), asked)
    assert [answer.formula for answer in found] == asked
    assert [answer.holds for answer in found] == [True] * 4


def test_where_no_space_can_be_had_an_answer_says_that_no_run_is_shown() -> None:
    def none(*_: object, **__: object) -> Any:
        raise LimitError("too large")

    with (
        patch("mcpn.spaces.registry.Spaces.space", none),
        patch("mcpn.spaces.registry.Spaces.going_on", lambda *_: iter(())),
    ):
        answer = Questions(ring(8)).answer("EG think0")
        assert answer.holds
        assert any("no run is shown" in note and "too large" in note for note in answer.witness.notes)
        with pytest.raises(LimitError, match="too large"):
            Questions(ring(8), engine="symbolic").answer("EF deadlock")


def test_an_engine_by_name_and_fairness_ask_the_space(ulysse_net: MissionNet) -> None:
    for engine in ENGINES:
        answer = Questions(ring(4), engine=engine).answer("EF deadlock")
        assert (answer.holds, answer.choice.engine) == (True, engine)
    with patch.object(MissionSpaces, "few", lambda *_: False):
        fair = Questions(spaces_of(ulysse_net), fair=["progress"]).answer("EF success")
        found = Questions(spaces_of(ulysse_net)).answer("EF success")
    assert (fair.holds, found.holds, fair.choice.engine, found.choice.engine) == (
        True,
        True,
        "explicit",
        "search",
    )


def test_what_is_dead_is_stable(ulysse_net: MissionNet) -> None:
    """``deadlock`` means the same on both graphs; hardware that may fail keeps a mission's ends alive."""
    for formula, holds in (("EF deadlock", False), ("EF (deadlock & !success & !failure)", False)):
        for on in GRAPHS:
            assert Questions(spaces_of(ulysse_net), on=on).answer(formula).holds is holds
    robust = compose(_robust())  # no hardware may fail, so that the ends are dead
    for on in GRAPHS:
        asked = Questions(spaces_of(robust), on=on)
        assert asked.answer("EF deadlock").holds
        assert asked.answer("AG (deadlock -> (success | failure))").holds


def _robust() -> Mission:
    robot = Robot(
        name="r",
        hardware=(Hardware(name="h", faulty=False),),
        activities=(Activity(name="a", alternatives=(Alternative(name="a", consumes=("h",)),)),),
    )
    return Mission(name="m", blocks=(Objective(name="x", activities=("a",)),), robots=(robot,))
