"""Sets of hardware states against sets of frozensets of names."""

from __future__ import annotations

from itertools import chain, combinations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mcpn.space.local.interface import Frame, HardwareSpace, HardwareStates

ALL = ("a", "b", "c", "d")
State = frozenset[str]
"""The names of what is out of service."""


def states_of(names: tuple[str, ...]) -> list[State]:
    """All states of some hardware."""
    return [frozenset(c) for c in chain.from_iterable(combinations(names, n) for n in range(len(names) + 1))]


def told(frame: Frame, states: set[State]) -> HardwareStates:
    masks = np.zeros(1 << len(frame.names), np.bool_)
    for state in states:
        masks[sum(1 << bit for bit, name in enumerate(frame.names) if name in state)] = True
    return frame.from_masks(masks)


def read(found: HardwareStates) -> set[State]:
    names = found.frame.names
    return {
        frozenset(name for bit, name in enumerate(names) if mask >> bit & 1)
        for mask in np.flatnonzero(found.masks()).tolist()
    }


@st.composite
def sections(draw: st.DrawFn) -> tuple[tuple[str, ...], set[State]]:
    """Some hardware in an order of its own, and some of its states."""
    names = tuple(draw(st.permutations(ALL)))[: draw(st.integers(0, 4))]
    return names, draw(st.sets(st.sampled_from(states_of(names))))


@given(sections(), sections())
def test_what_one_section_hands_to_the_next(
    first: tuple[tuple[str, ...], set[State]], second: tuple[tuple[str, ...], set[State]]
) -> None:
    space = HardwareSpace(ALL)
    (names, states), (others, _) = first, second
    frame, other = space.frame(names), space.frame(others)
    found = told(frame, states)
    assert read(found) == states
    assert found.count() == len(states)
    assert bool(found) == bool(states)
    kept = set(names) & set(others)
    for free in (True, False):
        expected = {
            state
            for state in states_of(others)
            if any(state & kept == before & kept for before in states) and (free or state <= kept)
        }
        assert read(found.seen_by(other, free=free)) == expected
    assert read(found.in_service(names[:1])) == {state for state in states if not state & set(names[:1])}


@given(sections(), st.data())
def test_sets_of_states(section: tuple[tuple[str, ...], set[State]], data: st.DataObject) -> None:
    names, states = section
    others = data.draw(st.sets(st.sampled_from(states_of(names))))
    frame = HardwareSpace(ALL).frame(names)
    one, two = told(frame, states), told(frame, others)
    assert read(one | two) == states | others
    assert read(one & two) == states & others
    assert read(one - two) == states - others
    assert read(frame.everything) == set(states_of(names))
    assert read(frame.nothing) == set()
    if states:
        assert read(frame.of_mask(one.pick())) <= states
