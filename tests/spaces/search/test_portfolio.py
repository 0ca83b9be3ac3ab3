"""What the portfolio says of reachability, against every marking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.logic.behaviour import check_net
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.search import INITIAL_STATE, REDUCTION, portfolio
from mcpn.spaces.search.goal import DEADLOCK, And, AtMost, Goal, marked
from mcpn.spaces.search.portfolio import ROUNDS, Portfolio, Round, SearchResult
from mcpn.spaces.search.searches import Searches, replay
from tests.nets.nets import counter, nets, state_machines
from tests.spaces.search.goals import all_markings, goals, is_goal

PLAIN_NETS = (
    nets(max_weight=1, events=False)
    | nets(max_weight=2, events=False)
    | nets(max_places=8, max_transitions=8, max_weight=1, events=False)
    | state_machines().map(lambda pair: pair[0])
)
# Walks of no length, so that reductions and searches have to answer.
NO_WALKS = (Round(0, 100_000),)
# Short ones, so that those of what reductions leave may come further.
SHORT_WALKS = (Round(2, 1), Round(4, 1), Round(8, 100_000))
# Hardly any search, so that the state equation has to answer, or leads a walk, or leaves the goal open.
EQUATION = (Round(0, 2, equation=True), Round(0, 100_000))
LED = (Round(3, 1, equation=True), Round(6, 1, equation=True), Round(0, 100_000))
WAYS = (ROUNDS[:1], NO_WALKS, SHORT_WALKS, EQUATION, LED)


def decide(net: PetriNet, asked: Sequence[Goal], rounds: tuple[Round, ...]) -> dict[int, SearchResult]:
    """What is found by walks of no more firings than the rounds say, where they say few."""
    with pytest.MonkeyPatch.context() as patch:
        if rounds is not WAYS[0]:
            patch.setattr(portfolio, "STEPS_OF_TRANSITION", 0)
        return dict(Portfolio(net).decide(asked, rounds))


def confirm(net: PetriNet, goal: Goal, found: SearchResult, *, reachable: bool) -> None:
    assert found.reachable == reachable
    if found.reachable:
        assert found.run is not None
        assert is_goal(goal, net, replay(net, found.run))


@given(st.data(), st.sampled_from(WAYS))
def test_goals_are_decided_as_every_marking_says(data: st.DataObject, rounds: tuple[Round, ...]) -> None:
    net = data.draw(PLAIN_NETS)
    asked: list[Goal] = data.draw(st.lists(goals(net), min_size=1, max_size=3))
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    decided = decide(net, asked, rounds)
    assert decided.keys() == set(range(len(asked)))
    for index, found in decided.items():
        expected = any(is_goal(asked[index], net, marking) for marking in markings)
        confirm(net, asked[index], found, reachable=expected)


@given(PLAIN_NETS, st.sampled_from(WAYS))
def test_deadlocks_are_decided_as_every_marking_says(net: PetriNet, rounds: tuple[Round, ...]) -> None:
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    found = decide(net, [DEADLOCK], rounds)[0]
    confirm(net, DEADLOCK, found, reachable=any(net.enabled(marking) == [] for marking in markings))


def test_what_holds_at_first_needs_no_search() -> None:
    @given(PLAIN_NETS)
    def check(net: PetriNet) -> None:
        place = next((p for p, tokens in enumerate(net.initial) if tokens), None)
        assume(place is not None)
        assert place is not None
        ((_, found),) = Portfolio(net).decide([marked(place)], ())
        assert found == SearchResult(True, (), (INITIAL_STATE,))

    check()


@pytest.mark.parametrize(
    ("model", "deadlock"),
    [("Philosophers-PT-000500", True), ("Solitaire-PT-SqrNC5x5", True), ("RwMutex-PT-r0010w0010", False)],
)
def test_deadlocks_of_large_nets(mcc: Path, model: str, deadlock: bool) -> None:
    net = read_net(mcc / model / "model.pnml")
    ((_, found),) = Portfolio(net).decide([DEADLOCK])
    assert found.reachable is deadlock
    if found.run is not None:
        assert net.enabled(replay(net, found.run)) == []


def line(places: str, *more: tuple[str, str], first: int = 1) -> PetriNet:
    """Tokens that go from the first place on to the next, by each transition from one place to another."""
    builder = NetBuilder("line")
    for place in places:
        builder.place(place, initial=first if place == places[0] else 0)
    for source, target in (*pairwise(places), *more):
        builder.transition(source + target, consume=[source], produce=[target])
    return builder.build()


@pytest.mark.parametrize("rounds", WAYS)
def test_every_way_finds_the_end_of_a_line(rounds: tuple[Round, ...]) -> None:
    net = line("abcdefgh", ("b", "a"), ("c", "a"), first=3)
    end, start = net.place_index["h"], net.place_index["a"]
    everything = AtMost(((end, -1),), -3)
    too_much = AtMost(((start, -1), (end, -1)), -4)
    found = decide(net, [everything, too_much, DEADLOCK], rounds)
    confirm(net, everything, found[0], reachable=True)
    confirm(net, too_much, found[1], reachable=False)  # no more tokens than there are
    confirm(net, DEADLOCK, found[2], reachable=True)
    if rounds is not WAYS[0]:
        assert all(REDUCTION in finding.techniques for finding in found.values())


@pytest.mark.parametrize("rounds", WAYS)
def test_a_run_to_a_deadlock_goes_on_until_nothing_may_fire(rounds: tuple[Round, ...]) -> None:
    # Dead once the key is lost; where a smaller net shows that, a first step may be left to do.
    builder = NetBuilder("key")
    for place, tokens in (("mid", 0), ("start", 1), ("key", 1), ("out", 0), ("lost", 0)):
        builder.place(place, initial=tokens)
    builder.transition("first", consume=["start"], produce=["mid"])
    builder.transition("second", consume=["mid", "key"], produce=["out"])
    builder.transition("again", consume=["out"], produce=["start", "key"])
    builder.transition("lose", consume=["key"], produce=["lost"])
    net = builder.build()
    confirm(net, DEADLOCK, decide(net, [DEADLOCK], rounds)[0], reachable=True)


def test_what_no_budget_decides_is_left_out() -> None:
    net = line("ab", ("b", "a"), first=40)
    goal = AtMost(((1, -1),), -40)
    assert decide(net, [goal, marked(0)], (Round(0, 0),)) == {1: SearchResult(True, (), (INITIAL_STATE,))}
    rounds = (Round(0, 0), Round(0, 0), Round(0, 100_000))
    assert decide(net, [goal], rounds).keys() == {0}
    # What is asked for no longer is left.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(portfolio, "STEPS_OF_TRANSITION", 0)
        assert set(Portfolio(net).going_on([goal], rounds[2], 0, lambda _: False)) <= {None}
        assert dict(Portfolio(net).decide([goal], rounds[2:])).keys() == {0}


def test_check_of_an_unbounded_net_says_whether_it_can_die() -> None:
    builder = NetBuilder("grows")
    for place, tokens in (("on", 1), ("off", 0), ("heap", 0)):
        builder.place(place, initial=tokens)
    builder.transition("grow", read=["on"], produce=["heap"])
    builder.transition("stop", consume=["on"], produce=["off"])
    found = check_net(builder.build())
    assert found.bounded.bounded is False
    assert (found.deadlock_free, found.deadlock) == (False, ("stop",))
    builder.transition("restart", consume=["off"], produce=["on"])
    found = check_net(builder.build())
    assert (found.deadlock_free, found.deadlock) == (True, None)


def test_numbers_beyond_those_that_are_followed_are_left_to_others() -> None:
    for tokens, weight in ((2**31, 1), (1, 2**31), (2**31 - 1, 2**31 - 1)):
        builder = NetBuilder("many")
        builder.place("many", initial=tokens)
        builder.place("none")
        builder.transition("t", consume={"many": weight}, produce=["none"])
        net = builder.build()
        fits = max(tokens, weight) < 2**31
        assert Searches(net).fits is fits
        found = dict(Portfolio(net).decide([marked(1), marked(0)], ROUNDS[:1]))
        assert found.keys() == ({0, 1} if fits else {1})
        if fits:
            confirm(net, marked(1), found[0], reachable=True)


def test_a_goal_that_many_markings_are_before_is_found_in_a_later_round() -> None:
    """The one run to it is longer than what walks and the first rounds look at."""
    net = counter(18)
    goal = And(*(marked(net.place_index[f"one{bit}"]) for bit in range(18)))
    rounds = [replace(budget, steps=0) for budget in ROUNDS]
    ((_, found),) = Portfolio(net).decide([goal], rounds)
    assert found.reachable
    assert found.run is not None
    assert len(found.run) == 2**18 - 1
