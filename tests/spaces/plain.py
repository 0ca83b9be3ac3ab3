"""An engine of one's own, the plainest: sets of Python."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from mcpn.nets.petri import PetriNet

Set = frozenset[frozenset[int]]


class PlainSets:
    """A set of markings as a set of sets of marked places."""

    def __init__(self, net: PetriNet) -> None:
        self.net = net

    def single(self, marked: Collection[int]) -> Set:
        """The set of one marking."""
        return frozenset({frozenset(marked)})

    def moved(self, states: Set, before: Mapping[int, bool], after: Mapping[int, bool]) -> Set:
        """Those that are as asked, changed."""
        puts, takes = ({p for p, marked in after.items() if marked is way} for way in (True, False))
        fits = (m for m in states if all((p in m) is marked for p, marked in before.items()))
        return frozenset((m - takes) | puts for m in fits)

    def union(self, one: Set, other: Set) -> Set:
        """Either."""
        return one | other

    def minus(self, one: Set, other: Set) -> Set:
        """The first alone."""
        return one - other

    def count(self, states: Set) -> int:
        """How many."""
        return len(states)


class Wrong(PlainSets):
    """It forgets a marking."""

    def union(self, one: Set, other: Set) -> Set:
        """Not all of either."""
        both = one | other
        return both if len(both) < 5 else frozenset(sorted(both, key=sorted)[:-1])


class Raising(PlainSets):
    """It cannot count."""

    def count(self, states: Set) -> int:
        raise ZeroDivisionError("of one's own")
