"""Shortens rules: drops literals that are not needed to tell rules apart, and bits that nobody reads."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from heapq import heapify, heappop, heapreplace
from operator import or_

from mcpn._kernel import Zdd
from mcpn.controller.machine import PlannedAction

Ordered = tuple[tuple[PlannedAction, ...], str | None]
"""The actions, and the outcome with which the section is left."""

Short = tuple[int, tuple[int, ...], int, Ordered]
"""The event, literals (2 i: level i is unmarked; 2 i + 1: marked), levels that change, the actions."""


@dataclass(frozen=True, slots=True)
class Cube:
    """A rule of an event in full; masks have a bit for each level.

    Args:
        event: Number of the event.
        transition: The transition of the event; no state enables two transitions of one event.
        asked: The levels that it has a literal on.
        marked: Those of them that are marked.
        enabling: Those that the transition itself consumes or reads; none of a start.
        changes: The levels that change.
        ordered: The actions, and the outcome.
        states: The states that it fits; two rules of a transition that fit one state have the same effect.
    """

    event: int
    transition: int
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
            have the same effect.
        spoken: Levels that are read outside the rules, and so are always kept.
    """
    of_transition: dict[int, list[Cube]] = {}
    for cube in cubes:
        of_transition.setdefault(cube.transition, []).append(cube)
    groups = [_Group(group) for group in of_transition.values()]
    kept = ~0
    while True:  # changes of levels that nobody reads are dropped; then more rules have the same effect
        shorter = [short for group in groups for short in group.short(kept)]
        bits = set(spoken).union(literal >> 1 for _, literals, _, _ in shorter for literal in literals)
        needed = sum(1 << level for level in bits)
        if needed & kept == kept:
            return shorter, bits
        kept = needed


class _Group:
    """The rules of one transition; sets of rules are masks with a bit for each.

    Args:
        cubes: The rules.

    Attributes:
        asking: By literal, the rules that have it.
        literals: By rule, its literals that enable the transition, and its others.
    """

    def __init__(self, cubes: Sequence[Cube]) -> None:
        self.cubes = cubes
        self.asking: dict[int, int] = {}
        self.literals: list[tuple[list[int], list[int]]] = []
        for i, cube in enumerate(cubes):
            kept = [*_literals(cube.enabling, cube.marked)]
            others = [*_literals(cube.asked & ~cube.enabling, cube.marked)]
            self.literals.append((kept, others))
            for literal in _literals(cube.asked, cube.marked):
                self.asking[literal] = self.asking.get(literal, 0) | 1 << i
        self._alike: tuple[int, ...] = ()
        self._short = list[tuple[int, tuple[int, ...]]]()

    def short(self, kept: int) -> Iterator[Short]:
        """One round of :func:`reduced`: short rules, whose effects are compared on the kept levels alone."""
        effects = [(cube.changes & kept, cube.ordered) for cube in self.cubes]
        first: dict[tuple[int, Ordered], int] = {}
        alike = tuple(first.setdefault(effect, i) for i, effect in enumerate(effects))
        if alike != self._alike:  # rounds differ only in which rules have the same effect
            self._alike, self._short = alike, list(self._needed(alike))
        for i, literals in self._short:
            yield self.cubes[i].event, literals, *effects[i]

    def _needed(self, alike: Sequence[int]) -> Iterator[tuple[int, tuple[int, ...]]]:
        """Short rules by number: enough that each state of a full rule fits one with the same effect."""
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
            for literal in kept:
                left &= ~asking.get(literal ^ 1, 0)
            chosen = list[int]()
            # As literals are chosen, the others contradict fewer of the rules left. Counts are upper bounds:
            # only that of the best literal is brought up to date.
            most = [(-(asking.get(literal ^ 1, 0) & left).bit_count(), literal) for literal in rest]
            heapify(most)
            while left and most:
                _, best = most[0]
                apart = asking.get(best ^ 1, 0) & left
                if -apart.bit_count() != most[0][0]:
                    heapreplace(most, (-apart.bit_count(), best))
                    continue
                heappop(most)
                if not apart:  # no literal contradicts the rules left: their states are excluded instead
                    states = _where(elsewhere(first), (*chosen, *kept))
                    chosen += _enough(states, (best, *sorted(literal for _, literal in most)))
                    break
                chosen.append(best)
                left &= ~apart
            yield (*chosen, *kept)


def _literals(asked: int, marked: int) -> Iterator[int]:
    for level in levels_of(asked):
        yield 2 * level | (marked >> level & 1)


def _enough(left: Zdd, literals: Sequence[int]) -> Iterator[int]:
    """Some of the literals, such that no state of ``left`` satisfies all of them."""
    for literal in literals:
        if not left:
            return
        fewer = _where(left, (literal,))
        if fewer != left:
            yield literal
            left = fewer
    assert not left, "no state fits two rules that differ"


def _where(states: Zdd, literals: Sequence[int]) -> Zdd:
    """The states that satisfy all of some literals."""
    marked = sorted(literal >> 1 for literal in literals if literal & 1)
    return states.subset(marked, sorted(literal >> 1 for literal in literals if not literal & 1))


def _union(sets: Iterable[Zdd]) -> Zdd:
    """The union of some sets, at least one."""
    return reduce(or_, sets)


def levels_of(mask: int) -> list[int]:
    """The levels of a mask, ascending."""
    levels = []
    while mask:
        lowest = mask & -mask
        levels.append(lowest.bit_length() - 1)
        mask ^= lowest
    return levels
