"""What the portfolio says of reachability, against every marking."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.check.nets.properties import check_net
from mcpn.net.formats import read_net
from mcpn.net.petri import NetBuilder, PetriNet
from mcpn.space.search.goal import DEADLOCK, Goal, marked
from mcpn.space.search.portfolio import INITIAL_STATE, ROUNDS, Finding, Portfolio, Round
from mcpn.space.search.searches import replay
from tests.net.nets import nets, state_machines
from tests.space.search.goals import all_markings, goals, is_goal

PLAIN_NETS = (
    nets(max_weight=1, events=False)
    | nets(max_weight=2, events=False)
    | nets(max_places=8, max_transitions=8, max_weight=1, events=False)
    | state_machines().map(lambda pair: pair[0])
)
# Walks of no length, so that reductions and searches have to answer.
NO_WALKS = (Round(0, 100_000),)
# Hardly any search, so that the state equation has to answer, or leaves the goal open.
EQUATION = (Round(0, 2, equation=True), Round(0, 100_000))


def confirm(net: PetriNet, goal: Goal, found: Finding, *, reachable: bool) -> None:
    assert found.reachable == reachable
    if found.reachable:
        assert found.run is not None
        assert is_goal(goal, net, replay(net, found.run))


@given(st.data(), st.sampled_from([ROUNDS[:1], NO_WALKS, EQUATION]))
def test_goals_are_decided_as_every_marking_says(data: st.DataObject, rounds: tuple[Round, ...]) -> None:
    net = data.draw(PLAIN_NETS)
    asked: list[Goal] = data.draw(st.lists(goals(net), min_size=1, max_size=3))
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    decided = dict(Portfolio(net).decide(asked, rounds))
    assert decided.keys() == set(range(len(asked)))
    for index, found in decided.items():
        expected = any(is_goal(asked[index], net, marking) for marking in markings)
        confirm(net, asked[index], found, reachable=expected)


@given(PLAIN_NETS, st.sampled_from([ROUNDS[:1], NO_WALKS, EQUATION]))
def test_deadlocks_are_decided_as_every_marking_says(net: PetriNet, rounds: tuple[Round, ...]) -> None:
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    ((_, found),) = Portfolio(net).decide([DEADLOCK], rounds)
    confirm(net, DEADLOCK, found, reachable=any(net.enabled(marking) == [] for marking in markings))


def test_what_holds_at_first_needs_no_search() -> None:
    @given(PLAIN_NETS)
    def check(net: PetriNet) -> None:
        place = next((p for p, tokens in enumerate(net.initial) if tokens), None)
        assume(place is not None)
        assert place is not None
        ((_, found),) = Portfolio(net).decide([marked(place)], ())
        assert found == Finding(True, (), (INITIAL_STATE,))

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
