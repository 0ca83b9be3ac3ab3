"""The native store against sets of frozensets: everything on small scopes, hypothesis beyond."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterable
from itertools import combinations, product
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import BudgetExceeded, MemoryLimit, Store, Zdd
from tests.conftest import ROOT, interruptible

Marking = frozenset[int]
Sets = frozenset[Marking]


def build(store: Store, markings: Iterable[Marking]) -> Zdd:
    result = store.empty()
    for marking in markings:
        result |= store.singleton(sorted(marking))
    return result


def read(store: Store, zdd: Zdd) -> Sets:
    """Every marking, by asking for each of them."""
    levels = range(store.levels)
    every = [frozenset(c) for size in range(store.levels + 1) for c in combinations(levels, size)]
    return frozenset(m for m in every if zdd & store.singleton(sorted(m)))


MARKINGS_3 = [frozenset(c) for size in range(4) for c in combinations(range(3), size)]
SETS_3 = [frozenset(m for i, m in enumerate(MARKINGS_3) if bits >> i & 1) for bits in range(256)]


def test_algebra_on_every_pair_of_sets_over_three_levels() -> None:
    store = Store(3)
    zdds = [build(store, markings) for markings in SETS_3]
    assert len(set(zdds)) == 256  # equal sets, and only those, are equal handles
    for (a, x), (b, y) in product(zip(zdds, SETS_3, strict=True), repeat=2):
        assert (a | b) == zdds[SETS_3.index(x | y)]
        assert (a & b) == zdds[SETS_3.index(x & y)]
        assert (a - b) == zdds[SETS_3.index(x - y)]
    for a, x in zip(zdds, SETS_3, strict=True):
        assert a.count() == len(x)
        assert bool(a) == bool(x)
        assert read(store, a) == x
        picked = a.pick()
        assert (picked is None) == (not x)
        assert picked is None or frozenset(picked) in x
        listed = [frozenset(marking) for marking in a]
        assert len(listed) == len(x)
        assert set(listed) == x


def test_conditions_on_every_set_over_three_levels() -> None:
    store = Store(3)
    for markings in SETS_3:
        zdd = build(store, markings)
        for kinds in product((0, 1, 2), repeat=3):
            marked = [p for p in range(3) if kinds[p] == 1]
            unmarked = [p for p in range(3) if kinds[p] == 2]
            expected = frozenset(m for m in markings if m >= set(marked) and not m & set(unmarked))
            assert zdd.subset(marked, unmarked) == build(store, expected)
            condition = store.condition(marked, unmarked)
            assert zdd.counts([condition]) == [len(expected)]
            assert zdd.first([condition]) == (0 if expected else -1)
            assert zdd.without([condition]) == build(store, markings - expected)


def test_the_first_of_several_conditions_and_what_is_forgotten_on_every_set_over_three_levels() -> None:
    store = Store(3)
    kinds = list(product((0, 1, 2), repeat=3))
    sides = [[[p for p in range(3) if kind[p] == side] for side in (1, 2)] for kind in kinds]
    conditions = [store.condition(*each) for each in sides]
    subsets = [levels for size in range(4) for levels in combinations(range(3), size)]
    for number, markings in enumerate(SETS_3):
        zdd = build(store, markings)
        held = [
            any(m >= set(marked) and not m & set(unmarked) for m in markings) for marked, unmarked in sides
        ]
        for start in (0, number % 27):  # from different places, so that each condition is once the first
            expected = next((i for i, holds in enumerate(held[start:]) if holds), -1)
            assert zdd.first(conditions[start:]) == expected
        for levels in subsets:
            assert zdd.onto(levels) == build(store, {m & set(levels) for m in markings})


def test_sets_go_from_store_to_store_and_nothing_else_does() -> None:
    here, there = Store(3), Store(3)
    for markings in SETS_3:
        zdd = build(here, markings)
        assert there.from_bytes(zdd.to_bytes()) == build(there, markings)
    row = np.array([0, 0, 1], "<u4").tobytes()
    assert there.from_bytes(row) == there.singleton([0])
    for broken in (
        b"",
        row[:5],
        row[:8],
        np.array([3, 0, 1], "<u4").tobytes(),  # one side of a terminal
        np.array([3, 2, 2], "<u4").tobytes(),  # no terminal
        np.array([4, 0, 1], "<u4").tobytes(),  # no such level
        np.array([0, 0, 2], "<u4").tobytes(),  # a child that is yet to come
        np.array([0, 1, 0], "<u4").tobytes(),  # an empty marked side
        row + np.array([0, 0, 2], "<u4").tobytes(),  # a level above itself
    ):
        with pytest.raises(ValueError, match="no table of a set"):
            there.from_bytes(broken)


Touches = tuple[int, ...]  # for each level: 0 untouched, 1 consume, 2 produce, 3 read, 4 zero


def fire(markings: Sets, touches: Touches) -> Sets:
    consume, produce, still, zero = ({p for p, k in enumerate(touches) if k == kind} for kind in (1, 2, 3, 4))
    return frozenset(
        (m - consume) | produce for m in markings if m >= consume | still and not m & (produce | zero)
    )


def event(store: Store, touches: Touches) -> int:
    sides = [[p for p, k in enumerate(touches) if k == kind] for kind in (1, 2, 3, 4)]
    return store.event(*sides)


def closure(markings: Sets, events: list[Touches], within: Sets | None = None) -> Sets:
    found = markings if within is None else markings & within
    while True:
        wider = found.union(*(fire(found, touches) for touches in events))
        wider = wider if within is None else wider & within
        if wider == found:
            return found
        found = wider


def test_every_event_on_every_set_over_three_levels() -> None:
    store = Store(3)
    zdds = [build(store, markings) for markings in SETS_3]
    for touches in product(range(5), repeat=3):
        number = event(store, touches)
        for zdd, markings in zip(zdds, SETS_3, strict=True):
            assert zdd.images([number]) == zdds[SETS_3.index(fire(markings, touches))]
            assert zdd.saturate([number]) == zdds[SETS_3.index(closure(markings, [touches]))]


@st.composite
def systems(draw: st.DrawFn) -> tuple[int, Sets, list[Touches]]:
    levels = draw(st.integers(1, 7))
    markings = draw(st.frozensets(st.frozensets(st.integers(0, levels - 1)), max_size=5))
    touches = st.tuples(*[st.sampled_from([0, 0, 1, 2, 3, 4])] * levels)
    return levels, markings, draw(st.lists(touches, max_size=8))


@given(systems())
def test_saturation_is_the_closure(system: tuple[int, Sets, list[Touches]]) -> None:
    levels, markings, events = system
    store = Store(levels)
    start = build(store, markings)
    numbers = [event(store, touches) for touches in events]
    assert read(store, start.saturate(numbers)) == closure(markings, events)
    assert read(store, start.saturate(numbers[::-1])) == closure(markings, events)
    assert read(store, start.images(numbers)) == frozenset().union(*(fire(markings, e) for e in events))
    # A second set of events in the same store must not meet what was remembered for the first.
    assert read(store, start.saturate(numbers[:1])) == closure(markings, events[:1])


def test_saturation_inside_every_set_over_three_levels() -> None:
    store = Store(3)
    zdds = [build(store, markings) for markings in SETS_3]
    events: list[Touches] = [(1, 2, 0), (0, 1, 2), (2, 0, 1), (3, 4, 2), (4, 0, 0), (0, 0, 1)]
    numbers = [event(store, touches) for touches in events]
    for start, within in product(range(0, 256, 5), range(256)):
        expected = SETS_3.index(closure(SETS_3[start], events, SETS_3[within]))
        assert zdds[start].saturate(numbers, within=zdds[within]) == zdds[expected]


@given(systems(), st.frozensets(st.frozensets(st.integers(0, 6)), max_size=40))
def test_saturation_stays_within_its_limit(system: tuple[int, Sets, list[Touches]], drawn: Sets) -> None:
    levels, markings, events = system
    within = frozenset(m for m in drawn if all(p < levels for p in m)) | frozenset(list(markings)[:2])
    store = Store(levels)
    numbers = [event(store, touches) for touches in events]
    limit = build(store, within)
    found = build(store, markings).saturate(numbers, within=limit)
    assert read(store, found) == closure(markings, events, within)
    back = [tuple({1: 2, 2: 1}.get(kind, kind) for kind in touches) for touches in events]
    before = found.saturate([event(store, touches) for touches in back], within=limit)
    assert read(store, before) == closure(closure(markings, events, within), back, within)


FAR = 2**105  # no weight of a level is farther from 0
WEIGHTS = st.lists(st.integers(-3, 3) | st.integers(-FAR, FAR), min_size=7, max_size=7)


@given(systems(), WEIGHTS, st.data())
def test_weighing_keeps_the_sums_between_its_bounds(
    system: tuple[int, Sets, list[Touches]], drawn: list[int], data: st.DataObject
) -> None:
    levels, markings, _ = system
    store, weights = Store(levels), drawn[:levels]
    sums = {m: sum(weights[p] for p in m) for m in markings}
    near = st.sampled_from(sorted({0, *sums.values()})).flatmap(lambda at: st.integers(at - 2, at + 2))
    bounds = near | st.integers(-(2**200), 2**200)
    least, most = data.draw(bounds), data.draw(bounds)
    found = build(store, markings).weighing(weights, least, most)
    assert read(store, found) == {m for m in markings if least <= sums[m] <= most}


def test_weights_have_a_limit() -> None:
    zdd = Store(1).singleton([0])
    for weight in (FAR + 1, -FAR - 1, 2**126, -(2**127), 2**300):
        with pytest.raises(ValueError, match="beyond 2\\^105"):
            zdd.weighing([weight], 0, 1)
        with pytest.raises(ValueError, match="beyond 2\\^105"):
            zdd.largest([weight])
    with pytest.raises(TypeError):
        zdd.weighing([0.5], 0, 1)  # type: ignore[list-item]


@given(systems(), WEIGHTS)
def test_largest_is_the_heaviest_marking(system: tuple[int, Sets, list[Touches]], drawn: list[int]) -> None:
    levels, markings, _ = system
    store = Store(levels)
    weights = drawn[:levels]
    if markings:
        heaviest = max(sum(weights[p] for p in m) for m in markings)
        assert build(store, markings).largest(weights) == heaviest
    else:
        with pytest.raises(ValueError, match="empty"):
            store.empty().largest(weights)


def switches(store: Store) -> list[int]:
    """Each level switches on and off freely: 2^levels markings in as many nodes as levels."""
    return [e for p in range(store.levels) for e in (store.event([p], []), store.event([], [p]))]


@pytest.mark.parametrize("levels", [1, 63, 64, 65, 1000, 20_000])
def test_counts_are_exact_and_depth_is_safe(levels: int) -> None:
    store = Store(levels)
    everything = store.singleton([]).saturate(switches(store))
    assert everything.count() == 2**levels
    assert everything.nodes() == levels
    assert everything.largest([1] * levels) == levels
    half = everything.subset([0], [])
    assert (everything - half).count() == 2 ** (levels - 1)
    assert (half | (everything - half)) == everything


def permutations(size: int, **limits: int) -> tuple[Store, Zdd, list[int]]:
    """Tokens that fill a matrix, one a row and column at most: its diagram is exponential in its size."""
    store = Store(3 * size * size, **limits)

    def cell(kind: int, i: int, j: int) -> int:
        return (kind * size + i) * size + j

    events = [
        store.event([cell(0, i, 0), cell(1, 0, j)], [cell(2, i, j)]) for i in range(size) for j in range(size)
    ]
    start = store.singleton([cell(0, i, 0) for i in range(size)] + [cell(1, 0, j) for j in range(size)])
    return store, start, events


def test_a_budget_stops_an_operation_and_leaves_the_store_usable() -> None:
    _, start, events = permutations(7)
    with pytest.raises(BudgetExceeded, match="budget of 100 nodes"):
        start.saturate(events, 100)
    # Partial permutations of 7: the sum over k of C(7, k)^2 k!.
    assert start.saturate(events).count() == 130_922


def test_the_memory_limit_is_an_error_and_leaves_the_store_usable() -> None:
    store, start, events = permutations(14, memory_limit=4 << 20)
    with pytest.raises(MemoryLimit, match="memory limit of 4194304 bytes"):
        start.saturate(events)
    with pytest.raises(MemoryError):
        start.saturate(events)
    store.collect()
    assert store.live_nodes == start.nodes()
    assert (start | store.singleton([0])).count() == 2


def test_garbage_is_collected_under_what_is_held() -> None:
    store, start, events = permutations(6)
    result = start.saturate(events)
    count, nodes = result.count(), result.nodes()
    for level in range(store.levels):
        waste = (result.subset([level], []) | store.singleton([level])) - start
    del waste
    assert store.live_nodes > nodes
    before = store.collections
    store.collect()
    assert store.collections == before + 1
    assert store.live_nodes <= nodes + start.nodes()
    assert result.count() == count
    assert start.saturate(events) == result
    del result
    store.collect()
    assert store.live_nodes == start.nodes()


def test_garbage_is_collected_within_an_operation_when_memory_runs_out() -> None:
    roomy, start, events = permutations(7)
    start.saturate(events)
    limit = roomy.bytes * 2 // 3
    tight, again, same_events = permutations(7, memory_limit=limit)
    assert again.saturate(same_events).count() == 130_922  # as above
    assert tight.collections > 0
    assert tight.bytes <= limit


def test_progress_is_told_and_its_errors_stop_the_operation() -> None:
    store, start, events = permutations(30, memory_limit=1 << 36)

    class Enough(Exception):
        pass

    told = []

    def progress(nodes: int) -> None:
        told.append(nodes)
        raise Enough

    store.progress = progress
    with pytest.raises(Enough):
        start.saturate(events)
    assert told
    assert told[0] > 0
    store.progress = None
    assert start.count() == 1


def test_progress_is_told_between_short_operations() -> None:
    store, start, _ = permutations(3)
    told: list[int] = []
    store.progress = told.append
    assert (start | start) == start
    assert not told
    time.sleep(0.03)  # which is no work
    assert (start | start) == start
    assert not told
    worked = time.process_time() + 0.03
    while time.process_time() < worked:  # longer than from one telling to the next, and than an operation
        pass
    assert (start | start) == start
    assert (start | start) == start
    assert told == [store.live_nodes]


def test_a_store_does_one_thing_at_a_time() -> None:
    store, start, events = permutations(30, memory_limit=1 << 36)
    begun = threading.Event()
    outcome: list[str] = []

    def stop(_: int) -> None:
        begun.set()
        if outcome:
            raise InterruptedError

    def work() -> None:
        with contextlib.suppress(InterruptedError):
            start.saturate(events)

    store.progress = stop
    worker = threading.Thread(target=work)
    worker.start()
    assert begun.wait(30)
    with pytest.raises(RuntimeError, match="at work"):
        start | start
    outcome.append("seen")
    worker.join(30)
    assert not worker.is_alive()
    store.progress = None
    assert (start | start) == start


def test_stores_stand_side_by_side_and_do_not_mix() -> None:
    first, second = Store(4), Store(4)
    a, b = first.singleton([1]), second.singleton([1])
    for combine in (Zdd.__or__, Zdd.__and__, Zdd.__sub__):
        with pytest.raises(ValueError, match="two stores"):
            combine(a, b)
    assert a != b
    del first
    assert a.count() == 1  # a set keeps its store


def test_levels_are_checked() -> None:
    store = Store(3)
    with pytest.raises(ValueError, match="no such level"):
        store.singleton([3])
    with pytest.raises(ValueError, match="no such level"):
        store.event([-1], [])
    with pytest.raises(ValueError, match="named twice"):
        store.event([1], [1])
    with pytest.raises(ValueError, match="levels"):
        Store(1 << 30)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_ctrl_c_stops_a_long_operation() -> None:
    script = (
        f"import sys\nsys.path.append({str(ROOT)!r})\n"
        "from tests.kernel.test_store import permutations\n"
        "_, start, events = permutations(40, memory_limit=1 << 36)\n"
        "print('ready', flush=True)\n"
        "try:\n    start.saturate(events, 1 << 31)\n"
        "except KeyboardInterrupt:\n    assert start.count() == 1\n    print('stopped')\n"
    )
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, preexec_fn=interruptible) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=30)
    assert out == "stopped\n"
    assert process.returncode == 0


@given(st.integers(1, 200), st.integers(1, 40), st.integers(0, 1 << 30))
def test_rows_become_the_set_of_their_markings(levels: int, count: int, seed: int) -> None:
    draw = Random(seed)
    density = draw.random()
    markings = [sorted(p for p in range(levels) if draw.random() < density) for _ in range(count)]
    bits = list(range(levels))
    draw.shuffle(bits)
    rows = np.zeros((count + 1, (levels + 63) // 64), np.uint64)
    for row, marking in zip(rows, [*markings, markings[0]], strict=True):  # one comes twice
        for level in marking:
            row[bits[level] // 64] |= np.uint64(1 << bits[level] % 64)
    store = Store(levels)
    wanted = store.empty()
    for marking in markings:
        wanted |= store.singleton(marking)
    assert store.from_markings(rows, bits) == wanted
