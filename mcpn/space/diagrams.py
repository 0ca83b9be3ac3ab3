"""The spaces of decision diagrams: the markings of a net, or its stable states, as sets in the native kernel.

``reaching`` and ``reached`` are saturation inside a set where the net has no priorities (constrained
saturation: Zhao, Ciardo, *Symbolic CTL model checking of asynchronous systems using constrained saturation*,
ATVA 2009); with priorities, saturation by internal transitions alternates with steps of events, element by
element of the mission (*chaining*: Roig, Cortadella, Pastor, ICATPN 1995).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property, partial

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking
from mcpn.space.algebra import Edge
from mcpn.space.encoding import distinct
from mcpn.space.images import ImageStore
from mcpn.space.symbolic import SymbolicSpace, chained, elements

FARTHEST = 2**62
"""Sums of tokens are far from this bound, which the kernel can say."""


class _Diagrams:
    """What both spaces of diagrams share.

    Args:
        space: The reachable markings of a net.
        states: Those that are states of the graph.
    """

    def __init__(self, space: SymbolicSpace, states: Zdd, initial: Zdd) -> None:
        self.space = space
        self.encoding = space.encoding
        self.net = space.encoding.net
        self.everything = states
        self.initial = initial
        self.nothing = self.encoding.store.empty()
        free = {
            t for t in self.encoding.events if self.net.transitions[t].internal or not self.net.priorities
        }
        self._free = [t for t in self.encoding.events if t in free]
        """Transitions that fire wherever they have their tokens."""
        self._waiting = [t for t in self.encoding.events if t not in free]
        """Transitions that priorities let fire in stable markings only."""

    @property
    def regions(self) -> Sequence[Zdd]:
        """One region: the diagram does not know where cycles are."""
        return (self.everything,)

    @cached_property
    def dead(self) -> Zdd:
        """States without an edge; a dead marking is stable."""
        return self.space.dead

    @cached_property
    def stable(self) -> Zdd:
        """States that enable no internal transition; all where the net has no priorities."""
        return self.everything if self.space.stable is None else self.space.stable

    # --- what states say ---

    def single(self, state: Sequence[int]) -> Zdd:
        """The set that holds one state, given as its marked levels."""
        return self.encoding.store.singleton(list(state))

    def marking(self, state: Sequence[int]) -> Marking:
        """The marking of a state, as tokens by place."""
        return self.encoding.marking(state)

    def marked(self, places: Collection[int]) -> Zdd:
        """States that mark at least one of some places."""
        conditions = [self.encoding.condition([place]) for place in places]
        return self.everything - self.everything.without([c for c in conditions if c is not None])

    def at_most(self, weights: Mapping[int, int], bound: int) -> Zdd:
        """States whose weighted sum of tokens is at most a bound."""
        levels, constant = self.encoding.weigh(weights)
        return self.everything.weighing(levels, -FARTHEST, max(-FARTHEST, min(bound - constant, FARTHEST)))

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""
        found, enabling = self.nothing, self.encoding.enabling
        for states, group in ((self.everything, self._edges_anywhere), (self.stable, self._waiting)):
            wanted = set(group).intersection(transitions)
            conditions = [c for t in sorted(wanted) if (c := enabling[t]) is not None]
            if conditions:
                found |= states - states.without(conditions)
        return found

    def firings(self, states: Zdd) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        found: dict[int, int] = {}
        for among, group in ((states, self._edges_anywhere), (states & self.stable, self._waiting)):
            wanted = [(t, c) for t in group if (c := self.encoding.enabling[t]) is not None]
            counts = among.counts([c for _, c in wanted])
            found.update((t, n) for (t, _), n in zip(wanted, counts, strict=True) if n)
        return found

    @property
    def _edges_anywhere(self) -> list[int]:
        """Transitions that label edges out of any state that has their tokens."""
        return self._free

    def image(self, states: Zdd, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.space.algebra.Space.image`."""
        return images.of_diagram(states, self.encoding.store, [self.encoding.bit(p) for p in places])

    # --- helpers ---

    def _grouped(self, events: Mapping[int, int], transitions: Collection[int] | None) -> list[list[int]]:
        """Events of waiting transitions, by the element of the mission that they are of."""
        wanted = set(self._waiting) if transitions is None else set(self._waiting).intersection(transitions)
        groups = (distinct(events[t] for t in of if t in wanted) for of in elements(self.encoding))
        return [group for group in groups if group]

    def _of(
        self, events: Mapping[int, int], group: Sequence[int], transitions: Collection[int] | None
    ) -> list[int]:
        """Events of the store for those transitions of a group that are asked for."""
        wanted = None if transitions is None else set(transitions)
        return distinct(events[t] for t in group if wanted is None or t in wanted)

    def _shortest(
        self, begin: Sequence[int], goal: Zdd, along: Zdd | None, transitions: Collection[int] | None
    ) -> list[Zdd] | None:
        """Layers back from a goal until one holds a state: by the length of shortest runs from there."""
        start = self.single(begin)
        layers, seen = [goal], goal
        while not layers[-1] & start:
            earlier = self.before(layers[-1], transitions) - seen
            if along is not None:
                earlier &= along
            if not earlier:
                return None
            seen |= earlier
            layers.append(earlier)
        return layers

    def run(
        self,
        begin: Sequence[int],
        goal: Zdd,
        along: Zdd | None = None,
        transitions: Collection[int] | None = None,
    ) -> list[Edge] | None:
        """A shortest run from a state into a goal; see :meth:`mcpn.space.algebra.Space.run`."""
        layers = self._shortest(begin, goal, along, transitions)
        if layers is None:
            return None
        run, state = list[Edge](), begin
        wanted = None if transitions is None else set(transitions)
        for layer in reversed(layers[:-1]):
            edge = next(
                e
                for e in self.edges(state)
                if (wanted is None or e.transition in wanted) and self.single(e.target) & layer
            )
            run.append(edge)
            state = edge.target
        return run

    def before(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """States with an edge into some states."""
        raise NotImplementedError

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state."""
        raise NotImplementedError

    def staying(self, along: Zdd, asked: Zdd | None = None) -> Zdd:
        """States from which some maximal run stays in a set; see :meth:`mcpn.space.algebra.Space.staying`.

        Greatest fixpoint: states without a successor in the set are dropped until none is left; only what
        led into states just dropped is looked at again.
        """
        found, ends = along, self.dead
        lost = self._leaving(along - ends, along)
        while lost and (asked is None or asked & found):
            found -= lost
            lost = self._leaving((self.before(lost) & found) - ends, found)
        return found

    def _leaving(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set."""
        return states - self.before(into)


class DiagramMarkings(_Diagrams):
    """The markings graph of a net: its edges are firings, priorities respected.

    Args:
        space: The reachable markings of the net.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        super().__init__(space, space.reachable, space.encoding.initial())

    def before(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """States with an edge into some states."""
        undoing = self.encoding.undoing
        found = states.images(self._of(undoing, self._free, transitions), within=self.everything)
        if self._waiting:
            found |= states.images(self._of(undoing, self._waiting, transitions), within=self.stable)
        return found

    def after(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """States that an edge leads to from some states."""
        events = self.encoding.events
        found = states.images(self._of(events, self._free, transitions))
        if self._waiting:
            found |= (states & self.stable).images(self._of(events, self._waiting, transitions))
        return found

    def reaching(
        self, goal: Zdd, along: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        within = self.everything if along is None else along | goal
        free = self._of(self.encoding.undoing, self._free, transitions)
        found = goal.saturate(free, within=within)
        if not self._waiting:
            return found
        settled = within & self.stable

        def back(states: Zdd, events: list[int]) -> Zdd:
            return states.images(events, within=settled).saturate(free, within=within)

        groups = self._grouped(self.encoding.undoing, transitions)
        return chained(found, [partial(back, events=events) for events in groups])

    def reached(
        self, begin: Zdd, along: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        within = self.everything if along is None else along
        free = self._of(self.encoding.events, self._free, transitions)
        found = (begin & within).saturate(free, within=within)
        if not self._waiting:
            return found

        def ahead(states: Zdd, events: list[int]) -> Zdd:
            return ((states & self.stable).images(events) & within).saturate(free, within=within)

        groups = self._grouped(self.encoding.events, transitions)
        return chained(found, [partial(ahead, events=events) for events in groups])

    def _leaving(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set; cheaper than all states before it."""
        undoing = self.encoding.undoing
        left = states.beyond(into, [undoing[t] for t in self._free])
        if not self._waiting:
            return left
        settled = left & self.stable
        return (left - settled) | settled.beyond(into, [undoing[t] for t in self._waiting])

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state."""
        marking = self.marking(state)
        for t in self.net.enabled(marking):
            yield Edge(t, self.encoding.marked_levels(self.net.fire(marking, t)))


class DiagramAlternatives(_Diagrams):
    """The alternatives graph of a net with priorities whose internal evolution is confluent and ends.

    Args:
        space: The reachable markings of the net.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        assert space.stable is not None, "the alternatives graph is of nets with priorities"
        start = space.encoding.initial().saturate(space.encoding.internal) & space.stable
        super().__init__(space, space.stable, start)

    @property
    def _edges_anywhere(self) -> list[int]:
        return []

    def _settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return after.saturate(self.encoding.internal) & self.everything

    def _ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return goal.saturate(self.encoding.internal_back, within=self.space.reachable)

    def before(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """States with an edge into some states."""
        events = self._of(self.encoding.undoing, self._waiting, transitions)
        return self._ending(states).images(events, within=self.everything)

    def after(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """States that an edge leads to from some states."""
        return self._settled(states.images(self._of(self.encoding.events, self._waiting, transitions)))

    def reaching(
        self, goal: Zdd, along: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        within = self.everything if along is None else along

        def back(states: Zdd, events: list[int]) -> Zdd:
            return self._ending(states).images(events, within=within)

        groups = self._grouped(self.encoding.undoing, transitions)
        return chained(goal, [partial(back, events=events) for events in groups])

    def reached(
        self, begin: Zdd, along: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        within = self.everything if along is None else along

        def ahead(states: Zdd, events: list[int]) -> Zdd:
            return self._settled(states.images(events)) & within

        groups = self._grouped(self.encoding.events, transitions)
        return chained(begin & within, [partial(ahead, events=events) for events in groups])

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state, each with one interleaving of the internal transitions behind it."""
        net, marking = self.net, self.marking(state)
        for t in net.enabled(marking):
            fired, at = list[int](), net.fire(marking, t)
            while (enabled := net.enabled(at)) and net.transitions[enabled[0]].internal:
                fired.append(enabled[0])
                at = net.fire(at, enabled[0])
            yield Edge(t, self.encoding.marked_levels(at), tuple(fired))
