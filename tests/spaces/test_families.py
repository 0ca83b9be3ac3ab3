"""The families of nets of the kit: every engine counts the markings that are known."""

from __future__ import annotations

from itertools import combinations

import pytest

from mcpn.spaces.sizes import summarise
from mcpn.testing.nets import FAMILIES, NetFamily
from tests.nets.nets import reachable

MOST_LISTED = 60_000
FEW_PLACES = 16
"""Of nets that the reference engine counts in a second."""
PUBLISHED = {
    # The Model Checking Contest: Kanban-PT-00005, FMS-PT-00005, Eratosthenes-PT-010 and -100, NQueens-PT-05
    # and -08; Ciardo and Tilgner, ICASE report 96-35, for the smaller ones.
    "kanban": {1: 160, 2: 4_600, 3: 58_400, 4: 454_475, 5: 2_546_432},
    "fms": {1: 120, 2: 3_444, 3: 48_590, 4: 438_600, 5: 2_895_018},
    "eratosthenes": {10: 32, 100: 18_889_465_931_478_580_854_784},
    "queens": {5: 462, 8: 118_969},
}


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("more", range(4))
def test_every_engine_counts_what_is_known(name: str, more: int) -> None:
    family = FAMILIES[name]
    size = family.least + more
    net, known = family.net(size), family.markings(size)
    assert known is not None
    assert summarise(net, "symbolic").states == known
    if known <= MOST_LISTED:
        assert summarise(net, "explicit").states == known
    if family.safe and len(net.places) <= FEW_PLACES:
        assert summarise(net, "pyeda").states == known


def test_families_say_which_are_safe() -> None:
    for name, family in FAMILIES.items():
        found = summarise(family.net(3), "explicit")
        assert (found.max_tokens_in_place == 1) == family.safe, name


@pytest.mark.parametrize("name", [name for name, family in FAMILIES.items() if family.safe])
def test_the_closed_forms_are_those_of_the_nets_own_rule(name: str) -> None:
    family = FAMILIES[name]
    for size in range(family.least, family.least + 3):
        found, _, safe = reachable(family.net(size))
        assert safe
        assert len(found) == family.markings(size)


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_closed_forms_are_what_is_published(name: str) -> None:
    for size, published in PUBLISHED[name].items():
        assert FAMILIES[name].markings(size) == published


def test_a_large_member_is_counted_on_diagrams() -> None:
    for name, size in (("philosophers", 60), ("slotted_ring", 10), ("component_ring", 12), ("kanban", 8)):
        family = FAMILIES[name]
        assert summarise(family.net(size), "symbolic").states == family.markings(size)


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5])
def test_queens_are_counted_on_boards(size: int) -> None:
    squares = [(row, column) for row in range(size) for column in range(size)]

    def apart(one: tuple[int, int], other: tuple[int, int]) -> bool:
        down, across = one[0] - other[0], one[1] - other[1]
        return bool(down and across) and abs(down) != abs(across)

    peaceful = sum(
        all(apart(one, other) for one, other in combinations(queens, 2))
        for number in range(size + 1)
        for queens in combinations(squares, number)
    )
    assert FAMILIES["queens"].markings(size) == peaceful


def test_a_size_that_makes_no_net_is_refused() -> None:
    for name, family in FAMILIES.items():
        with pytest.raises(ValueError, match=rf"^{name}: found the size 0, expected {family.least} or more"):
            family.net(0)


def test_a_number_that_is_not_known_is_none() -> None:
    assert NetFamily(FAMILIES["queens"].net, {}, "").markings(7) is None
