"""Steps and closures on graphs in arrays, against plain definitions."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from itertools import islice, pairwise, repeat, starmap
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn import _kernel
from mcpn.nets.petri import NetBuilder
from mcpn.spaces.markings.graph import Mask, StateGraph

Edges = list[tuple[int, int]]
BITS = st.sampled_from([(0, 63), (0, 0), (1, 5)])
"""A word, and a bit in it."""


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


NARROW = st.integers(-3, 3) | st.integers(-(2**63), 2**63 - 1)


@given(st.data())
def test_sums_of_tokens_are_those_of_whole_numbers(data: st.DataObject) -> None:
    words = data.draw(st.integers(1, 3))
    rows = data.draw(
        st.lists(st.lists(st.integers(0, 2**64 - 1), min_size=words, max_size=words), min_size=1, max_size=5)
    )
    markings = np.array(rows, np.uint64)

    def terms() -> list[tuple[int, int, int, int]]:
        found = []
        for _ in range(data.draw(st.integers(0, 6))):
            shift = data.draw(st.integers(0, 63))
            width = data.draw(st.integers(1, min(63, 64 - shift)))
            found.append((data.draw(st.integers(0, words - 1)), shift, width, data.draw(NARROW)))
        return found

    def total(row: list[int], given: list[tuple[int, int, int, int]]) -> int:
        return sum(weight * (row[word] >> shift & 2**width - 1) for word, shift, width, weight in given)

    one = terms()
    sums = [total(row, one) for row in rows]
    if all(-(2**63) <= found < 2**63 for found in sums):
        assert _kernel.weigh(markings, one).tolist() == sums
    else:
        with pytest.raises(OverflowError, match="64 bits"):
            _kernel.weigh(markings, one)
    ways = []
    for _ in range(data.draw(st.integers(0, 3))):
        bounds = []
        for given_ in (one, terms())[: data.draw(st.integers(1, 2))]:
            near = total(data.draw(st.sampled_from(rows)), given_) + data.draw(st.integers(-1, 1))
            bounds.append((given_, data.draw(st.just(near) | NARROW)))
        ways.append(bounds)
    expected = [any(all(total(row, g) <= most for g, most in way) for way in ways) for row in rows]
    assert _kernel.satisfying(markings, ways).tolist() == expected


@given(st.lists(st.lists(st.tuples(BITS, st.sampled_from([-2, -1, 1, 2]), st.integers(-3, 3)), max_size=4)))
def test_conditions_on_single_bits_hold_together(ways: list[list[tuple[tuple[int, int], int, int]]]) -> None:
    """Also those that no state satisfies, or every one, or that are about one bit more than once."""
    rows = [[first << 63 | second, third << 5] for first in (0, 1) for second in (0, 1) for third in (0, 1)]
    asked = [[([(*bit, 1, weight)], most) for bit, weight, most in way] for way in ways]
    expected = [
        any(all(weight * (row[word] >> at & 1) <= most for (word, at), weight, most in way) for way in ways)
        for row in rows
    ]
    assert _kernel.satisfying(np.array(rows, np.uint64), asked).tolist() == expected


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


STATES = 1 << 18
TIMES = 3000
"""Calls that are begun at most: seconds of work, of which a signal leaves some undone."""


def chain(states: int) -> tuple[Any, Any]:
    """Each state leads to the next one, the last to none."""
    offsets = np.minimum(np.arange(states + 1), states - 1).astype(np.int64)
    return offsets, np.arange(1, states, dtype=np.uint32)


def long_calls() -> dict[str, tuple[Any, ...]]:
    """Calls with work to do on many states: the function and its arguments."""
    rows, every, number = chain(STATES), np.ones(STATES, np.bool_), np.arange(STATES)
    none, words = np.zeros(STATES, np.bool_), np.ones((STATES, 1), np.uint64)
    return {
        "incoming": (_kernel.incoming, *rows),
        "spread": (_kernel.spread, *rows, number == 0),
        "staying": (_kernel.staying, *rows, *_kernel.incoming(*rows), every),
        "stays": (_kernel.stays, *rows, number == 0, number < STATES - 1),
        "before": (_kernel.before, *rows, none),
        "sweep_reaching": (_kernel.sweep_reaching, *rows, none),
        "sweep_staying": (_kernel.sweep_staying, *rows, number < STATES - 1),
        "weigh": (_kernel.weigh, words, [(0, 0, 1, 1)] * 8),
        "satisfying": (_kernel.satisfying, words, [[([(0, 0, 1, 1)], 0)]] * 8),
    }


@pytest.mark.parametrize("name", long_calls())
def test_signals_are_heard_within_calls(name: str) -> None:
    """One built-in makes all calls, so that signals are heard within a call or when all of them are made."""
    call, *given = long_calls()[name]
    left = islice(repeat(given), TIMES)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            deque(starmap(call, left), maxlen=0)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert next(left, None) is not None


FIELDS = [(0, 0, 1), (0, 1, 1), (0, 63, 1), (1, 0, 1), (1, 5, 1), (0, 8, 3), (1, 40, 2)]
"""Word, lowest bit and width: bits, and counters beside them."""


@given(st.data())
def test_alternatives_hold_as_their_bounds_say(data: st.DataObject) -> None:
    """A marked bit that is enough, rare bits of others, and bounds on sums beside them find the same."""
    sums = st.lists(st.tuples(st.sampled_from(FIELDS), st.integers(-2, 2)), min_size=1, max_size=2)
    bounds = st.tuples(sums, st.integers(-2, 2)) | st.tuples(
        st.tuples(st.sampled_from(FIELDS[:5]), st.sampled_from([-1, 1])).map(lambda term: [term]),
        st.sampled_from([-1, 0]),
    )
    ways = data.draw(st.lists(st.lists(bounds, max_size=3), max_size=6))
    rows = data.draw(st.lists(st.tuples(*(st.integers(0, 2**width - 1) for *_, width in FIELDS)), max_size=6))
    markings = np.zeros((len(rows), 2), np.uint64)
    for row, tokens in zip(markings, rows, strict=True):
        for (word, shift, _), count in zip(FIELDS, tokens, strict=True):
            row[word] |= np.uint64(count << shift)
    asked = [[([(*field, weight) for field, weight in terms], most) for terms, most in way] for way in ways]
    number = {field: place for place, field in enumerate(FIELDS)}
    expected = [
        any(
            all(sum(weight * row[number[field]] for field, weight in terms) <= most for terms, most in way)
            for way in ways
        )
        for row in rows
    ]
    assert _kernel.satisfying(markings, asked).tolist() == expected
