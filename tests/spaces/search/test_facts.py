"""What the state equation and walks tell of a net without its space, wherever they are interrupted."""

from __future__ import annotations

from collections import Counter
from itertools import islice

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.search.equation import Ceiling
from mcpn.spaces.search.facts import Facts
from mcpn.spaces.search.goal import marked
from mcpn.testing.nets import kanban
from mcpn.turns import Pausing, finished
from tests.spaces.search.goals import all_markings
from tests.spaces.search.test_portfolio import PLAIN_NETS


def test_a_bound_above_one_is_no_proof_of_safety() -> None:
    """The proof for ``a`` bounds ``b`` by two tokens; ``b`` itself is asked no more."""
    builder = NetBuilder("twice")
    builder.place("a", initial=1)
    builder.place("b")
    builder.transition("t", consume=["a"], produce=["b", "b"])
    builder.transition("u", consume=["b", "b"], produce=["a"])
    net = builder.build()
    assert finished(Facts(net).safe())[0] is False


def examined(net: PetriNet) -> dict[str, bool] | None:
    """The examinations by every marking; ``None`` where there are many."""
    markings = all_markings(net)
    if markings is None:
        return None
    enabled = {m: set(net.enabled(m)) for m in markings}
    leading = {t: {m for m in markings if t in enabled[m]} for t in range(len(net.transitions))}
    for states in leading.values():
        while more := {m for m in markings - states if any(net.fire(m, t) in states for t in enabled[m])}:
            states |= more
    return {
        "OneSafe": max((max(m, default=0) for m in markings), default=0) <= 1,
        "QuasiLiveness": set().union(*enabled.values()) == set(range(len(net.transitions))),
        "StableMarking": any(len({m[p] for m in markings}) == 1 for p in range(len(net.places))),
        "Liveness": all(states == markings for states in leading.values()),
    }


@given(PLAIN_NETS, st.integers(0, 12))
def test_what_is_told_is_true_even_if_the_work_was_not_done(net: PetriNet, pauses: int) -> None:
    known = examined(net)
    assume(known is not None)
    assert known is not None
    told = Facts(net)
    for examination in told.examinations.values():
        for _ in islice(examination(), pauses):
            pass
    for name, examination in told.examinations.items():
        value, _ = finished(examination())
        event(f"{name}: {value}")
        assert value in (None, known[name]), name


def test_a_net_that_fills_up_for_ever_may_be_live() -> None:
    """No bounded sum of tokens is lowered for good, though firings are never undone."""
    builder = NetBuilder("source")
    builder.place("p")
    builder.transition("t", produce=["p"])
    assert finished(Facts(builder.build()).live())[0] is not False


@pytest.mark.parametrize("initial", [0, 1])
def test_a_place_alone_is_safe(initial: int) -> None:
    builder = NetBuilder("alone")
    builder.place("p", initial=initial)
    assert finished(Facts(builder.build()).safe())[0] is True


def test_a_bound_that_is_met_is_told_before_the_next_is_sought(monkeypatch: pytest.MonkeyPatch) -> None:
    facts = Facts(kanban(2))
    sought, plain = list[object](), facts.equation.bounding

    def bounding(places: Counter[int]) -> Pausing[Ceiling]:
        sought.append(places)
        return plain(places)

    monkeypatch.setattr(facts.equation, "bounding", bounding)
    told = (each for each in facts.sums([(1,), (2,), (3,)]) if each is not None)
    assert next(told)[:2] == ((1,), 2)
    assert len(sought) == 1
    assert [each[:2] for each in told] == [((2,), 2), ((3,), 2)]


def test_what_fires_on_the_way_to_one_transition_is_asked_no_more() -> None:
    builder = NetBuilder("chain")
    for number in range(8):
        builder.place(f"p{number}", initial=int(number == 0))
    for number in range(7):
        builder.transition(f"t{number}", consume=[f"p{number}"], produce=[f"p{number + 1}"])
    facts = Facts(builder.build())
    assert finished(facts._planned(marked(7), 0))
    assert facts.fires == {0, 1, 2, 3, 4, 5, 6}
    assert finished(facts.quasi_live())[0] is True


def test_a_sum_is_raised_token_by_token() -> None:
    net = kanban(40)
    facts = Facts(net)
    assert finished(facts._raised((1,), 40, 0)) == 40
    assert finished(facts._raised((1,), 41, 0)) == 40
    assert facts.fires


def test_a_bound_that_the_equation_does_not_know_is_searched() -> None:
    """The door opens with two keys in one hand; reading adds nothing to the state equation."""
    builder = NetBuilder("door")
    for place, tokens in (("hand", 1), ("one", 0), ("other", 0), ("a", 1), ("b", 1), ("open", 0)):
        builder.place(place, initial=tokens)
    for key in ("one", "other"):
        builder.transition(f"take {key}", consume=["hand"], produce=[key])
        builder.transition(f"leave {key}", consume=[key], produce=["hand"])
    builder.transition("first", consume=["a"], produce=["open"], read=["one"])
    builder.transition("second", consume=["b"], produce=["open"], read=["one", "other"])
    facts = Facts(builder.build())
    assert finished(facts.equation.bounding({5: 1})).bound == 2
    (told,) = (told for told in facts.sums([(5,)]) if told)
    assert told[:2] == ((5,), 1)


def test_proposed_firings_are_walked_longer_with_more_effort(monkeypatch: pytest.MonkeyPatch) -> None:
    facts, steps = Facts(kanban(2)), list[int]()
    monkeypatch.setattr(facts.searches, "met", lambda goals, **asked: steps.append(asked["steps"]))
    for effort in range(3):
        facts._counted(marked(1), [1] * 16, effort)
    assert steps[0] < steps[1] < steps[2]
