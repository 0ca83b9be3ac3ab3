"""Events and conditions that go on depending on a level, against relations on plain sets."""

from __future__ import annotations

from typing import TypeAlias

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import Store
from tests.draws import fewer
from tests.kernel.test_store import Marking, Sets, build, read

LEVELS = 4
Branch: TypeAlias = "tuple[int, dict[str, Branch]] | None"
"""A level and what follows by touch; ``None``: nothing more happens."""

MARKINGS = st.frozensets(st.frozensets(st.integers(0, LEVELS - 1)))


def branches(touches: tuple[str, ...], level: int = 0) -> st.SearchStrategy[Branch]:
    if level == LEVELS:
        return st.none()

    def at(chosen: int) -> st.SearchStrategy[Branch]:
        inside = st.deferred(lambda: branches(touches, chosen + 1))
        ways = st.dictionaries(st.sampled_from(touches), inside, min_size=1)
        return ways.map(lambda found: (chosen, found))

    return st.none() | st.integers(level, LEVELS - 1).flatmap(at)


def given_to(store: Store, branch: Branch) -> int:
    if branch is None:
        return store.condition([])
    level, ways = branch
    return store.branch(level, **{touch: given_to(store, rest) for touch, rest in ways.items()})


def after(branch: Branch, marking: Marking) -> Sets:
    if branch is None:
        return frozenset([marking])
    level, ways = branch
    found = set[Marking]()
    for touch, rest in ways.items():
        if (level in marking) == (touch in ("consume", "read")):
            # What follows is on levels below, so that the order of changes does not matter.
            for changed in after(rest, marking - {level}):
                found.add(changed | {level} if touch in ("produce", "read") else changed)
    return frozenset(found)


EVENTS = branches(("consume", "produce", "read", "zero"))
CONDITIONS = branches(("read", "zero"))


@fewer(0.4)
@given(MARKINGS, st.lists(EVENTS, max_size=3), MARKINGS)
def test_images_and_closures(markings: Sets, events: list[Branch], within: Sets) -> None:
    store = Store(LEVELS)
    some, limit = build(store, markings), build(store, within)
    ids = [given_to(store, event) for event in events]

    def step(begin: Sets) -> Sets:
        return frozenset(made for m in begin for event in events for made in after(event, m))

    assert read(store, some.images(ids)) == step(markings)
    assert read(store, some.images(ids, within=limit)) == step(markings) & within
    for event, one in zip(events, ids, strict=True):
        assert read(store, some.images([one])) == frozenset(m for b in markings for m in after(event, b))
    assert read(store, limit.beyond(some, ids)) == within - step(markings)
    closed = markings
    while step(closed) - closed:
        closed |= step(closed)
    assert read(store, some.saturate(ids)) == closed
    inside = markings & within
    while (step(inside) & within) - inside:
        inside |= step(inside) & within
    assert read(store, some.saturate(ids, within=limit)) == inside


@fewer(0.4)
@given(MARKINGS, st.lists(CONDITIONS, max_size=3))
def test_conditions(markings: Sets, conditions: list[Branch]) -> None:
    store = Store(LEVELS)
    some = build(store, markings)
    ids = [given_to(store, condition) for condition in conditions]
    meeting = [frozenset(m for m in markings if after(condition, m)) for condition in conditions]
    assert some.counts(ids) == [len(met) for met in meeting]
    assert some.first(ids) == next((i for i, met in enumerate(meeting) if met), -1)
    assert read(store, some.without(ids)) == markings - frozenset[Marking]().union(*meeting)
    for one, met in zip(ids, meeting, strict=True):
        assert read(store, some.without([one])) == markings - met
        assert some.counts([one]) == [len(met)]


def test_what_is_no_branch_is_refused() -> None:
    store, other = Store(LEVELS), Store(LEVELS)
    low = store.branch(2, read=store.condition([]))
    with pytest.raises(ValueError, match="nothing may happen"):
        store.branch(1)
    for level in (-1, LEVELS):
        with pytest.raises(ValueError, match="level"):
            store.branch(level, read=store.condition([]))
    for level in (2, 3):
        with pytest.raises(ValueError, match="levels below"):
            store.branch(level, zero=low)
    with pytest.raises(ValueError, match="no event of this store"):
        store.branch(0, zero=other.condition([]))
    moving = store.branch(0, consume=low, zero=low)
    with pytest.raises(ValueError, match="no condition"):
        store.singleton([0]).counts([moving])
    assert store.branch(2, read=store.condition([])) == low
