"""Questions that are open: what is learnt of a question as it was asked before more was known of it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from mcpn.errors import Source
from mcpn.logic.answering import _Answers, answer_all
from mcpn.logic.contest import Property
from mcpn.logic.open_questions import OpenQuestions
from mcpn.logic.questions import Questions
from mcpn.logic.syntax import parse
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.facts import Facts
from mcpn.spaces.search.goal import Formula
from mcpn.testing.nets import philosophers
from mcpn.turns import Pausing


@pytest.fixture
def net() -> PetriNet:
    """Two tokens run around; ``never`` is never marked, which the state equation knows."""
    builder = NetBuilder("ring")
    for place in "abc":
        builder.place(place, initial=int(place != "c"))
    builder.place("never")
    builder.transition("t", consume=["a"], produce=["c"])
    builder.transition("u", consume=["c"], produce=["a"])
    builder.transition("v", consume=["never"], produce=["b"])
    return builder.build()


@pytest.mark.parametrize("found", [True, False])
def test_a_part_that_was_rewritten_meanwhile_still_answers(net: PetriNet, found: bool) -> None:
    """A search that began before the state equation spoke ends with the part that it was given."""
    asked = parse("EF (tokens(a) = 0 & (tokens(never) >= 1 | tokens(c) >= 1))", Names(net))
    questions = OpenQuestions(net, {"q": asked}, settled=False)
    assert not [*questions.rewritten()]
    (searched,) = questions.parts()
    questions.known.bounds = [1, 1, 1, 0]
    questions.known.forget()
    assert not [*questions.rewritten("STATE_EQUATION")]
    (left,) = questions.parts()
    assert left != searched
    (answer,) = questions.learn(searched, found, "EXPLICIT")
    assert (answer.name, answer.value) == ("q", str(found).upper())
    assert not questions.waiting


def test_two_parts_of_an_earlier_form_answer_together(net: PetriNet) -> None:
    asked = parse("EF (tokens(c) >= 1 & tokens(never) = 0) & EX (tokens(never) = 0 & enabled(u))", Names(net))
    questions = OpenQuestions(net, {"q": asked}, settled=False)
    assert not [*questions.rewritten()]
    first, second = questions.parts()
    questions.known.bounds = [1, 1, 1, 0]
    questions.known.forget()
    assert not [*questions.rewritten("STATE_EQUATION")]
    assert not {first, second} & {*questions.parts()}
    assert not [*questions.learn(first, True, "EXPLICIT")]
    (answer,) = questions.learn(second, True, "EXPLICIT")
    assert answer.value == "TRUE"


def test_what_the_equation_knows_of_one_condition_is_used_before_it_is_asked_of_the_next(
    net: PetriNet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The work on the second condition has no end here, and yet the first formula is answered."""
    names = Names(net)
    texts = {"first": "AG !(EX tokens(never) >= 1)", "second": "AG !(EX tokens(c, b) >= 2)"}
    asked = [Property(name, parse(text, names), Source("net")) for name, text in texts.items()]
    plain = Facts.knowing

    def knowing(self: Facts, conditions: Iterator[Formula]) -> Pausing[None]:
        begun, *_ = conditions
        yield from plain(self, [begun])
        while True:
            yield

    monkeypatch.setattr(Facts, "knowing", knowing)
    for other in ("by_structure", "by_search", "by_need", "by_paths"):
        monkeypatch.setattr(_Answers, other, lambda self: iter(()))
    monkeypatch.setattr(_Answers, "by_space", lambda self: iter(()))
    answers = answer_all(Questions(net), asked)
    assert next(answers).name == "first"


def everyone_asks_first(count: int) -> PetriNet:
    """Each raises a flag to try, lowers it where another one's is up, and enters where none is (Dekker)."""
    builder, everyone = NetBuilder("dekker"), range(count)
    for i in everyone:
        for place, initial in (("idle", 1), ("tries", 0), ("inside", 0), ("down", 1), ("up", 0)):
            builder.place(f"{place}{i}", initial=initial)
    for i in everyone:
        others = [j for j in everyone if j != i]
        builder.transition(f"try{i}", consume=[f"idle{i}", f"down{i}"], produce=[f"tries{i}", f"up{i}"])
        for j in others:
            builder.transition(
                f"yield{i}_{j}",
                consume=[f"tries{i}", f"up{i}"],
                produce=[f"idle{i}", f"down{i}"],
                read=[f"up{j}"],
            )
        builder.transition(
            f"enter{i}", consume=[f"tries{i}"], produce=[f"inside{i}"], read=[f"down{j}" for j in others]
        )
        builder.transition(f"leave{i}", consume=[f"inside{i}", f"up{i}"], produce=[f"idle{i}", f"down{i}"])
    return builder.build()


def test_a_lone_deadlock_is_ruled_out_before_the_space_is_drawn() -> None:
    questions = Questions(everyone_asks_first(12))
    (answer,) = answer_all(questions, (), ["ReachabilityDeadlock"])
    assert (answer.value, answer.techniques[-1]) == ("FALSE", "STATE_EQUATION")
    assert not questions.made


def test_a_walk_comes_before_the_invariants(monkeypatch: pytest.MonkeyPatch) -> None:
    def by_structure(self: _Answers) -> Iterator[None]:
        raise AssertionError("a walk finds the deadlock")
        yield

    monkeypatch.setattr(_Answers, "by_structure", by_structure)
    (answer,) = answer_all(Questions(philosophers(5)), (), ["ReachabilityDeadlock"])
    assert answer.value == "TRUE"


def test_the_race_for_a_space_pauses_from_the_beginning() -> None:
    """Other ways have their first turns although the space is not there yet, also of a small net."""
    questions = Questions(philosophers(5))
    way = _Answers(questions, {"live": "Liveness"}).by_space()
    assert next(way) is None
    assert not questions.made
    (answer,) = filter(None, way)
    assert (answer.name, answer.value) == ("live", "FALSE")


def test_questions_that_the_space_has_no_answer_to_in_time_are_left_to_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Evaluation on the space never ends in time here: other ways must not wait for it."""
    monkeypatch.setattr(_Answers, "value", lambda self, name: None)
    names = Names(philosophers(5))
    asked = Property("q", parse("EG (EX (!deadlock))", names), Source("none"))
    (answer,) = answer_all(Questions(philosophers(5)), [asked])
    assert answer.value == "TRUE"


def test_a_bound_of_a_net_on_a_diagram_loads_no_arrays() -> None:
    """To load NumPy takes longer than to answer all about a small net."""
    script = """
import sys
from mcpn.logic.answering import answer_all
from mcpn.logic.questions import Questions
from mcpn.logic.contest import Property
from mcpn.errors import Source
from mcpn.testing.nets import philosophers
(answer,) = answer_all(Questions(philosophers(3), engine="symbolic"), [Property("b", (0, 1), Source("none"))])
print(answer.value, "numpy" in sys.modules)
"""
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert ran.stdout.split() == ["1", "False"]
