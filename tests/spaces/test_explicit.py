"""The explicit markings graph, against a plain explorer that shares no code with it, and the contest."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.markings.explicit import KernelNet, count, explore
from mcpn.spaces.markings.graph import StateGraph
from mcpn.steps import WorkStep, heard_by
from tests.nets.nets import nets, reachable
from tests.shares import returns_early


@given(nets(max_weight=2))
def test_the_same_graph_as_by_the_plain_rule(net: PetriNet) -> None:
    markings, edges, safe = reachable(net)
    if not safe:
        with pytest.raises(UnsafeError) as caught:
            explore(net)
        check_unsafe_run(net, caught.value)
        return
    graph = explore(net)
    assert {graph.marking(s) for s in range(graph.states)} == markings.keys()
    assert (graph.states, graph.edges) == (len(markings), edges)
    for state in range(graph.states):
        marking = graph.marking(state)
        fired = [(t, graph.marking(target)) for t, target in graph.successors(state)]
        assert fired == [(t, net.fire(marking, t)) for t in net.enabled(marking)]


def check_unsafe_run(net: PetriNet, error: UnsafeError) -> None:
    """The run of an unsafety replays, is as short as can be, and ends in two tokens."""
    marking = net.initial
    for name in error.run:
        number = net.transition_index[name]
        assert number in net.enabled(marking)
        marking = net.fire(marking, number)
        assert max(marking) <= 1
    assert net.marked(marking) == error.marking
    place = net.place_index[error.place]
    if error.transition:
        number = net.transition_index[error.transition]
        assert number in net.enabled(marking)
        assert net.fire(marking, number)[place] > 1
        assert len(error.run) == first_unsafe_distance(net)
    else:
        assert net.initial[place] > 1


def first_unsafe_distance(net: PetriNet) -> int:
    markings, _, _ = reachable(net)
    return min(
        distance
        for marking, distance in markings.items()
        for t in net.enabled(marking)
        if max(net.fire(marking, t)) > 1
    )


@given(nets())
def test_runs_are_shortest_and_backward_search_agrees(net: PetriNet) -> None:
    markings, _, safe = reachable(net)
    if not safe:
        returns_early("not safe")
        return
    graph = explore(net)
    for state in range(min(graph.states, 20)):
        goal = np.arange(graph.states) == state
        run = graph.run_to(goal)
        assert run is not None
        assert len(run) == markings[graph.marking(state)]
        at = 0
        for edge in run:
            assert graph.sources[edge] == at
            at = int(graph.targets[edge])
        assert at == state
        before = graph.reaching(goal)
        for other in range(min(graph.states, 20)):
            assert bool(before[other]) == (graph.run_to(goal, other) is not None)


def test_ulysse_has_the_markings_that_others_counted(ulysse_markings: StateGraph) -> None:
    # Counted by two independent explorers before this program was written.
    assert (ulysse_markings.states, ulysse_markings.edges) == (44299, 124078)


def test_the_reference_net_has_the_same_counts(reference: Path) -> None:
    graph = explore(read_net(reference / "ulysse_reference.net"))
    assert (graph.states, graph.edges) == (44299, 124078)


def test_a_converted_net_has_the_same_graph(
    ulysse_net: MissionNet, ulysse_markings: StateGraph, tmp_path: Path
) -> None:
    from mcpn.nets.formats import save_net

    save_net(ulysse_net.net, tmp_path / "u.net")
    graph = explore(read_net(tmp_path / "u.net"))
    assert np.array_equal(graph.markings, ulysse_markings.markings)
    assert np.array_equal(graph.targets, ulysse_markings.targets)


def ring(size: int) -> PetriNet:
    """A token that runs round: as many markings as places."""
    builder = NetBuilder("ring")
    for i in range(size):
        builder.place(f"p{i}", initial=int(i == 0))
    for i in range(size):
        builder.transition(f"t{i}", consume=[f"p{i}"], produce=[f"p{(i + 1) % size}"])
    return builder.build()


def switches(size: int) -> PetriNet:
    """Independent switches: 2^n markings, n * 2^n firings."""
    builder = NetBuilder("switches")
    for i in range(size):
        builder.place(f"off{i}", initial=1)
        builder.place(f"on{i}")
        builder.transition(f"up{i}", consume=[f"off{i}"], produce=[f"on{i}"])
        builder.transition(f"down{i}", consume=[f"on{i}"], produce=[f"off{i}"])
    return builder.build()


@pytest.mark.parametrize("size", [1, 63, 64, 65, 200])
def test_rings_of_any_width(size: int) -> None:
    graph = explore(ring(size))
    assert (graph.states, graph.edges) == (size, size)


def test_switches_have_the_closed_form() -> None:
    graph = explore(switches(10))
    assert (graph.states, graph.edges) == (2**10, 10 * 2**10)


def test_limits_say_which_was_hit() -> None:
    with pytest.raises(LimitError, match="more than 100 states"):
        explore(switches(10), max_states=100)
    with pytest.raises(LimitError, match="limit on memory"):
        explore(switches(10), max_memory=10_000)


def test_a_net_without_transitions_or_places() -> None:
    assert explore(NetBuilder("empty").build()).states == 1


def test_the_contest_s_small_safe_nets(mcc: Path, mcc_oracles: dict[str, dict[str, str]]) -> None:
    checked = 0
    for model, row in mcc_oracles.items():
        if row["safe"] != "1-safe" or int(row["states"]) > 300_000:
            continue
        graph = explore(read_net(mcc / model / "model.pnml"))
        assert (graph.states, graph.edges) == (int(row["states"]), int(row["edges"])), model
        assert bool(graph.dead.any()) == (row["deadlock_exists"] == "TRUE"), model
        tokens = int(np.bitwise_count(graph.markings).sum(axis=1).max())
        assert tokens == int(row["max_tokens_per_marking"]), model
        checked += 1
    assert checked == 25


def test_the_contest_s_unsafe_nets_are_found_unsafe(
    mcc: Path, mcc_oracles: dict[str, dict[str, str]]
) -> None:
    unsafe = [model for model, row in mcc_oracles.items() if row["safe"] != "1-safe"]
    assert len(unsafe) == 5
    for model in unsafe:
        net = read_net(mcc / model / "model.pnml")
        with pytest.raises(UnsafeError) as caught:
            explore(net)
        check_unsafe_run(net, caught.value)


@pytest.mark.parametrize("width", [40, 1500])
def test_progress_is_told_and_its_errors_stop_the_exploration(width: int) -> None:
    class Enough(Exception):
        pass

    told: list[tuple[int, int]] = []

    class Impatient:
        def begins(self, step: WorkStep) -> None:
            pass

        def comes_to(self, states: int, edges: int) -> None:
            told.append((states, edges))
            raise Enough

    with heard_by(Impatient()), pytest.raises(Enough):
        count(switches(width))
    ((states, edges),) = told
    assert 0 < states < edges + 2


@pytest.mark.parametrize("places", [40, 62, 63, 64, 65])
def test_counts_without_edges_are_those_with_them(places: int) -> None:
    builder = NetBuilder("cells")  # 2^16 markings, and one of them marks every place
    for place in range(places):
        builder.place(f"p{place}", initial=1)
    for place in range(16):
        builder.transition(f"t{place}", consume=[f"p{place}"], read=[f"p{places - 1}"], produce=[])
    prepared = KernelNet(builder.build())
    listed, counted = (
        prepared.kernel.explore(prepared.initial, edges, 1 << 20, 1 << 30) for edges in (True, False)
    )
    assert counted.states == listed.states == 1 << 16
    assert (counted.edges, counted.dead, counted.most_tokens) == (listed.edges, listed.dead, places)
    assert counted.take_markings().tolist() == listed.take_markings().tolist()


def test_counts_have_limits_that_say_which() -> None:
    with pytest.raises(LimitError, match="limit on states"):
        count(switches(30), max_states=1000)
    with pytest.raises(LimitError, match="limit on memory"):
        count(switches(30), max_memory=3_000_000)


@given(nets(), st.lists(st.integers(1, 60), min_size=1, max_size=6))
def test_an_exploration_that_stops_now_and_then_finds_the_same(net: PetriNet, budgets: list[int]) -> None:
    prepared = KernelNet(net)
    whole = prepared.kernel.explore(prepared.initial, False, 1 << 20, 1 << 30)
    explorer = prepared.kernel.explorer(prepared.initial, 1 << 30)
    for firings in cycle(budgets):
        if explorer.run(firings):
            break
        assert explorer.explored <= explorer.states <= whole.states
    found = explorer.take()
    assert (found.states, found.edges, found.dead, found.stable) == (
        whole.states,
        whole.edges,
        whole.dead,
        whole.stable,
    )
    assert (found.trouble, found.most_tokens) == (whole.trouble, whole.most_tokens)
    assert found.take_markings().tolist() == whole.take_markings().tolist()
    with pytest.raises(ValueError, match="taken"):
        explorer.run(1)


def test_edges_are_forgotten_where_memory_is_wanted_for_markings() -> None:
    prepared = KernelNet(switches(14))
    for limit, kept in ((1 << 30, True), (1_500_000, False)):
        explorer = prepared.kernel.explorer(prepared.initial, limit, True)
        assert explorer.run(0)
        found = explorer.take()
        assert (found.states, found.edges) == (1 << 14, 14 << 14)
        assert bool(len(found.take_offsets())) == bool(len(found.take_targets())) == kept
