"""Families of sets against sets of frozensets."""

from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.check.causes.families import ALWAYS, NEVER, Families, Family
from mcpn.errors import LimitError

SIZE = 5
Sets = frozenset[frozenset[int]]
SUBSETS = [frozenset(c) for size in range(SIZE + 1) for c in combinations(range(SIZE), size)]


def minimal(sets: Sets) -> Sets:
    return frozenset(s for s in sets if not any(t < s for t in sets))


def solutions(sets: Sets) -> Sets:
    """Every set above one of the sets."""
    return frozenset(d for d in SUBSETS if any(s <= d for s in sets))


def build(families: Families, sets: Sets) -> Family:
    family = NEVER
    for s in sets:
        family = families.either(family, families.all_of(s))
    return family


def read(families: Families, family: Family) -> Sets:
    return frozenset(frozenset(members) for members in families.members(family))


drawn = st.frozensets(st.frozensets(st.integers(0, SIZE - 1)), max_size=6)


@given(drawn, drawn)
def test_operations_are_those_of_monotone_functions(one: Sets, other: Sets) -> None:
    families = Families(SIZE)
    f, g = build(families, one), build(families, other)
    assert read(families, f) == minimal(one)
    assert families.count(f) == len(minimal(one))
    assert families.least(f) == min((len(s) for s in one), default=None)
    assert read(families, families.either(f, g)) == minimal(solutions(one) | solutions(other))
    assert read(families, families.both(f, g)) == minimal(solutions(one) & solutions(other))
    hitting = frozenset(d for d in SUBSETS if all(d & s for s in one))
    assert read(families, families.dual(f)) == minimal(hitting)
    assert families.dual(families.dual(f)) == f
    assert families.support(f) == sorted(frozenset().union(*minimal(one)))
    for d in SUBSETS:
        assert families.holds(f, d) == (d in solutions(one))
        inside = families.inside(f, d)
        assert families.models(inside, d) == sum(e <= d and e in solutions(one) for e in SUBSETS)
        rest = frozenset(s - d for s in one)
        assert read(families, families.assuming(f, d)) == minimal(rest)
        assert read(families, families.inside(f, d)) == {s for s in minimal(one) if s <= d}


@given(st.frozensets(st.integers(0, SIZE - 1)))
def test_constants(elements: frozenset[int]) -> None:
    families = Families(SIZE)
    assert read(families, families.any_of(elements)) == {frozenset({e}) for e in elements}
    assert read(families, families.all_of(elements)) == {elements}
    assert families.members(NEVER) == []
    assert families.members(ALWAYS) == [()]


def test_many_solutions_stay_a_small_diagram() -> None:
    # 20 activities with 3 ways each: 3^20 path sets from 20 cut sets, by closed form.
    families = Families(60)
    family = NEVER
    for i in range(20):
        family = families.either(family, families.all_of(range(3 * i, 3 * i + 3)))
    paths = families.dual(family)
    assert families.count(paths) == 3**20
    assert families.least(paths) == 20
    assert families.dual(paths) == family
    with pytest.raises(LimitError, match="limit on listed sets"):
        families.members(paths)


def test_too_many_elements_are_refused() -> None:
    with pytest.raises(LimitError, match="limit on elements"):
        Families(501)
