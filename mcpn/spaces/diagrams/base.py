"""What both spaces of decision diagrams share: what states say, single states, shortest runs."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import BudgetExceeded, Zdd
from mcpn.nets.petri import Marking
from mcpn.spaces.algebra import Edge, Guards
from mcpn.spaces.by_steps import BySteps
from mcpn.spaces.diagrams.closing import elements
from mcpn.spaces.diagrams.encoding import distinct
from mcpn.spaces.diagrams.greatest_fixpoint import Staying
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.projections import ImageStore

CLOSURE_FACTOR = 4
"""By how many times the budget of a closure grows from turn to turn."""


class Diagrams(BySteps[Zdd]):
    """What both spaces of diagrams share.

    Args:
        space: The reachable markings of a net.
        states: Those that are states of the graph.
    """

    first_steps = 20_000
    """Budget of a closure's first turn."""
    steps_of_layers = 3_000
    """Budget of the layers of :meth:`staying` before anything else is tried."""

    def __init__(self, space: SymbolicSpace, states: Zdd, initial: Zdd) -> None:
        self.space = space
        self.encoding = space.encoding
        self.net = space.encoding.net
        self.everything = states
        self.initial = initial
        self.nothing = self.encoding.store.empty()
        self.most_steps = 0  # about the most that a closure may take; 0: any number
        self.steps = 0  # what layers have taken
        self._left_off: dict[tuple[Zdd, Zdd | None], Staying] = {}
        self._closing: dict[tuple[Zdd, tuple[int, ...], Zdd], tuple[Zdd, int]] = {}
        self.free, self.waiting = space.free, space.waiting

    @cached_property
    def dead(self) -> Zdd:
        """States without an edge; a dead marking is stable."""
        return self.space.dead

    @cached_property
    def stable(self) -> Zdd:
        """States that enable no internal transition; all where the net has no priorities."""
        return self.everything if self.space.stable is None else self.space.stable

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

    def restricted(self, states: Zdd, marked: Collection[int], unmarked: Collection[int]) -> Zdd:
        """Those of some states that mark all of some places, and none of others."""
        condition = self.encoding.condition(marked, unmarked)
        return self.nothing if condition is None else states - states.without([condition])

    def at_most(self, weights: Mapping[int, int], bound: int) -> Zdd:
        """States whose weighted sum of tokens is at most a bound."""
        return self.encoding.at_most(self.everything, weights, bound)

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""
        before, enabling = self.nothing, self.encoding.enabling
        for group, states in self.groups:
            wanted = set(group).intersection(transitions)
            conditions = [c for t in sorted(wanted) if (c := enabling[t]) is not None]
            if conditions:
                before |= states - states.without(conditions)
        return before

    def firings(self, states: Zdd) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        firings: dict[int, int] = {}
        for group, where in self.groups:
            wanted = [(t, c) for t in group if (c := self.encoding.enabling[t]) is not None]
            counts = (states if where is self.everything else states & where).counts([c for _, c in wanted])
            firings.update((t, n) for (t, _), n in zip(wanted, counts, strict=True) if n)
        return firings

    @cached_property
    def groups(self) -> list[tuple[list[int], Zdd]]:
        """Transitions that label edges, each group with the states in which they may fire."""
        return self.space.groups

    def image(self, states: Zdd, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.spaces.algebra.Space.image`."""
        return images.of_diagram(states, self.encoding.store, [self.encoding.bit(p) for p in places])

    def ways(
        self, events: Mapping[int, int], transitions: Collection[int] | None, guards: Guards[Zdd]
    ) -> list[tuple[list[int], Zdd]]:
        """Events of the store for transitions that are not free, in groups with where each may fire.

        Without a guard, internal transitions are grouped by rank, and event transitions by the element of the
        mission that they belong to. Each transition with a guard is a group of its own.
        """
        wanted = set(self.waiting) if transitions is None else set(self.waiting).intersection(transitions)
        wanted.difference_update(guards or ())
        groups = [
            (distinct(events[t] for t in own if t in wanted), self.stable) for own in elements(self.encoding)
        ]
        later = [(self.of(events, group, transitions, guards), where) for group, where in self.groups[1:-1]]
        guarded = (([event], where) for event, where in self.guarded(events, transitions, guards))
        return [*((group, where) for group, where in (*later, *groups) if group), *guarded]

    def of(
        self,
        events: Mapping[int, int],
        group: Sequence[int],
        transitions: Collection[int] | None,
        guards: Guards[Zdd] = None,
    ) -> list[int]:
        """Events of the store for those transitions of a group that are asked for and have no guard."""
        wanted = None if transitions is None else set(transitions)
        return distinct(
            events[t]
            for t in group
            if (wanted is None or t in wanted) and (guards is None or t not in guards)
        )

    def guarded(
        self, events: Mapping[int, int], transitions: Collection[int] | None, guards: Guards[Zdd]
    ) -> list[tuple[int, Zdd]]:
        """Events of the store for transitions with a guard that are asked for, with where they may fire."""
        groups = []
        for t, states in (guards or {}).items():
            if t in events and (transitions is None or t in transitions):
                groups.append((events[t], states & self.where[t]))
        return groups

    @cached_property
    def where(self) -> Mapping[int, Zdd]:
        """By transition, the markings in which priorities let it fire."""
        if not self.net.priorities:
            return dict.fromkeys(range(len(self.net.transitions)), self.everything)
        internal = zip(self.net.internal_ranks, self.space.allowed, strict=True)
        allowed_in = {t: where for transitions, where in internal for t in transitions}
        return {t: allowed_in.get(t, self.stable) for t in range(len(self.net.transitions))}

    def closure(self, begin: Zdd, events: Sequence[int], within: Zdd) -> Zdd:
        """The states that some events lead to inside a set, by saturation or by layers, turn by turn.

        Saturation makes many nodes that the result has not where its order of places suits the forward
        events alone; one step of all events after the other may then need few of them. Each has a budget of
        steps, which grows, and goes on where it was, also when the closure is asked for again after an error
        has ended it.
        """
        store, key = self.encoding.store, (begin, tuple(events), within)
        reached, budget = self._closing.pop(key, (begin & within, self.first_steps))
        try:
            while reached != within:
                try:
                    return begin.saturate(events, within=within, max_steps=budget)
                except BudgetExceeded:
                    spent = 0
                while spent < budget:
                    after = reached.images(events, within=within)
                    spent += store.steps
                    wider = reached | after
                    spent += store.steps
                    if wider == reached:
                        return reached
                    reached = wider
                    if reached == within:
                        return reached
                budget *= CLOSURE_FACTOR
                if self.most_steps and budget > self.most_steps:
                    raise BudgetExceeded(f"a closure took more than {self.most_steps} steps")
            return reached
        except BaseException:
            self._closing[key] = reached, budget
            raise

    def before(
        self,
        states: Zdd,
        transitions: Collection[int] | None = None,
        guards: Guards[Zdd] = None,
        among: Zdd | None = None,
    ) -> Zdd:
        """States with an edge into some states."""
        before = self.leading_into(states, transitions, guards)
        return before if among is None else before & among

    def leading_into(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """All states with an edge into some states."""
        raise NotImplementedError

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        raise NotImplementedError

    def edges(self, state: Sequence[int]) -> Iterator[Edge]:
        """The edges of one state."""
        raise NotImplementedError

    def staying(
        self, along: Zdd, asked: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        """States from which some maximal run stays in a set; see :meth:`mcpn.spaces.algebra.Space.staying`.

        What was left off because its time was spent goes on where it was; see
        :mod:`mcpn.spaces.diagrams.greatest_fixpoint`.
        """
        if transitions is not None:
            ends, left = along - self.enabling(transitions), along
            while (kept := self.continuing(left, transitions) | (left & ends)) != left:
                left = kept
            return left
        search = self._left_off.setdefault((along, asked), Staying(self, along, asked))
        states_left = search.states()
        del self._left_off[along, asked]
        return states_left

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """Those of some states with an edge of some transitions that leads to one of them."""
        sources = self.before(states, transitions)
        self.steps += self.encoding.store.steps
        return sources & states

    def firing(self, states: Zdd) -> frozenset[int]:
        """Transitions that fire on edges from some states, or more."""
        internal = (t for t, made in enumerate(self.net.transitions) if made.internal)
        return frozenset(self.firings(states)).union(internal if self.net.priorities else ())
