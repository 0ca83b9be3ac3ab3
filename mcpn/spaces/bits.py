"""The space of a graph of few states: a set is an integer with a bit for each state.

Nothing is loaded for it, and an operation takes about as long as a call of a library of arrays. What follows
a state is an integer, too, so that a closure takes one operation for each state.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

from mcpn._kernel import Zdd
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.algebra import Edge, Guards
from mcpn.spaces.by_steps import BySteps
from mcpn.spaces.memoized import ByKey, memoized
from mcpn.spaces.projections import ImageStore

Steps: TypeAlias = Sequence[int]
"""By state, those one edge away, a bit for each."""


class BitSet:
    """A set of states of one graph.

    Args:
        bits: Bit ``s`` for state ``s``.
    """

    __slots__ = ("bits",)

    def __init__(self, bits: int) -> None:
        self.bits = bits

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BitSet) and self.bits == other.bits

    def __hash__(self) -> int:
        return hash(self.bits)

    def __and__(self, other: BitSet) -> BitSet:
        return BitSet(self.bits & other.bits)

    def __or__(self, other: BitSet) -> BitSet:
        return BitSet(self.bits | other.bits)

    def __sub__(self, other: BitSet) -> BitSet:
        return BitSet(self.bits & ~other.bits)

    def __bool__(self) -> bool:
        return self.bits != 0

    def __iter__(self) -> Iterator[int]:
        """The states, ascending."""
        left = self.bits
        while left:
            lowest = left & -left
            yield lowest.bit_length() - 1
            left ^= lowest

    def count(self) -> int:
        """How many states the set has."""
        return self.bits.bit_count()

    def pick(self) -> int | None:
        """The state with the lowest number."""
        return next(iter(self), None)


class BitSpace(BySteps[BitSet]):
    """An alternatives graph; state 0 is the initial one.

    Args:
        net: The net.
        markings: By state its marking, bit ``p`` for place ``p``.
        rows: By state its edges, each a transition and the state that it leads to.
    """

    def __init__(
        self, net: PetriNet, markings: Sequence[int], rows: Sequence[Sequence[tuple[int, int]]]
    ) -> None:
        self.net, self._markings, self._rows = net, markings, rows
        self.nothing = BitSet(0)
        self.everything = BitSet((1 << len(markings)) - 1)
        self.initial = self.single(0)
        self.dead = BitSet(sum(1 << state for state, row in enumerate(rows) if not row))
        self._marked = ByKey(self._marking)

    def _marking(self, place: int) -> int:
        """The states that mark a place, a bit for each."""
        return sum(1 << state for state, marking in enumerate(self._markings) if marking >> place & 1)

    def single(self, state: int) -> BitSet:
        """The set that holds one state, given by its number."""
        return BitSet(1 << state)

    def marking(self, state: int) -> Marking:
        """The marking of a state, as tokens by place."""
        marking = self._markings[state]
        return tuple(marking >> place & 1 for place in range(len(self.net.places)))

    def marked(self, places: Collection[int]) -> BitSet:
        """States that mark at least one of some places."""
        bits = 0
        for place in places:
            bits |= self._marked[place]
        return BitSet(bits)

    def restricted(self, states: BitSet, marked: Collection[int], unmarked: Collection[int]) -> BitSet:
        """Those of some states that mark all of some places, and none of others."""
        bits = states.bits
        for place in marked:
            bits &= self._marked[place]
        return BitSet(bits) - self.marked(unmarked)

    def at_most(self, weights: Mapping[int, int], bound: int) -> BitSet:
        """States whose weighted sum of tokens is at most a bound."""
        sums = (sum(weight for p, weight in weights.items() if m >> p & 1) for m in self._markings)
        return BitSet(sum(1 << state for state, weighed in enumerate(sums) if weighed <= bound))

    @cached_property
    def _edges(self) -> Mapping[int, tuple[int, Sequence[tuple[int, int]]]]:
        """By transition, the states before it, a bit for each, and its edges: the states before and after."""
        found: dict[int, list[tuple[int, int]]] = {}
        for state, row in enumerate(self._rows):
            for t, target in row:
                found.setdefault(t, []).append((state, target))
        return {t: (sum(1 << s for s, _ in edges), edges) for t, edges in sorted(found.items())}

    def enabling(self, transitions: Collection[int]) -> BitSet:
        """States with an edge of some of these transitions."""
        bits = 0
        for t in transitions:
            if t in self._edges:
                bits |= self._edges[t][0]
        return BitSet(bits)

    def firings(self, states: BitSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts = ((t, (before & states.bits).bit_count()) for t, (before, _) in self._edges.items())
        return {t: count for t, count in counts if count}

    def image(self, states: BitSet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.spaces.algebra.Space.image`."""
        wanted = sum(1 << place for place in places)
        numbers = {place: number for number, place in enumerate(places)}
        found = {self._markings[state] & wanted for state in states}
        return images.of_rows([sorted(numbers[place] for place in BitSet(each)) for each in sorted(found)])

    def _steps(self, transitions: Collection[int] | None, guards: Guards[BitSet], back: bool) -> Steps:
        """Where edges of some transitions lead to, or come from."""
        wanted = None if transitions is None else frozenset(transitions)
        return self._made(wanted, guards, back) if guards else self._unguarded(wanted, back)

    @memoized
    def _unguarded(self, wanted: frozenset[int] | None, back: bool) -> Steps:
        return self._made(wanted, None, back)

    def _made(self, wanted: frozenset[int] | None, guards: Guards[BitSet], back: bool) -> Steps:
        steps = [0] * len(self._rows)
        for t, (_, edges) in self._edges.items():
            if wanted is None or t in wanted:
                allowed = guards[t].bits if guards and t in guards else self.everything.bits
                for source, target in edges:
                    if allowed >> source & 1:
                        at, to = (target, source) if back else (source, target)
                        steps[at] |= 1 << to
        return steps

    def before(
        self,
        states: BitSet,
        transitions: Collection[int] | None = None,
        guards: Guards[BitSet] = None,
        among: BitSet | None = None,
    ) -> BitSet:
        """States with an edge into some states."""
        found = BitSet(_led(states, self._steps(transitions, guards, back=True)))
        return found if among is None else found & among

    def after(
        self,
        states: BitSet,
        transitions: Collection[int] | None = None,
        guards: Guards[BitSet] = None,
    ) -> BitSet:
        """States that an edge leads to from some states."""
        return BitSet(_led(states, self._steps(transitions, guards, back=False)))

    def edges(self, state: int) -> Iterator[Edge]:
        """The edges of one state."""
        return (Edge(t, after) for t, after in self._rows[state])

    def run(
        self,
        begin: int,
        goal: BitSet,
        along: BitSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[BitSet] = None,
    ) -> list[Edge] | None:
        """A shortest run from a state into a goal; see :meth:`mcpn.spaces.algebra.Space.run`.

        Among shortest runs it follows the lowest numbers.
        """
        steps = self._steps(transitions, guards, back=False)
        passing = (self.everything if along is None else along).bits
        layers, seen = [1 << begin], 1 << begin
        while not layers[-1] & goal.bits:
            layers.append(_led(BitSet(layers[-1] & passing), steps) & ~seen)
            seen |= layers[-1]
            if not layers[-1]:
                return None
        run: list[Edge] = []
        state = BitSet(layers[-1] & goal.bits).pick()
        for layer in layers[-2::-1]:
            assert state is not None, "each layer leads to the next"
            before = next(s for s in BitSet(layer & passing) if steps[s] >> state & 1)
            run.append(Edge(self._first(before, state, transitions, guards), state))
            state = before
        return run[::-1]

    def _first(
        self, source: int, target: int, transitions: Collection[int] | None, guards: Guards[BitSet]
    ) -> int:
        """The first transition of the edges from a state to another."""
        return next(
            t
            for t, after in self._rows[source]
            if after == target
            and (transitions is None or t in transitions)
            and not (guards and t in guards and not guards[t].bits >> source & 1)
        )


def _led(states: BitSet, steps: Steps) -> int:
    bits, left = 0, states.bits
    while left:
        lowest = left & -left
        bits |= steps[lowest.bit_length() - 1]
        left ^= lowest
    return bits
