"""Rules made short: literals that tell nothing apart go, and bits that nothing speaks of."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from heapq import heapify, heappop, heapreplace
from operator import or_

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
    of: dict[int, list[Cube]] = {}
    for cube in cubes:
        of.setdefault(cube.of, []).append(cube)
    groups = [_Group(group) for group in of.values()]
    known = ~0
    while True:  # what changes and is not spoken of need not be told: more rules do the same then
        found = [short for group in groups for short in group.short(known)]
        bits = set(spoken).union(told >> 1 for _, literals, _, _ in found for told in literals)
        needed = sum(1 << level for level in bits)
        if needed & known == known:
            return found, bits
        known = needed


class _Group:
    """The rules of one transition; sets of rules are masks with a bit for each.

    Args:
        cubes: The rules.

    Attributes:
        asking: By literal, the rules that have it.
        literals: By rule, its literals that the event needs, and its others.
    """

    def __init__(self, cubes: Sequence[Cube]) -> None:
        self.cubes = cubes
        self.asking: dict[int, int] = {}
        self.literals: list[tuple[list[int], list[int]]] = []
        for i, cube in enumerate(cubes):
            kept = [*_literals(cube.enabling, cube.marked)]
            others = [*_literals(cube.asked & ~cube.enabling, cube.marked)]
            self.literals.append((kept, others))
            for told in _literals(cube.asked, cube.marked):
                self.asking[told] = self.asking.get(told, 0) | 1 << i
        self._alike: tuple[int, ...] = ()
        self._short = list[tuple[int, tuple[int, ...]]]()

    def short(self, known: int) -> Iterator[Short]:
        """One round of :func:`reduced`: rules that make the same changes to the levels of a mask."""
        effects = [(cube.changes & known, cube.ordered) for cube in self.cubes]
        first: dict[tuple[int, Ordered], int] = {}
        alike = tuple(first.setdefault(effect, i) for i, effect in enumerate(effects))
        if alike != self._alike:  # which rules do the same is all that the rounds differ in
            self._alike, self._short = alike, list(self._needed(alike))
        for i, literals in self._short:
            yield self.cubes[i].event, literals, *effects[i]

    def _needed(self, alike: Sequence[int]) -> Iterator[tuple[int, tuple[int, ...]]]:
        """Rules by number, made short, of which one that does the same fits whatever a full one fits."""
        short, cubes = list(self._told_apart(alike)), self.cubes
        doing: dict[int, list[int]] = {}
        for i in sorted(range(len(cubes)), key=lambda i: len(short[i])):
            doing.setdefault(alike[i], []).append(i)
        for those in doing.values():
            left = _union(cubes[i].states for i in those)
            for i in those:
                if cubes[i].states & left:
                    yield i, short[i]
                    left -= _where(left, short[i])

    def _told_apart(self, alike: Sequence[int]) -> Iterator[tuple[int, ...]]:
        """By rule, as few of its literals as tell it from those that do something else.

        Args:
            alike: By rule, the first one that does the same.
        """
        doing: dict[int, int] = {}
        for i, first in enumerate(alike):
            doing[first] = doing.get(first, 0) | 1 << i
        every = _union(cube.states for cube in self.cubes)

        @cache
        def elsewhere(first: int) -> Zdd:
            """The states that rules with another effect fit."""
            return every - _union(self.cubes[i].states for i in levels_of(doing[first]))

        asking, all_ = self.asking, (1 << len(self.cubes)) - 1
        for first, (kept, rest) in zip(alike, self.literals, strict=True):
            left = all_ & ~doing[first]
            for told in kept:
                left &= ~asking.get(told ^ 1, 0)
            chosen = list[int]()
            # What a literal tells apart gets less as others are chosen, so most need not be counted again.
            most = [(-(asking.get(told ^ 1, 0) & left).bit_count(), told) for told in rest]
            heapify(most)
            while left and most:
                _, best = most[0]
                apart = asking.get(best ^ 1, 0) & left
                if -apart.bit_count() != most[0][0]:
                    heapreplace(most, (-apart.bit_count(), best))
                    continue
                heappop(most)
                if not apart:  # some full rules do not contradict this one; the states of the others go
                    states = _where(elsewhere(first), (*chosen, *kept))
                    chosen += _enough(states, (best, *sorted(told for _, told in most)))
                    break
                chosen.append(best)
                left &= ~apart
            yield (*chosen, *kept)


def _literals(asked: int, marked: int) -> Iterator[int]:
    while asked:
        lowest = asked & -asked
        yield 2 * (lowest.bit_length() - 1) | (marked & lowest > 0)
        asked ^= lowest


def _enough(left: Zdd, literals: Sequence[int]) -> Iterator[int]:
    """Literals that together no state of some satisfies."""
    for told in literals:
        if not left:
            return
        fewer = _where(left, (told,))
        if fewer != left:
            yield told
            left = fewer
    assert not left, "no state fits two rules that differ"


def _where(states: Zdd, literals: Sequence[int]) -> Zdd:
    """Those of some states that satisfy some literals."""
    marked = sorted(told >> 1 for told in literals if told & 1)
    return states.subset(marked, sorted(told >> 1 for told in literals if not told & 1))


def _union(sets: Iterable[Zdd]) -> Zdd:
    """The union of some sets, of which there is one."""
    return reduce(or_, sets)


def levels_of(mask: int) -> list[int]:
    """The levels of a mask, ascending."""
    return [told >> 1 for told in _literals(mask, mask)]
