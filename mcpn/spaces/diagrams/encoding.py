"""A 1-safe net on the levels of a diagram store: its places, its transitions, and back."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import chain

from mcpn._kernel import Store, Zdd
from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import complements
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.projections import Bit

MOST_WEIGHT = 2**105
"""What a level may add to a sum of tokens; the kernel's sums over all levels are exact."""
FARTHEST = 2**126
"""Sums of tokens are nearer than this bound."""


class Levels:
    """The levels of a store by what they say of the places of a net."""

    store: Store

    def bit(self, place: int) -> Bit:
        """Where a set says whether a place is marked."""
        raise NotImplementedError

    def marks(self, levels: Collection[int], place: int) -> bool:
        """Whether a marking, given as its marked levels, marks a place."""
        bit = self.bit(place)
        return bit if isinstance(bit, bool) else (bit[0] in levels) != bit[1]

    def sides(
        self, marked: Iterable[int], unmarked: Iterable[int] = ()
    ) -> tuple[list[int], list[int]] | None:
        """The levels to be marked and those not to be, for some places; ``None`` where they contradict."""
        yes, no = set[int](), set[int]()
        for wanted, places in ((True, marked), (False, unmarked)):
            for place in places:
                bit = self.bit(place)
                if not isinstance(bit, bool):
                    (yes if bit[1] != wanted else no).add(bit[0])
                elif bit != wanted:
                    return None
        return None if yes & no else (sorted(yes), sorted(no))

    def condition(self, marked: Iterable[int], unmarked: Iterable[int] = ()) -> int | None:
        """A condition of the store, or ``None`` where it contradicts itself."""
        sides = self.sides(marked, unmarked)
        return None if sides is None else self.store.condition(*sides)

    def restricted(self, states: Zdd, marked: Iterable[int], unmarked: Iterable[int] = ()) -> Zdd:
        """Those of some markings that mark all of some places, and none of others."""
        sides = self.sides(marked, unmarked)
        return self.store.empty() if sides is None else states.subset(*sides)

    def weigh(self, weights: Mapping[int, int]) -> tuple[list[int], int]:
        """A weighted sum of tokens by what each marked level adds to it, and what is always there.

        Args:
            weights: By place; 0 for those not named.

        Raises:
            LimitError: A level adds more than the kernel counts.
        """
        levels, always = self.weighed(weights)
        if max(map(abs, levels), default=0) > MOST_WEIGHT:
            raise LimitError("a weight of tokens is beyond 2^105: the limit of the symbolic engine was hit")
        return levels, always

    def weighed(self, weights: Mapping[int, int]) -> tuple[list[int], int]:
        """:meth:`weigh` before its limit."""
        levels, always = [0] * self.store.levels, 0
        for place, weight in weights.items():
            bit = self.bit(place)
            if isinstance(bit, bool):
                always += weight * bit
            else:
                levels[bit[0]] += -weight if bit[1] else weight
                always += weight * bit[1]
        return levels, always

    def at_most(self, states: Zdd, weights: Mapping[int, int], bound: int) -> Zdd:
        """Those of some markings whose weighted sum of tokens is at most a bound."""
        levels, always = self.weigh(weights)
        return states.weighing(levels, -FARTHEST, bound - always)


