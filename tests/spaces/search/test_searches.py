"""Walks and searches against every marking."""

from __future__ import annotations

import csv
import gc
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.errors import LimitError
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.search import searches
from mcpn.spaces.search.goal import DEADLOCK, And, AtMost, marked
from mcpn.spaces.search.searches import Searches, Seeking, replay, shortened
from mcpn.testing.nets import philosophers
from mcpn.turns import finished
from tests.nets.nets import counter, nets, state_machines
from tests.spaces.search.goals import all_markings, goals, is_goal
from tests.spaces.search.test_portfolio import PLAIN_NETS

ANY_NETS = nets(max_weight=1) | nets(max_weight=2) | state_machines().map(lambda pair: pair[0])


def respects_priorities(net: PetriNet, run: tuple[int, ...]) -> bool:
    marking = net.initial
    for t in run:
        if t not in net.enabled(marking):
            return False
        marking = net.fire(marking, t)
    return True


@given(st.data())
def test_each_search_finds_what_is_reachable_and_nothing_else(data: st.DataObject) -> None:
    net = data.draw(ANY_NETS)
    goal = data.draw(goals(net))
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    expected, search = any(is_goal(goal, net, marking) for marking in markings), Searches(net)
    for found in (
        *(search.seek(goal, max_states=100_000, stubborn=stubborn) for stubborn in (True, False)),
        search.plan(goal, max_states=100_000, seed=data.draw(st.integers(0, 9))),
    ):
        assert found.outcome == ("reached" if expected else "unreachable")
        assert found.states <= len(markings)
        if expected:
            assert respects_priorities(net, found.run)
            assert is_goal(goal, net, replay(net, found.run))


def test_a_greedy_search_comes_far_where_a_search_of_the_nearest_is_lost() -> None:
    """Each of twenty counters is raised once to open the next door, and lowered again before the end."""
    builder = NetBuilder("doors")
    doors = 20
    for i in range(doors):
        builder.place(f"off{i}", initial=1)
        builder.place(f"on{i}")
        builder.place(f"room{i}", initial=int(i == 0))
        builder.transition(f"raise{i}", consume=[f"off{i}"], produce=[f"on{i}"])
        builder.transition(f"lower{i}", consume=[f"on{i}"], produce=[f"off{i}"])
    builder.place("end")
    for i in range(doors):
        builder.transition(
            f"go{i}",
            consume=[f"room{i}"],
            produce=[f"room{i + 1}" if i + 1 < doors else "end"],
            read=[f"on{i}"],
        )
    net = builder.build()
    goal = And(marked(net.place_index["end"]), marked(net.place_index["off0"]))
    assert Searches(net).seek(goal, max_states=2_000, stubborn=False).outcome == "states"
    found = Searches(net).plan(goal, max_states=2_000)
    assert found.outcome == "reached"
    assert is_goal(goal, net, replay(net, found.run))


@given(st.data())
def test_walks_replay_and_end_in_the_goal(data: st.DataObject) -> None:
    net = data.draw(ANY_NETS)
    asked = data.draw(st.lists(goals(net), min_size=1, max_size=3))
    counts = data.draw(st.just([]) | st.just([1] * len(net.transitions)))
    found = Searches(net).walk(asked, steps=500, seed=data.draw(st.integers(0, 9)), counts=counts)
    for index, run in found.items():
        assert respects_priorities(net, run)
        assert is_goal(asked[index], net, replay(net, run))
    for index, goal in enumerate(asked):
        if is_goal(goal, net, net.initial):
            assert found[index] == ()


@pytest.mark.parametrize("count", [2, 400])
def test_components_that_all_do_the_same_first_lock_each_other(count: int) -> None:
    """A family whose two dead markings are known: nobody who draws a walk of 400 philosophers meets one."""
    net = philosophers(count)
    for seed in (0, 1):
        (run,) = Searches(net).walk([DEADLOCK], steps=100 * count, seed=seed).values()
        assert count == 2 or len(run) == 2 * count  # each wakes, and takes the fork of one side
        assert not net.enabled(replay(net, run))


