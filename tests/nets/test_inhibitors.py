"""Inhibitor arcs: nets that read complement places against firing by the definition of the arcs."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from math import inf
from unittest.mock import patch

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

import mcpn
from mcpn.errors import InputError, Source
from mcpn.logic.answering import answer_all
from mcpn.logic.behaviour import NetCheck
from mcpn.logic.questions import Questions
from mcpn.nets.bounds import coarse_bounds, listed_bounds, proved_bounds, weighted_bound
from mcpn.nets.inhibitors import Inhibitor, without_inhibitors
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.nets.structure import place_bounds
from tests.nets.nets import state_machines, token_nets

Edges = dict[Marking, set[tuple[str, Marking]]]


def by_definition(net: PetriNet, arcs: Sequence[Inhibitor], most: int) -> Edges | None:
    """The markings graph where a transition is disabled by as many tokens as an arc says; None if larger."""
    found: Edges = {net.initial: set()}
    todo = [net.initial]
    while todo:
        marking = todo.pop()
        for number, t in enumerate(net.transitions):
            held = [marking[net.place_index[arc.place]] for arc in arcs if arc.transition == t.name]
            weights = [arc.weight for arc in arcs if arc.transition == t.name]
            if net.covers(marking, number) and all(h < w for h, w in zip(held, weights, strict=True)):
                after = net.fire(marking, number)
                found[marking].add((t.name, after))
                if after not in found:
                    found[after] = set()
                    todo.append(after)
        if len(found) > most:
            return None
    return found


def by_arcs(net: PetriNet, places: int) -> Edges:
    found: Edges = {net.initial[:places]: set()}
    todo = [net.initial]
    while todo:
        marking = todo.pop()
        for t in net.enabled(marking):
            after = net.fire(marking, t)
            found[marking[:places]].add((net.transitions[t].name, after[:places]))
            if after[:places] not in found:
                found[after[:places]] = set()
                todo.append(after)
    return found


@given(token_nets(), st.data())
def test_markings_and_firings_are_those_of_the_definition(net: PetriNet, data: st.DataObject) -> None:
    assume(net.transitions)
    place = st.sampled_from([p.name for p in net.places])
    transition = st.sampled_from([t.name for t in net.transitions])
    arcs = data.draw(st.lists(st.builds(Inhibitor, place, transition, st.integers(1, 3)), max_size=4))
    expected = by_definition(net, arcs, 400)
    assume(expected is not None)
    found = without_inhibitors(net, arcs)
    event(f"{len(found.places) - len(net.places)} complements")
    assert found.places[: len(net.places)] == net.places
    assert by_arcs(found, len(net.places)) == expected


@given(state_machines(), st.data())
def test_whether_a_net_is_safe_is_asked_of_its_own_places(
    drawn: tuple[PetriNet, object], data: st.DataObject
) -> None:
    """Also where a bound is larger than what is reached: here invariants alone give it."""
    net = drawn[0]
    assume(net.transitions and not net.priorities)
    place = st.sampled_from([p.name for p in net.places])
    transition = st.sampled_from([t.name for t in net.transitions])
    arcs = data.draw(st.lists(st.builds(Inhibitor, place, transition, st.integers(1, 2)), max_size=3))
    expected = by_definition(net, arcs, 400)
    assume(expected is not None)
    assert expected is not None
    with patch("mcpn.nets.bounds.MAX_LISTED", 0), suppress(InputError):
        found = without_inhibitors(net, arcs)
        event(f"{len(found.complements)} complements")
        safe = all(tokens <= 1 for marking in expected for tokens in marking)
        (verdict,) = answer_all(Questions(found), (), ["OneSafe"])
        assert verdict.value == str(safe).upper()
        checked = mcpn.open(found).check()
        assert isinstance(checked, NetCheck)
        assert (checked.safe, checked.bound) == (safe, max(map(max, expected)))


def test_a_bound_that_is_not_reached_makes_no_net_unsafe() -> None:
    """An invariant lets p hold 2 tokens; q keeps one of them."""
    builder = NetBuilder("n")
    for name, initial in (("p", 1), ("q", 1), ("r", 0)):
        builder.place(name, initial=initial)
    builder.transition("t", consume=["p"], read=["q"], produce=["r"])
    builder.transition("u", consume=["r"], produce=["p"])
    builder.transition("v", consume=["q"], produce=["p"])
    builder.transition("w", consume=["p"], produce=["q"])
    arcs = [Inhibitor("p", "u", 1), Inhibitor("p", "v", 1), Inhibitor("q", "w", 1)]
    net = builder.build()
    markings = by_definition(net, arcs, 100)
    assert markings is not None
    assert max(map(max, markings)) == 1
    with (
        patch("mcpn.nets.bounds.MAX_LISTED", 0),
        patch("mcpn.nets.inhibitors._guarded", return_value=[9] * 3),
    ):
        found = without_inhibitors(net, arcs)
    assert mcpn.open(found).states().max_tokens_in_place == 2  # the complement of p, where p is empty
    (verdict,) = answer_all(Questions(found), (), ["OneSafe"])
    assert verdict.value == "TRUE"
    checked = mcpn.open(found).check()
    assert isinstance(checked, NetCheck)
    assert checked.safe


def growing() -> NetBuilder:
    builder = NetBuilder("n")
    builder.place("p")
    builder.place("q")
    builder.transition("t", produce=["p"])
    builder.transition("u", produce=["q"])
    return builder


def test_a_place_that_inhibits_what_fills_it_is_bounded_by_that() -> None:
    net = without_inhibitors(growing().build(), [Inhibitor("p", "t", 3)])  # q is unbounded beside it
    assert [(place.name, place.initial) for place in net.places[2:]] == [("complement of p", 3)]
    assert net.complements == {2}
    marking = net.initial
    for _ in range(3):
        assert 0 in net.enabled(marking)
        marking = net.fire(marking, 0)
    assert net.enabled(marking) == [1]


def test_an_unbounded_place_beside_is_counted_as_far_as_arcs_tell() -> None:
    builder = growing()
    builder.place("r")
    builder.transition("v", consume=["p"], produce=["r"])
    net = without_inhibitors(builder.build(), [Inhibitor("p", "t", 1), Inhibitor("r", "t", 1)])
    first = net.fire(net.initial, 0)
    second = net.fire(first, net.transition_index["v"])
    assert net.enabled(first) == [1, 2]
    assert net.enabled(second) == [1]


def test_an_arc_that_never_disables_needs_no_complement() -> None:
    builder = NetBuilder("n")
    builder.place("p", initial=1)
    builder.transition("t", consume=["p"])
    net = builder.build()
    assert without_inhibitors(net, [Inhibitor("p", "t", 2)]) == net


def test_a_place_without_a_proved_bound_is_refused_with_its_line() -> None:
    here = Source("n.pnml", 7)
    with pytest.raises(
        InputError, match=r"n.pnml:7: found an inhibitor arc from p to u, expected a bound of p"
    ):
        without_inhibitors(growing().build(), [Inhibitor("p", "u", 1, here)])


@given(token_nets(), st.data())
def test_coarse_bounds_hold_of_every_marking(net: PetriNet, data: st.DataObject) -> None:
    assume(net.transitions and net.places)
    pairs = st.tuples(st.sampled_from(range(len(net.places))), st.integers(1, 3))
    some = st.dictionaries(
        st.sampled_from(range(len(net.transitions))), st.lists(pairs, max_size=2), max_size=3
    )
    blocked = data.draw(some)
    exact, known = listed_bounds(net, blocked), [inf, *place_bounds(net)[1:]]
    assume(exact is not None)
    assert exact is not None
    coarse = coarse_bounds(net, blocked, known, {0})
    if coarse is not None:
        assert all(bound >= most for bound, most in zip(coarse, exact, strict=True))


@given(token_nets() | state_machines().map(lambda drawn: drawn[0]))
def test_weighted_bounds_hold_of_every_marking(net: PetriNet) -> None:
    markings = by_definition(net, (), 400)
    assume(markings is not None)
    assert markings is not None
    for place in range(len(net.places)):
        bound = weighted_bound(net, place)
        event("bounded" if bound < inf else "no bound")
        assert bound >= max(marking[place] for marking in markings)


def test_tokens_that_vanish_leave_a_bound() -> None:
    """No invariant holds p: its tokens may go. An unbounded place beside it lets no markings be listed."""
    builder = growing()
    builder.place("r", initial=2)
    builder.place("s")
    builder.transition("v", consume=["r"], produce=["s"])
    builder.transition("w", consume=["s"])
    net = builder.build()
    assert weighted_bound(net, net.place_index["s"]) == 2
    with patch("mcpn.nets.bounds.MAX_LISTED", 0):
        found = without_inhibitors(net, [Inhibitor("s", "t", 1)])
    assert found.places[4].initial == 2
    assert weighted_bound(net, 0) == inf


@given(token_nets())
def test_bounds_hold_of_every_marking(net: PetriNet) -> None:
    markings = by_definition(net, (), 400)
    assume(markings is not None)
    assert markings is not None
    most = [max(tokens) for tokens in zip(*markings, strict=True)]
    assert listed_bounds(net) == most
    assert all(bound >= at_most for bound, at_most in zip(proved_bounds(net), most, strict=True))