class Encoding(Levels):
    """A net on the levels of a store.

    A place that is marked exactly where its partner is not needs no level: consuming it is producing its
    partner, and reading it is a test that the partner is unmarked.

    Args:
        net: The net, 1-safe at its initial marking.
        order: Places from the top on.
        memory_limit: Bytes for the store.
        store: A store that others use too, whose first levels are for the places; a new one by default.
    """

    counters: tuple[tuple[int, ...], bool] | None = None
    """Where places hold several tokens, how many levels each has, and whether the lowest bit is on top."""

    def __init__(self, net: PetriNet, order: Order, memory_limit: int, store: Store | None = None) -> None:
        self.net = net
        self.memory_limit = memory_limit
        self.partner: dict[int, int] = {}
        for kept, dropped in complements(net):
            if kept not in self.partner and dropped not in self.partner:
                self.partner[dropped] = kept
        self.places = tuple(p for p in order if p not in self.partner)
        self.level = {p: level for level, p in enumerate(self.places)}
        self.store = Store(len(self.places), memory_limit) if store is None else store
        live = [(i, t) for i, t in enumerate(net.safe_transitions) if not t.blocked]
        self.transitions = [i for i, _ in live]
        self.enabling = {i: self.condition((*t.consume, *t.read)) for i, t in live}
        self.events = {
            i: self.event(t.consume, t.produce, t.read)
            for i, t in live
            if not t.overflow and self.enabling[i] is not None
        }

    def levels(self, places: Iterable[int]) -> list[int]:
        """Levels of those places that have one."""
        return [self.level[p] for p in places if p in self.level]

    def event(self, consume: tuple[int, ...], produce: tuple[int, ...], read: tuple[int, ...]) -> int:
        """An event of the store."""
        # A dropped place and its partner change together, so the partner's arcs say it all.
        zero = sorted({self.level[self.partner[p]] for p in read if p in self.partner})
        return self.store.event(self.levels(consume), self.levels(produce), self.levels(read), zero)

    @cached_property
    def undoing(self) -> dict[int, int]:
        """By transition, the event that takes a marking after its firing back to the one before."""
        safe = self.net.safe_transitions
        return {t: self.event(safe[t].produce, safe[t].consume, safe[t].read) for t in self.events}

    @cached_property
    def internal_back(self) -> list[int]:
        """The events that undo internal transitions, each once."""
        return distinct(chain.from_iterable(self.undoing_ranks))

    @cached_property
    def internal_ranks(self) -> list[list[int]]:
        """The events of internal transitions by rank, those that fire first at first."""
        return [distinct(self.events[t] for t in own if t in self.events) for own in self.net.internal_ranks]

    @cached_property
    def undoing_ranks(self) -> list[list[int]]:
        """The events that undo internal transitions, by rank."""
        return [distinct(self.undoing[t] for t in own if t in self.events) for own in self.net.internal_ranks]

    @cached_property
    def unstable_ranks(self) -> list[list[int]]:
        """By rank, the conditions of the store under which an internal transition of it is enabled."""
        conditions = ([self.enabling.get(t) for t in rank] for rank in self.net.internal_ranks)
        return [[c for c in of_rank if c is not None] for of_rank in conditions]

    @property
    def unstable(self) -> list[int]:
        """The conditions of the store under which some internal transition is enabled."""
        return [*chain.from_iterable(self.unstable_ranks)]

    def bit(self, place: int) -> tuple[int, bool]:
        """The level that says whether a place is marked, and whether it says the reverse."""
        partner = self.partner.get(place)
        return (self.level[place], False) if partner is None else (self.level[partner], True)

    def marked_levels(self, marking: Sequence[int]) -> list[int]:
        """The marked levels of a marking, given as tokens by place."""
        return [level for level, place in enumerate(self.places) if marking[place]]

    def initial(self) -> Zdd:
        """The set that holds the initial marking."""
        return self.set_of(self.net.initial)

    def set_of(self, marking: Sequence[int]) -> Zdd:
        """The set that holds one marking, given as tokens by place."""
        return self.store.singleton(self.marked_levels(marking))

    def marking(self, levels: Iterable[int]) -> tuple[int, ...]:
        """The tokens by place of a marking given as its marked levels."""
        marked = {self.places[level] for level in levels if level < len(self.places)}
        marked.update(dropped for dropped, kept in self.partner.items() if kept not in marked)
        return tuple(int(p in marked) for p in range(len(self.net.places)))

    def most(self, markings: Zdd) -> list[int]:
        """The most tokens of each place in some markings, of which there are some."""
        weights = (self.weigh({place: 1}) for place in range(len(self.net.places)))
        return [markings.largest(levels) + always for levels, always in weights]


def distinct(events: Iterable[int]) -> list[int]:
    """Each event once: transitions that do the same are one event of the store."""
    return list(dict.fromkeys(events))