@given(ANY_NETS)
def test_unsafe_firings_that_a_walk_finds_are_unsafe(net: PetriNet) -> None:
    error = Searches(net).walk_unsafe(steps=500)
    if max(net.initial, default=0) > 1:
        assert error is not None
        assert not error.transition
        assert net.initial[net.place_index[error.place]] > 1
        return
    markings = all_markings(net)
    if error is None:
        if markings is not None and len(markings) < 5:
            assert all(max(marking) < 2 for marking in markings)
        return
    run = [net.transition_index[name] for name in error.run]
    before = replay(net, run)
    assert respects_priorities(net, (*run, net.transition_index[error.transition]))
    assert net.marked(before) == error.marking
    after = net.fire(before, net.transition_index[error.transition])
    assert after[net.place_index[error.place]] > 1


@given(ANY_NETS, st.lists(st.integers(0, 5), max_size=30), st.booleans())
def test_a_shortened_run_ends_in_the_same_marking(net: PetriNet, choices: list[int], told: bool) -> None:
    run: list[int] = []
    marking, passed = net.initial, {net.initial}
    for choice in choices:
        enabled = net.enabled(marking)
        if not enabled:
            break
        run.append(enabled[choice % len(enabled)])
        marking = net.fire(marking, run[-1])
        passed.add(marking)
    with pytest.MonkeyPatch.context() as patch:
        if not told:  # all markings have one key
            patch.setattr(searches, "_mark", lambda place, tokens: 0)
        short = shortened(net, run)
    assert replay(net, short) == marking
    assert not told or len(short) < len(passed)


def test_a_long_run_is_shortened_in_time_linear_in_it() -> None:
    count = 20_000
    builder = NetBuilder("many")
    for number in range(count):
        builder.place(f"a{number}", initial=1)
        builder.transition(f"t{number}", consume=[f"a{number}"], produce=[f"b{number}"])
        builder.transition(f"u{number}", consume=[f"b{number}"], produce=[f"a{number}"])
        builder.place(f"b{number}")
    net = builder.build()
    run = [2 * number for number in range(count)]
    # As sets of the places that differ these markings would be 200 million entries.
    assert shortened(net, [*run[:5], 1, 0, *run[5:]]) == tuple(run)


def test_limits_are_told() -> None:
    net = counter(12)
    goal = And(*(marked(net.place_index[f"one{bit}"]) for bit in range(12)))
    assert Searches(net).seek(goal, max_states=100).outcome == "states"
    assert Searches(net).seek(goal, max_states=10**6, max_bytes=10_000).outcome == "bytes"
    found = Searches(net).seek(goal, max_states=10**6)
    assert (found.outcome, len(found.run)) == ("reached", 4095)


@pytest.mark.parametrize("greedy", [True, False])
def test_a_search_rests_and_goes_on_from_where_a_limit_has_ended_it(*, greedy: bool) -> None:
    net = counter(12)
    goal = And(*(marked(net.place_index[f"one{bit}"]) for bit in range(12)))
    searches = Searches(net)
    search = searches.planning(goal) if greedy else searches.seeking(goal)
    work = search.searching(3_000)
    assert len([*work]) >= 2
    ends = [finished(search.searching(limit)) for limit in (3_000, 3_500, 10**6)]
    assert [end.outcome for end in ends] == ["states", "states", "reached"]
    at_once = (searches.plan if greedy else searches.seek)(goal, max_states=10**6)
    assert ends[-1] == at_once


