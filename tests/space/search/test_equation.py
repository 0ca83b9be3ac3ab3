"""What the state equation rules out is not reachable."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.net.formats import read_net
from mcpn.net.petri import NetBuilder
from mcpn.net.reduce.reduction import reduce_for_deadlock
from mcpn.space.search.equation import StateEquation
from mcpn.space.search.goal import DEADLOCK, And, AtMost, Goal, marked
from mcpn.space.search.searches import Searches
from tests.space.search.goals import all_markings, goals, is_goal, negated
from tests.space.search.test_portfolio import PLAIN_NETS


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
