"""Steps and closures on graphs in arrays, against plain definitions."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn import _kernel
from mcpn.net.petri import NetBuilder
from mcpn.space.markings.graph import Mask, StateGraph

Edges = list[tuple[int, int]]


def listed(states: int, edges: Edges) -> StateGraph:
    """A graph without net; edges in the order of their sources."""
    ordered = sorted(edges, key=lambda edge: edge[0])
    counts = np.bincount([s for s, _ in ordered], minlength=states) if ordered else np.zeros(states, np.int64)
    offsets = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
    targets = np.array([t for _, t in ordered], np.uint32)
    return StateGraph(
        NetBuilder("none").build(),
        np.zeros((states, 1), np.uint64),
        offsets,
        targets,
        targets.astype(np.int64),
    )


def mask(states: int, members: set[int]) -> Mask:
    return np.isin(np.arange(states), list(members))


def members(found: Mask) -> set[int]:
    return set(np.flatnonzero(found).tolist())


def reaching(edges: Edges, goal: set[int], along: set[int]) -> set[int]:
    found = set(goal)
    while more := {s for s, t in edges if t in found and s in along} - found:
        found |= more
    return found


def staying(edges: Edges, along: set[int]) -> set[int]:
    left = set(along)
    while lost := {
        s for s in left if any(a == s for a, _ in edges) and not any(a == s and t in left for a, t in edges)
    }:
        left -= lost
    return left


def compare(states: int, edges: Edges, goal: set[int], along: set[int]) -> None:
    graph = listed(states, edges)
    inside, wanted = mask(states, along), mask(states, goal)
    rows = graph.offsets, graph.targets.astype(np.uint32)
    back = _kernel.incoming(*rows)
    assert members(graph.before(wanted)) == {s for s, t in edges if t in goal}
    found = reaching(edges, goal, along)
    assert members(graph.reaching(wanted, None, inside)) == found
    assert members(_kernel.spread(*back, wanted, inside)) == found
    turned = [(t, s) for s, t in edges]
    assert members(graph.reached(None, wanted, inside)) == reaching(turned, goal, along)
    left = staying(edges, along)
    assert members(graph.staying(inside)) == left
    assert members(_kernel.staying(*rows, *back, inside)) == left
    assert graph.stays(wanted, inside) == bool(goal & left)


@given(st.data())
def test_closures_are_what_they_say(data: st.DataObject) -> None:
    states = data.draw(st.integers(1, 8))
    one = st.integers(0, states - 1)
    edges = data.draw(st.lists(st.tuples(one, one), max_size=16))
    compare(states, edges, data.draw(st.sets(one)), data.draw(st.sets(one)))
    keep = np.array([data.draw(st.booleans()) for _ in edges], np.bool_)
    kept = [
        edge for edge, wanted in zip(sorted(edges, key=lambda edge: edge[0]), keep, strict=True) if wanted
    ]
    graph, goal = listed(states, edges), data.draw(st.sets(one))
    assert members(graph.reaching(mask(states, goal), keep)) == reaching(kept, goal, set(range(states)))
    assert members(graph.before(mask(states, goal), keep)) == {s for s, t in kept if t in goal}


def test_a_long_way_to_and_fro_is_gone_to_its_end() -> None:
    states = 400  # each sweep goes one step of it
    way = [number for pair in zip(range(200), range(399, 199, -1), strict=True) for number in pair]
    edges = list(pairwise(way))
    everything = set(range(states))
    compare(states, edges, {way[-1]}, everything)
    compare(states, [*edges, (way[-1], way[-1])], {way[0]}, everything - {way[-1]})


def test_arrays_that_are_no_graph_are_refused() -> None:
    offsets, targets = np.array([0, 1], np.int64), np.array([7], np.uint32)
    some = np.ones(1, np.bool_)
    for wrong in (
        lambda: _kernel.before(offsets, targets, some),
        lambda: _kernel.before(np.array([0, 2], np.int64), targets, some),
        lambda: _kernel.before(np.array([0, 2, 1], np.int64), targets, some),
        lambda: _kernel.spread(offsets, targets, np.ones(2, np.bool_)),
        lambda: _kernel.incoming(offsets, targets, np.ones(2, np.bool_)),
        lambda: _kernel.weigh(np.zeros((1, 1), np.uint64), [(1, 0, 1, 1)]),
        lambda: _kernel.satisfying(np.zeros((1, 1), np.uint64), [[([(0, 60, 5, 1)], 1)]]),
    ):
        with pytest.raises(ValueError, match=r"no such|one row|another size"):
            wrong()
