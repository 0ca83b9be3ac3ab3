"""The markings graph of a net with priorities as diagrams, for :mod:`mcpn.check.losing_symbolic` alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import partial

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking, PetriNet
from mcpn.space.encoding import distinct
from mcpn.space.symbolic import SymbolicSpace, chained, elements


class SymbolicMarkings:
    """The markings graph of a net.

    Args:
        space: Its reachable markings.

    Attributes:
        anywhere: Transitions that fire wherever they have their tokens.
        stable_only: Transitions that priorities let fire in stable markings only.
        back: By transition, the event that undoes it.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        self.space = space
        self.net: PetriNet = space.encoding.net
        self.states = space.reachable
        self.initial = space.encoding.initial()
        self.back = space.encoding.undoing
        first = {t for t in self.back if self.net.transitions[t].internal or not self.net.priorities}
        self.anywhere = [t for t in self.back if t in first]
        self.stable_only = [t for t in self.back if t not in first]

    def before(self, after: Zdd, transitions: Iterable[int] | None = None) -> Zdd:
        """States with an edge into a set, of some transitions if so asked."""
        wanted = None if transitions is None else set(transitions)
        anywhere, stable_only = (
            [self.back[t] for t in part if wanted is None or t in wanted]
            for part in (self.anywhere, self.stable_only)
        )
        found = after.images(anywhere, within=self.states)
        if stable_only and self.space.stable is not None:
            found |= after.images(stable_only, within=self.space.stable)
        return found

    def without_way(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set."""
        left = states.beyond(into, [self.back[t] for t in self.anywhere])
        if not self.stable_only or self.space.stable is None:
            return left
        settled = left & self.space.stable
        return (left - settled) | settled.beyond(into, [self.back[t] for t in self.stable_only])

    def until(self, along: Zdd, goal: Zdd) -> Zdd:
        """States from which some path through ``along`` leads into ``goal``, the goal's own included."""
        within = along | goal
        free = [self.back[t] for t in self.anywhere]
        found = goal.saturate(free, within=within)
        if self.space.stable is None:
            return found
        settled = within & self.space.stable

        def back(states: Zdd, events: list[int]) -> Zdd:
            return states.images(events, within=settled).saturate(free, within=within)

        return chained(found, [partial(back, events=events) for events in self._by_element(self.back)])

    def reached(self, begin: Zdd) -> Zdd:
        """States that some path from a set leads to, the set's own included."""
        forth, stable = self.space.encoding.events, self.space.stable
        free = [forth[t] for t in self.anywhere]
        found = begin.saturate(free)
        if stable is None:
            return found

        def ahead(states: Zdd, events: list[int]) -> Zdd:
            return (states & stable).images(events).saturate(free)

        return chained(found, [partial(ahead, events=events) for events in self._by_element(forth)])

    def _by_element(self, events: Mapping[int, int]) -> list[list[int]]:
        """Events of transitions that wait for stable markings, by the element that they are of."""
        wanted = set(self.stable_only)
        return [
            distinct(events[t] for t in of if t in wanted)
            for of in elements(self.space.encoding)
            if not wanted.isdisjoint(of)
        ]

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""
        encoding, space = self.space.encoding, self.space
        found = encoding.store.empty()
        for markings, only in ((self.states, self.anywhere), (space.stable, self.stable_only)):
            wanted = set(only).intersection(transitions)
            conditions = [c for t in sorted(wanted) if (c := encoding.enabling[t]) is not None]
            if markings is not None and conditions:
                found |= markings - markings.without(conditions)
        return found

    def successors(self, marking: Marking) -> list[tuple[tuple[int, ...], Marking]]:
        """Edges of a state: the transitions fired, and the state after them."""
        return [((t,), self.net.fire(marking, t)) for t in self.net.enabled(marking)]
