"""The spaces of decision diagrams: the markings of a net, or its stable states, as sets in the native kernel.

``reaching`` and ``reached`` are saturation inside a set where the net has no priorities (constrained
saturation: Zhao, Ciardo, *Symbolic CTL model checking of asynchronous systems using constrained saturation*,
ATVA 2009), or layers of all events where those take fewer steps; with priorities, saturation by internal
transitions alternates with steps of events, element by element of the mission.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cached_property, lru_cache, partial
from typing import TypeAlias

from mcpn._kernel import Zdd
from mcpn.spaces.algebra import Edge, Guards
from mcpn.spaces.diagrams.base import Diagrams
from mcpn.spaces.diagrams.closing import chained
from mcpn.spaces.diagrams.internal_evolution import behind, leading
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.run import Completion

Step: TypeAlias = Callable[[Zdd], Zdd]

MOST_ENDINGS = 64
"""Goals for which the markings that end in them are kept: one is asked of many transitions in a row."""


class DiagramMarkings(Diagrams):
    """The markings graph of a net: its edges are firings, priorities respected.

    Args:
        space: The reachable markings of the net.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        super().__init__(space, space.reachable, space.encoding.initial())

    def leading_into(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """All states with an edge into some states."""
        undoing = self.encoding.undoing
        sources = self.nothing
        for group, where in self.groups:
            if asked := self.of(undoing, group, transitions, guards):
                sources |= states.images(asked, within=where)
        for event, where in self.guarded(undoing, transitions, guards):
            sources |= states.images([event], within=where)
        return sources

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        events = self.encoding.events
        targets = self.nothing
        for group, where in self.groups:
            if asked := self.of(events, group, transitions, guards):
                targets |= (states if where is self.everything else states & where).images(asked)
        for event, where in self.guarded(events, transitions, guards):
            targets |= (states & where).images([event])
        return targets

    def reaching(
        self,
        goal: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
    ) -> Zdd:
        """States from which some run through ``along`` leads into a goal, the goal's own included.

        The initial state leads to every other: so do those that lead to it.
        """
        if along is None and transitions is None and not guards and goal:
            goal |= self.returning
        return self._leading_to(goal, along, transitions, guards)

    @cached_property
    def returning(self) -> Zdd:
        """States from which some run leads to the initial one: all of them where the net is reversible."""
        return self._leading_to(self.initial)

    def _leading_to(
        self,
        goal: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
    ) -> Zdd:
        """:meth:`reaching`, by a closure back from the goal."""
        within = self.everything if along is None else along | goal
        if goal == within:
            return within
        free = self.of(self.encoding.undoing, self.free, transitions, guards)
        sources = self.closure(goal, free, within)

        def back(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.closure(states.images(events, within=where), free, within)

        ways = self.ways(self.encoding.undoing, transitions, guards)
        return chained(
            sources, [partial(back, events=events, where=where & within) for events, where in ways]
        )

    def reached(
        self,
        begin: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
    ) -> Zdd:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        within = self.everything if along is None else along
        if along is None and transitions is None and not guards and begin & self.returning:
            return within
        free = self.of(self.encoding.events, self.free, transitions, guards)
        targets = self.closure(begin, free, within)

        def ahead(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.closure((states & where).images(events), free, within)

        ways = self.ways(self.encoding.events, transitions, guards)
        return chained(targets, [partial(ahead, events=events, where=where) for events, where in ways])

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """Those of some states with an edge of some transitions that leads to one of them."""
        sources = self.nothing
        for group, where in self.groups:
            if asked := self.of(self.encoding.undoing, group, transitions):
                within = states if where is self.everything else states & where
                leading = states.images(asked, within=within)
                self.steps += self.encoding.store.steps  # of the last operation
                sources |= leading
        return sources

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state."""
        marking = self.marking(state)
        for t in self.net.enabled(marking):
            yield Edge(t, self.encoding.marked_levels(self.net.fire(marking, t)))


class DiagramAlternatives(Diagrams):
    """The alternatives graph of a net with priorities whose internal evolution is confluent and ends.

    Args:
        space: The reachable markings of the net.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        assert space.stable is not None, "the alternatives graph is of nets with priorities"
        super().__init__(space, space.stable, behind(space.encoding, space.encoding.initial())[1])
        self._completion = Completion(self.net)
        self._endings = lru_cache(MOST_ENDINGS)(lambda goal: leading(self.encoding, goal, space.allowed))

    @cached_property
    def groups(self) -> list[tuple[list[int], Zdd]]:
        """Events alone label edges."""
        return [([], self.everything), (self.waiting, self.everything)]

    def settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return behind(self.encoding, after)[1]

    def ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return self._endings(goal)

    def leading_into(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """All states with an edge into some states."""
        return self.firing_into(self.ending(states), transitions, guards)

    def firing_into(
        self, markings: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States with an event whose firing makes some markings, before internal evolution."""
        undoing = self.encoding.undoing
        sources = markings.images(self.of(undoing, self.waiting, transitions, guards), within=self.everything)
        for event, where in self.guarded(undoing, transitions, guards):
            sources |= markings.images([event], within=where)
        return sources

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        events = self.encoding.events
        begun = states.images(self.of(events, self.waiting, transitions, guards))
        for event, where in self.guarded(events, transitions, guards):
            begun |= (states & where).images([event])
        return self.settled(begun)

    def reaching(
        self,
        goal: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
    ) -> Zdd:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        return chained(goal, self.back(self.everything if along is None else along, transitions, guards))

    def back(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """One step back along a set, for each element of the mission."""

        def back(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.ending(states).images(events, within=where)

        ways = self.ways(self.encoding.undoing, transitions, guards)
        return [partial(back, events=events, where=where & along) for events, where in ways]

    def reached(
        self,
        begin: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
    ) -> Zdd:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        within = self.everything if along is None else along
        return chained(begin & within, self.ahead(within, transitions, guards))

    def ahead(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """One step on along a set, for each element of the mission."""

        def ahead(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.settled((states & where).images(events)) & along

        ways = self.ways(self.encoding.events, transitions, guards)
        return [partial(ahead, events=events, where=where) for events, where in ways]

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state, each with one interleaving of the internal transitions behind it."""
        marking = self.marking(state)
        for t in self.net.enabled(marking):
            fired, after = self._completion.after(marking, t)
            yield Edge(t, self.encoding.marked_levels(after), fired)