@pytest.mark.parametrize("greedy", [True, False])
def test_a_search_keeps_the_net_and_the_goal_that_it_is_about(*, greedy: bool) -> None:
    def begun() -> Seeking:
        net = counter(8)
        goal = And(*(marked(net.place_index[f"one{bit}"]) for bit in range(8)))
        return Searches(net).planning(goal) if greedy else Searches(net).seeking(goal)

    search = begun()
    gc.collect()
    counter(9)
    assert len(finished(search.searching(10**6)).run) == 255


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, -1)])
def test_weights_up_to_the_limit_are_searched_and_those_beyond_told(signs: tuple[int, int]) -> None:
    builder = NetBuilder("two tokens")
    builder.place("p", initial=1)
    builder.place("q", initial=1)
    builder.place("left")
    builder.transition("leave", consume=["p", "q"], produce=["left"])
    net = builder.build()
    one, other = signs

    def least(weights: tuple[int, int]) -> AtMost:
        """Holds where the sum is as small as it becomes: with both tokens, or without."""
        return AtMost(tuple(enumerate(weights)), min(sum(weights), 0))

    at_limit = least((one * (2**29 - 1), other))
    assert Searches(net).seek(at_limit, max_states=10).outcome == "reached"
    assert 0 in Searches(net).walk([at_limit], steps=10)
    for beyond in ((one * 2**29, other), (one * 2**28, other * 2**29), (one, other * 10**30)):
        with pytest.raises(LimitError, match=str(sum(map(abs, beyond)))):
            Searches(net).seek(least(beyond), max_states=10)
        with pytest.raises(LimitError, match=str(2**29)):
            Searches(net).walk([at_limit, And(marked(2), least(beyond))], steps=10)


def test_a_place_that_grows_for_ever_is_given_up() -> None:
    builder = NetBuilder("source")
    builder.place("p")
    builder.place("never")
    builder.transition("t", produce={"p": 2**30})
    found = Searches(builder.build()).seek(AtMost(((1, -1),), -1), max_states=10**6, stubborn=False)
    assert found.outcome == "tokens"


def test_stubborn_sets_leave_out_interleavings() -> None:
    builder = NetBuilder("side by side")
    for i in range(10):
        builder.place(f"a{i}", initial=1)
        builder.place(f"b{i}")
        builder.transition(f"t{i}", consume=[f"a{i}"], produce=[f"b{i}"])
    builder.place("stays", initial=1)
    builder.transition("loop", read=["stays"])
    net = builder.build()
    found = Searches(net).seek(DEADLOCK, max_states=10_000)
    assert found.outcome == "unreachable"
    assert found.states <= 11
    assert Searches(net).seek(DEADLOCK, max_states=10_000, stubborn=False).states == 1024


def test_the_deadlocks_of_the_contest(mcc: Path) -> None:
    with (mcc / "oracles.tsv").open(newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    decided = 0
    for row in rows:
        if row["deadlock_exists"] not in ("TRUE", "FALSE") or int(row["transitions"]) > 1000:
            continue
        net = read_net(mcc / row["model"] / "model.pnml")
        found = Searches(net).seek(DEADLOCK, max_states=3000)
        if found.outcome in ("reached", "unreachable"):
            decided += 1
            assert (found.outcome == "reached") == (row["deadlock_exists"] == "TRUE"), row["model"]
            if found.run:
                assert net.enabled(replay(net, found.run)) == []
    assert decided > 25


def test_a_goal_that_names_no_place_is_refused() -> None:
    with pytest.raises(ValueError, match="place"):
        Searches(counter(2)).seek(AtMost(((9, 1),), 0), max_states=10)


@given(PLAIN_NETS)
def test_walks_come_to_reachable_markings_and_stay_in_a_dead_one(net: PetriNet) -> None:
    markings = all_markings(net)
    assume(markings is not None)
    assert markings is not None
    ends = [tuple(end) for end in Searches(net).ends(steps=400, walks=3)]
    assert len(ends) == 3
    assert markings.issuperset(ends)
    if not net.enabled(net.initial):
        assert set(ends) == {net.initial}
