"""What the kernel refuses, what stops it, and what it remembers: from Python nothing may bring it down."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import threading
from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn import _kernel as kernel
from mcpn._kernel import BudgetExceeded, Cancelled, MemoryLimit, SafeNet, Store, Zdd
from tests.kernel.test_store import Sets, Touches, build, event, fire, permutations, read, switches, systems

KERNEL = Path(__file__).resolve().parents[2] / "kernel"


def test_only_events_and_conditions_of_the_store_are_taken() -> None:
    store, other = Store(4), Store(4)
    event, condition = store.event([0], [1]), store.condition([0], [1])
    foreign, foreign_condition = other.event([0], [1]), other.condition([0], [1])
    some = store.singleton([0])
    for unknown in (foreign, foreign_condition, 0, 1, 7, event + 1000, 2**32 - 1, 2**63, 2**64 - 1):
        if unknown in (event, condition):
            continue
        for ask in (some.images, some.saturate, lambda ids: some.beyond(some, ids)):
            with pytest.raises(ValueError, match=f"{unknown} is no event of this store"):
                ask([event, unknown])
        for query in (some.without, some.counts, some.first):
            with pytest.raises(ValueError, match=f"{unknown} is no condition of this store"):
                query([condition, unknown])
    for out_of_range in (-1, 2**64):
        with pytest.raises(TypeError):
            some.images([out_of_range])
    with pytest.raises(ValueError, match="is no condition"):
        some.counts([event])
    assert some.images([event]) == store.singleton([1])
    assert some.images([condition]) == some  # a condition is an event that changes nothing
    with pytest.raises(ValueError, match="two stores"):
        some.images([event], within=other.singleton([1]))
    with pytest.raises(ValueError, match="two stores"):
        some.saturate([event], within=other.singleton([1]))


@pytest.mark.parametrize("place", [3, 64, 2**20, 2**32 - 1])
def test_places_out_of_range_are_refused(place: int) -> None:
    net = SafeNet(3, [([0], [0], [1], False, False)], False)
    with pytest.raises(ValueError, match="no such place"):
        net.explore([0, place], True, 10, 1 << 30)
    with pytest.raises(ValueError, match="no such place"):
        SafeNet(3, [([0], [0], [1], False, False)], True).settle([0, place], "every", 10, 10, 1 << 30)
    with pytest.raises(ValueError, match="no such place"):
        SafeNet(3, [([place], [], [], False, False)], False)
    assert net.explore([0], False, 10, 1 << 30).states == 2


def test_a_run_to_no_state_is_refused() -> None:
    found = SafeNet(2, [([0], [0], [1], False, False)], False).explore([0], True, 10, 1 << 30)
    with pytest.raises(IndexError, match="no such state"):
        found.run(2)
    found.take_markings()
    assert found.take_markings().size == 0


def sums(levels: int, seed: int) -> tuple[Store, Zdd, Zdd]:
    """Two sets without a common marking, which their diagrams tell at the last level only.

    Weighted sums: those of the second set's weights are odd where those of the first set's are even.
    """
    draw = Random(seed)
    store = Store(levels)
    everything = store.singleton([]).saturate(switches(store))
    weights = [draw.randrange(60) for _ in range(levels)]
    others = [weight + 2 * draw.randrange(30) for weight in weights]
    half = sum(weights) // 2, sum(others) // 2
    even, odd = half[0] - half[0] % 2, half[1] - half[1] % 2 + 1
    return store, everything.weighing(weights, even, even), everything.weighing(others, odd, odd)


@pytest.mark.parametrize("combine", [Zdd.__and__, Zdd.__sub__])
def test_an_operation_that_makes_no_node_is_stopped(combine: object) -> None:
    store, even, odd = sums(70, 1)
    assert even
    assert odd

    class Enough(Exception):
        pass

    def progress(_: int) -> None:
        raise Enough

    store.progress = progress
    with pytest.raises(Enough):
        combine(even, odd)  # type: ignore[operator]
    store.progress = None
    assert (even & even) == even


def test_small_sums_do_not_meet() -> None:
    _, even, odd = sums(14, 2)
    assert even
    assert odd
    assert not even & odd
    assert even - odd == even


def test_a_budget_of_steps_ends_a_closure_that_then_goes_on() -> None:
    store, start, events = permutations(5)
    whole, fresh, same = permutations(5)
    expected = fresh.saturate(same)
    needed = whole.steps
    with pytest.raises(BudgetExceeded, match="budget of 500 steps"):
        start.saturate(events, max_steps=500)
    assert store.steps == 500
    rounds, used, budget = 1, 500, 500
    while True:
        budget *= 2
        try:
            found = start.saturate(events, max_steps=budget)
        except BudgetExceeded:
            used += budget
            rounds += 1
            continue
        used += store.steps
        break
    assert found.count() == expected.count() == 1546  # as in test_store
    assert rounds > 3
    assert used < 1.6 * needed  # anew each time it would be about twice as many


def test_one_closure_does_not_make_the_store_forget_another() -> None:
    store, start, events = permutations(6)
    first, second = events[::2], events[1::2]
    for each in (first, second):
        start.saturate(each)
    for each in (first, second, first):
        start.saturate(each)
        assert store.steps == 0
    some = [store.event([], [level]) for level in range(20)]
    for lists in pairwise(range(len(some) + 300)):  # more lists than the store tells apart at a time
        chosen = [some[i % len(some)] for i in lists] + [some[i // len(some) % len(some)] for i in lists]
        levels = {i % len(some) for i in lists} | {i // len(some) % len(some) for i in lists}
        assert store.singleton([]).saturate(chosen).count() == 2 ** len(levels)


def test_what_counts_and_sums_keep_is_inside_the_memory_limit() -> None:
    levels = 300
    roomy = Store(levels)
    everything = roomy.singleton([]).saturate(switches(roomy))
    weights = [1 + level % 7 for level in range(levels)]
    half = sum(weights) // 2
    wide = everything.weighing(weights, half, half)
    limit = roomy.bytes * 3 // 2
    tight = Store(levels, limit)
    copy = tight.from_bytes(wide.to_bytes())
    conditions = [tight.condition([level, level + 2]) for level in range(levels - 2)]
    for ask in (
        lambda: copy.counts(conditions),
        copy.count,
        lambda: copy.largest(weights),
        lambda: copy.weighing(weights[::-1], half, half),
    ):
        with pytest.raises(MemoryLimit, match="memory limit"):
            ask()
        assert tight.bytes <= limit
    assert (copy & copy) == copy


def test_a_store_that_is_cancelled_gives_up() -> None:
    store, start, events = permutations(30, memory_limit=1 << 36)
    begun, outcome = threading.Event(), list[str]()
    store.progress = lambda _: begun.set()

    def work() -> None:
        try:
            start.saturate(events)
        except Cancelled:
            outcome.append("cancelled")

    worker = threading.Thread(target=work)
    worker.start()
    assert begun.wait(30)
    store.cancel()
    worker.join(30)
    assert outcome == ["cancelled"]
    with pytest.raises(Cancelled):
        start | start


def parameters(signature: str) -> list[str]:
    """Their names in the head of a function."""
    while (shorter := re.sub(r"\[[^][]*\]", "", signature)) != signature:
        signature = shorter
    inside = signature.partition("(")[2].rpartition(")")[0]
    return [re.split("[:=]", one)[0].strip() for one in inside.split(",") if one.strip()]


def declared(body: list[ast.stmt]) -> dict[str, ast.stmt]:
    """What some lines of a stub declare, by name, but for operators and the like."""
    named: dict[str, ast.stmt] = {n.name: n for n in body if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    named |= {n.target.id: n for n in body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)}
    return {name: node for name, node in named.items() if not name.startswith("__")}


def public(of: object) -> set[str]:
    """Names of what a class or module of the kernel has."""
    return {name for name in vars(of) if not name.startswith("__")}


def test_the_stub_names_all_that_the_kernel_has() -> None:
    """Functions, classes, methods, and the names of what they take."""
    inside = declared(ast.parse((KERNEL.parent / "mcpn" / "_kernel.pyi").read_text()).body)
    assert inside.keys() == public(kernel)
    known = {(kernel, name): node for name, node in inside.items()}
    for name, node in inside.items():
        if isinstance(node, ast.ClassDef):
            methods = declared(node.body)
            assert methods.keys() == public(getattr(kernel, name)), name
            known |= {(getattr(kernel, name), method): each for method, each in methods.items()}
    compared = 0
    for (owner, name), node in known.items():
        heads = getattr(getattr(owner, name), "__nb_signature__", ())
        if isinstance(node, ast.FunctionDef) and heads:
            assert parameters(f"({ast.unparse(node.args)})") in [parameters(h) for h, *_ in heads], name
            compared += 1
    assert compared > 60


@pytest.mark.slow
def test_the_stub_says_what_the_kernel_has() -> None:
    """Types and defaults, too: mypy looks at all of numpy for it, for half a minute."""
    pytest.importorskip("mypy.stubtest", reason="needs mypy: the extra test-all")
    command = [
        sys.executable,
        "-m",
        "mypy.stubtest",
        "mcpn._kernel",
        "--allowlist",
        str(KERNEL / "stubtest.txt"),
        "--mypy-config-file",
        str(KERNEL.parent / "pyproject.toml"),
    ]
    run = subprocess.run(command, capture_output=True, text=True, cwd=KERNEL.parent, check=False)
    assert run.returncode == 0, run.stdout


def test_markings_in_rows_are_a_set() -> None:
    draw = Random(3)
    for levels in (1, 5, 63, 64, 65, 130):
        store = Store(levels)
        bits = draw.sample(range(levels + 7), levels)
        markings = [sorted(draw.sample(range(levels), draw.randrange(levels + 1))) for _ in range(40)]
        rows = np.zeros((len(markings), (levels + 70) // 64), np.uint64)
        expected = store.empty()
        for row, marking in zip(rows, markings, strict=True):
            expected |= store.singleton(marking)
            for level in marking:
                row[bits[level] // 64] |= np.uint64(1 << bits[level] % 64)
        assert store.from_markings(rows, bits) == expected
        assert store.from_markings(rows[:0], bits) == store.empty()
        for wrong in (bits[1:], [*bits[1:], rows.shape[1] * 64], [*bits[1:], -2]):
            with pytest.raises(ValueError, match="bit"):
                store.from_markings(rows, wrong)


@given(
    systems(),
    st.lists(st.tuples(*[st.sampled_from([0, 0, 3, 4])] * 7), max_size=8),
    st.frozensets(st.frozensets(st.integers(0, 6)), max_size=40),
)
def test_many_conditions_and_events_at_once(
    system: tuple[int, Sets, list[Touches]], drawn: list[Touches], others: Sets
) -> None:
    levels, markings, events = system
    store = Store(levels)
    markings |= {m for m in others if all(p < levels for p in m)}
    zdd = build(store, markings)
    wanted = [touches[:levels] for touches in drawn]
    sides = [[[p for p, kind in enumerate(touches) if kind == side] for side in (3, 4)] for touches in wanted]
    conditions = [store.condition(*side) for side in sides]
    left = frozenset(
        m for m in markings if not any(m >= set(marked) and not m & set(not_) for marked, not_ in sides)
    )
    assert read(store, zdd.without(conditions)) == left
    numbers = [event(store, touches) for touches in events]
    after = frozenset[frozenset[int]]().union(*(fire(markings, touches) for touches in events))
    assert read(store, zdd.images(numbers)) == after
    within = frozenset(list(markings)[::2])
    assert read(store, zdd.images(numbers, within=build(store, within))) == after & within
    assert read(store, zdd.beyond(build(store, within), numbers)) == markings - frozenset[
        frozenset[int]
    ]().union(*(fire(within, touches) for touches in events))


def test_conditions_that_one_pass_cannot_hold_are_taken_one_by_one() -> None:
    pairs = 16  # all that the first half marks is pending halfway
    store = Store(2 * pairs)
    everything = store.singleton([]).saturate(switches(store))
    both = [store.condition([level, pairs + level]) for level in range(pairs)]
    none = [store.condition([], [level, pairs + level]) for level in range(pairs)]
    assert everything.without(both).count() == 3**pairs
    assert everything.without(both + none).count() == 2**pairs
    assert store.singleton([0]).without([store.condition([])]) == store.empty()
