"""Rules made short: literals that tell nothing apart go, and bits that nothing speaks of."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from mcpn._kernel import Zdd
from mcpn.controller.actions import PlannedAction

Ordered = tuple[tuple[PlannedAction, ...], str | None]
"""What is ordered, and the outcome with which the section is left."""

Short = tuple[int, tuple[int, ...], int, Ordered]
"""The event, literals (2 i: level i is unmarked; 2 i + 1: marked), levels that change, what is ordered."""


@dataclass(frozen=True, slots=True)
class Cube:
    """A rule of an event in full; masks have a bit for each level.

    Args:
        event: Number of the event.
        of: The transition of it: no state enables two of an event.
        asked: The levels that it looks at.
        marked: Those of them that are marked.
        enabling: Those that the event needs at all, wherever it happens.
        changes: The levels that change.
        ordered: What is ordered.
        states: The states that it fits; two rules of a transition that fit one state do the same.
    """

    event: int
    of: int
    asked: int
    marked: int
    enabling: int
    changes: int
    ordered: Ordered
    states: Zdd


def reduced(cubes: Sequence[Cube], spoken: Collection[int]) -> tuple[list[Short], set[int]]:
    """Shorter rules that do the same in all states that fit one of the full ones, and the levels they need.

    A short rule keeps what the event needs, and enough literals to contradict each full rule of the event
    that does something else, or to fit none of its states: so a state that fits the full one does not fit the
    short one.

    Args:
        cubes: The rules in full: every state that matters fits some for each event that it allows, and those
            do the same.
        spoken: Levels that others speak of.
    """
    known = ~0
    while True:  # what changes and is not spoken of need not be told: more rules do the same then
        found = list(_once(cubes, known))
        bits = set(spoken).union(told >> 1 for _, literals, _, _ in found for told in literals)
        needed = sum(1 << level for level in bits)
        if needed & known == known:
            return found, bits
        known = needed


def _once(cubes: Sequence[Cube], known: int) -> Iterator[Short]:
    """One round of :func:`reduced`: rules that make the same changes to the levels of a mask."""
    of: dict[int, list[Cube]] = {}
    for cube in cubes:
        of.setdefault(cube.of, []).append(cube)
    for group in of.values():
        yield from _needed(group, list(_short(group, known)))


def _needed(group: Sequence[Cube], short: Sequence[Short]) -> Iterator[Short]:
    """Short rules of which one that does the same fits whatever a full one fits."""
    doing: dict[tuple[int, Ordered], list[int]] = {}
    for i in sorted(range(len(group)), key=lambda i: len(short[i][1])):
        doing.setdefault(short[i][2:], []).append(i)
    for alike in doing.values():
        left = group[alike[0]].states
        for i in alike[1:]:
            left |= group[i].states
        for i in alike:
            if group[i].states & left:
                yield short[i]
                fits = left
                for told in short[i][1]:
                    fits = _where(fits, told)
                left -= fits


def _short(group: Sequence[Cube], known: int) -> Iterator[Short]:
    """The rules of one transition; sets of rules are masks with a bit for each."""
    asking: dict[int, int] = {}  # by literal, the rules that have it
    doing: dict[tuple[int, Ordered], int] = {}
    for i, cube in enumerate(group):
        for told in _literals(cube.asked, cube.marked):
            asking[told] = asking.get(told, 0) | 1 << i
        doing[cube.changes & known, cube.ordered] = (
            doing.get((cube.changes & known, cube.ordered), 0) | 1 << i
        )
    every = (1 << len(group)) - 1
    for cube in group:
        effect = cube.changes & known, cube.ordered
        left = every & ~doing[effect]
        kept = [*_literals(cube.enabling, cube.marked)]
        for told in kept:
            left &= ~asking.get(told ^ 1, 0)
        others = {
            told: asking.get(told ^ 1, 0) for told in _literals(cube.asked & ~cube.enabling, cube.marked)
        }
        chosen = list[int]()
        while left and others:
            best = max(others, key=lambda told: ((others[told] & left).bit_count(), -told))
            apart = others.pop(best) & left
            if not apart:  # some full rules do not contradict this one
                chosen += _enough([group[j] for j in levels_of(left)], (best, *others), (*chosen, *kept))
                break
            chosen.append(best)
            left &= ~apart
        yield cube.event, (*chosen, *kept), *effect


def _literals(asked: int, marked: int) -> Iterator[int]:
    while asked:
        lowest = asked & -asked
        yield 2 * (lowest.bit_length() - 1) | (marked & lowest > 0)
        asked ^= lowest


def _enough(others: Sequence[Cube], literals: Sequence[int], kept: Sequence[int]) -> Iterator[int]:
    """Literals that, with those that are kept, no state of some other rules satisfies."""
    left = others[0].states
    for cube in others[1:]:
        left |= cube.states
    for told in kept:
        left = _where(left, told)
    for told in literals:
        if not left:
            return
        fewer = _where(left, told)
        if fewer != left:
            yield told
            left = fewer
    assert not left, "no state fits two rules that differ"


def _where(states: Zdd, told: int) -> Zdd:
    """Those of some states that satisfy a literal."""
    return states.subset([told >> 1]) if told & 1 else states.subset(unmarked=[told >> 1])


def levels_of(mask: int) -> list[int]:
    """The levels of a mask, ascending."""
    return [told >> 1 for told in _literals(mask, mask)]
