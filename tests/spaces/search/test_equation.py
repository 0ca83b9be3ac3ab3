"""What the state equation rules out is not reachable."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.reduce.reduction import reduce_for_deadlock
from mcpn.spaces.search.equation import Proof, StateEquation
from mcpn.spaces.search.goal import DEADLOCK, And, AtMost, Goal, marked
from mcpn.spaces.search.searches import Searches
from tests.spaces.search.goals import all_markings, goals, is_goal, negated
from tests.spaces.search.test_portfolio import PLAIN_NETS


@given(st.data())
def test_nothing_reachable_is_ruled_out(data: st.DataObject) -> None:
    net = data.draw(PLAIN_NETS)
    goal: Goal = data.draw(goals(net) | st.just(DEADLOCK))
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    found = StateEquation(net).solve(goal)
    if any(is_goal(goal, net, marking) for marking in markings):
        assert found.kind != "unreachable"
        # Its numbers of firings are a proposal; a walk by them must still replay.
        if found.kind == "possible":
            for run in Searches(net).walk([goal], steps=200, counts=found.counts).values():
                marking = net.initial
                for t in run:
                    assert t in net.enabled(marking)
                    marking = net.fire(marking, t)
                assert is_goal(goal, net, marking)


def assert_proved(proof: Proof, net: PetriNet, weights: dict[int, int], bound: Fraction) -> None:
    """The rows are those of the net and its traps, and the multipliers prove the bound, all in fractions."""
    effects = [{p: after - before for p, (before, after) in arcs.items()} for arcs in arcs_of(net)]
    first = len(net.transitions)
    factors = [Fraction(m, proof.common) for m in proof.multipliers]
    total = [Fraction(weights.get(p, 0)) for p in range(len(net.places))]
    columns, left = [Fraction(0)] * len(proof.lower), Fraction(0)
    assert set(proof.lower[:first]) <= {0}
    assert set(proof.upper[:first]) <= {inf}  # transitions fire any number of times
    for number, (factor, (row, least, most)) in enumerate(zip(factors, proof.rows, strict=True)):
        if number < len(net.places):  # the equation: initial tokens, what firings add, less the tokens
            assert least == most == -net.initial[number]
            changed = {t: effect[number] for t, effect in enumerate(effects) if effect.get(number)}
            assert row == {**changed, first + number: -1}
        elif weights:  # a bound needs no rows but those of traps that are marked at first
            assert_marked_trap({variable - first for variable in row}, net)
            assert (set(row.values()), least) == ({1}, 1)
        end_of_row = least if factor > 0 else most
        if factor:
            left -= factor * Fraction(end_of_row)
            for variable, weight in row.items():
                columns[variable] += factor * weight
    for place, own in enumerate(total):
        columns[first + place] += own
    for variable, column in enumerate(columns):
        if column:
            left += column * Fraction(proof.upper[variable] if column > 0 else proof.lower[variable])
    assert left <= bound


def assert_marked_trap(trap: set[int], net: PetriNet) -> None:
    """Each transition that leaves no token in a set of places takes none from it; one is there at first."""
    assert any(net.initial[place] for place in trap)
    for t in net.transitions:
        taken, put = dict(t.consume), {place for place, _ in t.produce}
        kept = {place for place, tokens in t.read if tokens > taken.get(place, 0)}
        assert not trap & taken.keys() or trap & (put | kept)


def arcs_of(net: PetriNet) -> list[dict[int, tuple[int, int]]]:
    """By transition, the places with what it takes and what it puts."""
    return [
        {
            p: (dict(t.consume).get(p, 0), dict(t.produce).get(p, 0))
            for p in {place for place, _ in (*t.consume, *t.produce)}
        }
        for t in net.transitions
    ]


@given(st.data())
def test_whatever_is_ruled_out_is_proved_in_fractions(data: st.DataObject) -> None:
    net = data.draw(PLAIN_NETS)
    found = StateEquation(net).solve(data.draw(goals(net) | st.just(DEADLOCK)))
    assert bool(found.proofs) == (found.kind == "unreachable")
    for proof in found.proofs:
        assert_proved(proof, net, {}, Fraction(-1, 10**9))


@given(st.data())
def test_a_ceiling_is_proved_in_fractions_and_holds(data: st.DataObject) -> None:
    net = data.draw(PLAIN_NETS)
    markings = all_markings(net)
    equation = StateEquation(net)
    places = st.integers(0, len(net.places) - 1)
    for weights in data.draw(st.lists(st.dictionaries(places, st.integers(1, 3)), max_size=3)):
        found = equation.most(weights)
        if found.bound is None:
            continue
        assert found.proof is not None
        assert_proved(found.proof, net, weights, Fraction(found.bound + 1) - Fraction(1, 10**9))
        for marking in markings or ():
            assert sum(w * marking[p] for p, w in weights.items()) <= found.bound


def test_an_invariant_bounds_the_sum_of_its_places() -> None:
    net = mutual_exclusion().build()
    equation = StateEquation(net)
    assert equation.most({net.place_index["a_in"]: 1, net.place_index["b_in"]: 1}).bound == 1
    assert equation.most({net.place_index["a_in"]: 2, net.place_index["b_in"]: 3}).bound == 3
    assert equation.most({net.place_index["a_out"]: 1, net.place_index["b_out"]: 1}).bound == 2


def test_tokens_of_any_size_are_bounded_exactly() -> None:
    builder = NetBuilder("stock")
    builder.place("stock", initial=999_999_999)
    builder.place("packed")
    builder.transition("pack", consume={"stock": 7}, produce={"packed": 3})
    assert StateEquation(builder.build()).most({1: 1}).bound == 428571428


def test_what_grows_has_no_ceiling() -> None:
    builder = NetBuilder("spring")
    builder.place("water")
    builder.transition("rise", produce=["water"])
    assert StateEquation(builder.build()).most({0: 1}).bound is None


@given(st.data())
def test_bounds_hold_in_every_marking(data: st.DataObject) -> None:
    net = data.draw(PLAIN_NETS)
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    bounds = StateEquation(net).bounds
    assert all(tokens <= bound for m in markings for tokens, bound in zip(m, bounds, strict=True))


def mutual_exclusion() -> NetBuilder:
    builder = NetBuilder("mutex")
    builder.place("lock", initial=1)
    for name in "ab":
        builder.place(f"{name}_out", initial=1)
        builder.place(f"{name}_in")
        builder.transition(f"{name}_enter", consume=[f"{name}_out", "lock"], produce=[f"{name}_in"])
        builder.transition(f"{name}_leave", consume=[f"{name}_in"], produce=[f"{name}_out", "lock"])
    return builder


def test_an_invariant_rules_out_both_inside() -> None:
    net = mutual_exclusion().build()
    both = And(marked(net.place_index["a_in"]), marked(net.place_index["b_in"]))
    assert StateEquation(net).solve(both).kind == "unreachable"
    assert StateEquation(net).solve(negated(both, net)).kind == "possible"


def test_a_trap_rules_out_what_the_equation_lets_pass() -> None:
    # What takes from {one, two} also puts a token there; numbers of firings alone could empty both.
    builder = NetBuilder("trap")
    builder.place("one", initial=1)
    builder.place("two")
    builder.place("spare", initial=1)
    builder.transition("go", consume=["one"], produce=["two", "spare"])
    builder.transition("back", consume={"two": 1, "spare": 1}, produce=["one"])
    builder.transition("leak", consume={"one": 1, "two": 1}, produce=["one"])
    net = builder.build()
    none = And(negated(marked(0), net), negated(marked(1), net))
    found = StateEquation(net).solve(none)
    assert (found.kind, found.traps) == ("unreachable", 1)
    markings = all_markings(net)
    assert markings is not None
    assert not any(is_goal(none, net, marking) for marking in markings)


@pytest.mark.parametrize("model", ["Dekker-PT-050", "Raft-PT-05", "ShieldRVt-PT-010A", "Ring-PT-none"])
def test_large_nets_without_deadlock(mcc: Path, model: str) -> None:
    net = read_net(mcc / model / "model.pnml")
    assert StateEquation(reduce_for_deadlock(net).net).solve(DEADLOCK).kind == "unreachable"


@pytest.mark.parametrize("read", [1, 2, 3, 4])
def test_what_is_read_stays_only_beyond_what_is_taken(read: int) -> None:
    builder = NetBuilder("taken")
    for place, tokens in (("other", 0), ("stock", 4), ("out", 0)):
        builder.place(place, initial=tokens)
    builder.transition("take", consume={"stock": 2}, read={"stock": read}, produce=["out"])
    net = builder.build()
    markings = all_markings(net)
    assert markings is not None
    for left in (0, 2):
        goal = AtMost(((net.place_index["stock"], 1),), left)
        reached = any(is_goal(goal, net, marking) for marking in markings)
        assert reached == (left == 2 or read <= 2)
        if reached:
            assert StateEquation(net).solve(goal).kind == "possible"
    empty = negated(marked(net.place_index["stock"]), net)
    if read > 2:  # a trap: the last two tokens can never be taken
        assert StateEquation(net).solve(empty).kind == "unreachable"
