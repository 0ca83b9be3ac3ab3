"""Rules made short: literals that tell nothing apart go, and bits that nothing speaks of."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, reduce
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
        found = list(_once(groups, known))
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

    @cached_property
    def states(self) -> Zdd:
        """The states that some rule fits."""
        return _union(cube.states for cube in self.cubes)


def _once(groups: Sequence[_Group], known: int) -> Iterator[Short]:
    """One round of :func:`reduced`: rules that make the same changes to the levels of a mask."""
    for group in groups:
        yield from _needed(group.cubes, list(_short(group, known)))


def _needed(group: Sequence[Cube], short: Sequence[Short]) -> Iterator[Short]:
    """Short rules of which one that does the same fits whatever a full one fits."""
    doing: dict[tuple[int, Ordered], list[int]] = {}
    for i in sorted(range(len(group)), key=lambda i: len(short[i][1])):
        doing.setdefault(short[i][2:], []).append(i)
    for alike in doing.values():
        left = _union(group[i].states for i in alike)
        for i in alike:
            if group[i].states & left:
                yield short[i]
                left -= _where(left, short[i][1])


def _short(group: _Group, known: int) -> Iterator[Short]:
    """The rules of one transition, each with as few literals as tell it from those that do something else."""
    doing: dict[tuple[int, Ordered], int] = {}
    for i, cube in enumerate(group.cubes):
        effect = cube.changes & known, cube.ordered
        doing[effect] = doing.get(effect, 0) | 1 << i

    @cache
    def elsewhere(effect: tuple[int, Ordered]) -> Zdd:
        """The states that rules with another effect fit."""
        own = _union(group.cubes[i].states for i in levels_of(doing[effect]))
        return group.states - own

    asking, every = group.asking, (1 << len(group.cubes)) - 1
    for cube, (kept, rest) in zip(group.cubes, group.literals, strict=True):
        effect = cube.changes & known, cube.ordered
        left = every & ~doing[effect]
        for told in kept:
            left &= ~asking.get(told ^ 1, 0)
        others = {told: asking.get(told ^ 1, 0) for told in rest}
        chosen = list[int]()
        while left and others:
            best = max(others, key=lambda told: ((others[told] & left).bit_count(), -told))
            apart = others.pop(best) & left
            if not apart:  # some full rules do not contradict this one; the states of the others go
                states = _where(elsewhere(effect), (*chosen, *kept))
                chosen += _enough(states, (best, *others))
                break
            chosen.append(best)
            left &= ~apart
        yield cube.event, (*chosen, *kept), *effect


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
