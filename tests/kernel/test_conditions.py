"""Counts of conditions and which of them holds, against markings one by one; orders by FORCE."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from itertools import combinations
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import Store, closing, clustered, force, sloan

LEVELS = 9
MARKINGS = st.sets(st.frozensets(st.integers(0, LEVELS - 1)), max_size=12)
CONDITIONS = st.lists(
    st.dictionaries(st.integers(0, LEVELS - 1), st.booleans(), max_size=5), min_size=1, max_size=150
)


@given(MARKINGS, CONDITIONS)
def test_conditions_hold_where_markings_say_so(
    markings: set[frozenset[int]], conditions: list[dict[int, bool]]
) -> None:
    store = Store(LEVELS)
    found = reduce(lambda a, m: a | store.singleton(sorted(m)), markings, store.empty())
    ids = [
        store.condition(
            sorted(p for p, yes in c.items() if yes), sorted(p for p, yes in c.items() if not yes)
        )
        for c in conditions
    ]
    counts = [sum(all((p in m) == yes for p, yes in c.items()) for m in markings) for c in conditions]
    assert found.counts(ids) == counts
    assert [found.counts([i])[0] for i in ids[:5]] == counts[:5]
    assert found.first(ids) == next((i for i, count in enumerate(counts) if count), -1)
    for some in (ids[:2], ids[::-1]):
        held = [counts[ids.index(i)] > 0 for i in some]
        assert found.first(some) == (held.index(True) if any(held) else -1)


def test_counts_are_exact_at_any_size() -> None:
    for levels in (63, 64, 65, 127, 128, 129, 400):
        store = Store(levels)
        everything = store.singleton([]).saturate([store.event([], [level], []) for level in range(levels)])
        assert everything.count() == 2**levels
        first, last, middle = (store.condition([at]) for at in (0, levels - 1, levels // 2))
        both, neither = store.condition([0, levels - 1]), store.condition([], [3, levels - 2])
        halves, quarters = 2 ** (levels - 1), 2 ** (levels - 2)
        assert everything.counts([first, last, middle, both, neither]) == [halves] * 3 + [quarters] * 2


def test_force_keeps_groups_together() -> None:
    draw = Random(2)
    groups = [[i, i + 1] for i in range(39)]
    start = list(range(40))
    draw.shuffle(start)
    order = force(groups, start, 200)
    assert sorted(order) == list(range(40))

    def span(at: list[int]) -> int:
        return sum(abs(at.index(a) - at.index(b)) for a, b in groups)

    assert span(order) < span(start) / 3
    assert force([], start, 200) == start


def test_greedy_orders_follow_a_chain_from_one_end_to_the_other() -> None:
    draw = Random(2)
    names = list(range(40))
    draw.shuffle(names)
    groups = [[names[i], names[i + 1]] for i in range(39)]
    assert sloan(groups, list(range(40))) in (names, names[::-1])
    assert closing(groups, names) == names
    assert closing([], names) == names
    assert sloan([], names) == names


@given(st.lists(st.sets(st.integers(0, 11), max_size=6), max_size=12), st.permutations(range(12)))
def test_orders_hold_each_number_once(groups: list[set[int]], start: list[int]) -> None:
    asked = [sorted(group) for group in groups]
    for order in (
        closing(asked, start),
        clustered(asked, start),
        sloan(asked, start),
        force(asked, start, 20),
    ):
        assert sorted(order) == list(range(12))


@given(st.lists(st.sets(st.integers(0, 11), max_size=6), max_size=12), st.permutations(range(12)))
def test_clusters_are_made_of_the_two_that_pull_most(groups: list[set[int]], start: list[int]) -> None:
    pulls: dict[frozenset[int], float] = {}
    for group in groups:
        for two in combinations(sorted(group), 2):
            pulls[frozenset(two)] = pulls.get(frozenset(two), 0.0) + (len(group) - 1) ** -2.0
    whole = {number: (float(start.index(number)), [number]) for number in range(12)}
    for number in range(12, 24):
        if not pulls:
            break

        def worth(pair: frozenset[int]) -> tuple[float, list[int]]:
            sizes = [float(len(whole[part][1])) for part in pair]
            return -pulls[pair] / (sizes[0] * sizes[1]) ** 0.75, sorted(pair)

        parts = min(pulls, key=worth)
        (upper, above), (lower, below) = sorted(whole.pop(part) for part in parts)
        mean = (upper * len(above) + lower * len(below)) / (len(above) + len(below))
        whole[number] = mean, above + below
        for pair, pull in [*pulls.items()]:
            if pair & parts:
                del pulls[pair]
            if len(pair & parts) == 1:
                joined = pair - parts | {number}
                pulls[joined] = pulls.get(joined, 0.0) + pull
    expected = [member for _, members in sorted(whole.values()) for member in members]
    assert clustered([sorted(group) for group in groups], start) == expected


@pytest.mark.parametrize("make", [closing, clustered, sloan])
def test_what_is_no_order_is_refused(make: Callable[..., list[int]]) -> None:
    with pytest.raises(ValueError, match="each number once"):
        make([], [0, 0])
    with pytest.raises(ValueError, match="numbers of the order"):
        make([[0, 2]], [0, 1])
