"""A net with several tokens in a place on the levels of a diagram store: each place is a binary counter.

A place of ``n`` levels counts up to ``2^n - 1`` tokens. What a transition does to a place is a comparison and
an addition, carried from bit to bit; the store holds both as one small event that goes on depending on each
bit (:meth:`mcpn._kernel.Store.branch`), place after place. So an event grows with the sum of the sizes of its
places, not with their product.

With the lowest bit on top an addition is decided from level to level, and events are small; on most nets this
is the quicker way, by three to six times. With the highest bit on top, saturation closes the low bits before
it carries into a higher one, and so lets a place that nothing else bounds count to a million in twenty steps.

A firing that would not fit is left out, and :attr:`TokenEncoding.overflows` says where that happens.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import product

from mcpn._kernel import Store
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import changes, needs
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.order import Order

MOST_BITS = 30
"""The most levels of a place."""


class TokenEncoding(Encoding):
    """A net without priorities whose places hold several tokens, on the levels of a store.

    Args:
        net: The net.
        order: Places from the top on.
        memory_limit: Bytes for the store.
        widths: By place, how many levels it has; its initial tokens fit.
        low_first: Whether the lowest bit of a place is on top, else the highest.
    """

    def __init__(
        self,
        net: PetriNet,
        order: Order,
        memory_limit: int,
        widths: Sequence[int],
        low_first: bool = True,
    ) -> None:
        self.net = net
        self.low_first = low_first
        self.memory_limit = memory_limit
        self.partner = {}
        self.counters = tuple(widths), low_first
        self.bits: dict[int, range] = {}
        """By place, its levels from the top on."""
        at = 0
        for place in order:
            self.bits[place] = range(at, at + widths[place])
            at += widths[place]
        self.places = tuple(place for place in order for _ in self.bits[place])
        self.level = {place: bits[0] for place, bits in self.bits.items() if bits}
        self.store = Store(at, memory_limit)
        self._anything = self.store.condition([])
        self._needs = [needs(net, t) for t in range(len(net.transitions))]
        self._deltas = [changes(net, t) for t in range(len(net.transitions))]
        self.enabling = {t: self._checked(self._needs[t]) for t in range(len(net.transitions))}
        self.transitions = [t for t, condition in self.enabling.items() if condition is not None]
        self.events = {
            t: event
            for t in self.transitions
            if (event := self._changed(self._needs[t], self._deltas[t])) is not None
        }

    def capacity(self, place: int) -> int:
        """The most tokens that a place can count."""
        return int(2 ** len(self.bits[place]) - 1)

    def _change(self, place: int, need: int, delta: int, then: int) -> int | None:
        """An event of the store: at least so many tokens are in a place, and so many are added to it.

        Args:
            place: The place.
            need: Least tokens.
            delta: What is added; negative: taken.
            then: What happens on levels below.

        Returns:
            The event, or ``None`` where no content of the place allows it.
        """
        levels, branch = self.bits[place], self.store.branch
        width = len(levels)
        if need <= -delta:  # what cannot be taken is not there
            need = 0
        if max(need, abs(delta)) >> width:
            return None
        size, sign = abs(delta), 1 if delta > 0 else -1
        known: dict[tuple[int, int, bool], int | None] = {}

        def built(at: int, carry: int, more: bool) -> int | None:
            """What the levels of the place from one on do.

            Args:
                at: How many of its bits are behind.
                carry: What is carried between them and those ahead.
                more: Whether the content of those behind is more than is needed; as much will do of low bits.
            """
            ahead = -1 << at if self.low_first else (1 << width - at) - 1
            enough = (more or not self.low_first) if not need & ahead else (more and not self.low_first)
            if carry == 0 and not size & ahead and enough:
                return then
            if at == width:
                return None
            key = at, carry, more
            if key not in known:
                bit = at if self.low_first else width - 1 - at
                added, wanted = sign * (size >> bit & 1), need >> bit & 1
                ways: dict[tuple[int, int], int | None] = {}
                for before, after, beyond in product((0, 1), (0, 1), (0, sign)):
                    into, out = (carry, beyond) if self.low_first else (beyond, carry)
                    if before + added + into != after + 2 * out:
                        continue
                    if self.low_first:  # the higher bit decides
                        still = more if before == wanted else before > wanted
                    elif more or before >= wanted:
                        still = more or before > wanted
                    else:
                        continue
                    ways[before, after] = built(at + 1, beyond, still)
                zero, produce = ways.get((0, 0)), ways.get((0, 1))
                read, consume = ways.get((1, 1)), ways.get((1, 0))
                if (zero, read, produce, consume) == (None,) * 4:
                    known[key] = None
                elif zero == read and produce is None and consume is None:
                    known[key] = zero
                else:
                    known[key] = branch(levels[at], consume, produce, read, zero)
            return known[key]

        return built(0, 0, self.low_first)

    def _changed(self, needs: Mapping[int, int], deltas: Mapping[int, int]) -> int | None:
        """An event: in each place at least so many tokens are, and so many are added to it."""
        event: int | None = self._anything
        for place in sorted({*needs, *deltas}, key=lambda p: -self.bits[p].start):
            if event is None:
                return None
            event = self._change(place, needs.get(place, 0), deltas.get(place, 0), event)
        return event

    def _checked(self, needs: Mapping[int, int]) -> int | None:
        """A condition: in each place at least so many tokens are."""
        return self._changed(needs, {})

    @cached_property
    def overflows(self) -> list[tuple[int, int]]:
        """Pairs of a place and the condition under which some firing would put too many tokens in it."""
        pairs = []
        for t, deltas in enumerate(self._deltas):
            for place, delta in deltas.items():
                if delta > 0:
                    least = max(self._needs[t].get(place, 0), self.capacity(place) - delta + 1)
                    condition = self._checked(self._needs[t] | {place: least})
                    if condition is not None:
                        pairs.append((place, condition))
        return pairs

    @cached_property
    def undoing(self) -> dict[int, int]:
        """By transition, the event that takes a marking after its firing back to the one before."""
        inverse = {}
        for t in self.events:
            deltas = self._deltas[t]
            after = {place: max(need + deltas.get(place, 0), 0) for place, need in self._needs[t].items()}
            for place, delta in deltas.items():
                after.setdefault(place, max(delta, 0))
            event = self._changed(after, {place: -delta for place, delta in deltas.items()})
            assert event is not None, "what can be fired can be undone"
            inverse[t] = event
        return inverse

    def condition(self, marked: Iterable[int], unmarked: Iterable[int] = ()) -> int | None:
        """A condition of the store, or ``None`` where it contradicts itself."""
        some, none = set(marked), set(unmarked)
        condition: int | None = self._anything
        for place in sorted(some | none, key=lambda p: -self.bits[p].start):
            if condition is None or (place in some and place in none):
                return None
            if place in some:
                condition = self._change(place, 1, 0, condition)
            else:
                for level in reversed(self.bits[place]):
                    condition = self.store.branch(level, zero=condition)
        return condition

    def marked_levels(self, marking: Sequence[int]) -> list[int]:
        """The marked levels of a marking, given as tokens by place."""
        return [
            level
            for place, levels in self.bits.items()
            for level in levels
            if marking[place] >> self._bit(place, level) & 1
        ]

    def _bit(self, place: int, level: int) -> int:
        levels = self.bits[place]
        return level - levels.start if self.low_first else levels.stop - 1 - level

    def marking(self, levels: Iterable[int]) -> tuple[int, ...]:
        """The tokens by place of a marking given as its marked levels."""
        tokens = [0] * len(self.net.places)
        for level in levels:
            place = self.places[level]
            tokens[place] += 1 << self._bit(place, level)
        return tuple(tokens)

    def weighed(self, weights: Mapping[int, int]) -> tuple[list[int], int]:
        """A weighted sum of tokens by what each marked level adds to it."""
        levels = [0] * len(self.places)
        for place, weight in weights.items():
            for level in self.bits[place]:
                levels[level] = weight << self._bit(place, level)
        return levels, 0
