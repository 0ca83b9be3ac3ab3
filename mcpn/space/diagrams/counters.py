"""A net with several tokens in a place on the levels of a diagram store: each place is a binary counter.

A place of ``n`` levels counts up to ``2^n - 1`` tokens, its lowest bit on top. What a transition does to a
place is a comparison and an addition, carried from bit to bit; the store holds both as one small event that
goes on depending on each bit (:meth:`mcpn._kernel.Store.branch`), place after place. So an event grows with
the sum of the sizes of its places, not with their product.

A firing that would not fit is left out, and :attr:`TokenEncoding.overflows` says where that happens.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Store
from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.diagrams.order import Order
from mcpn.space.search.goal import changes, needs

MOST_BITS = 30
"""Beyond, what a place adds to a sum of tokens is no number of the kernel."""


class TokenEncoding(Encoding):
    """A net without priorities whose places hold several tokens, on the levels of a store.

    Args:
        net: The net.
        order: Places from the top on.
        memory_limit: Bytes for the store.
        widths: By place, how many levels it has; its initial tokens fit.
    """

    def __init__(self, net: PetriNet, order: Order, memory_limit: int, widths: Sequence[int]) -> None:
        self.net = net
        self.memory_limit = memory_limit
        self.partner = {}
        self.widths = tuple(widths)
        self.bits: dict[int, range] = {}
        """By place, its levels, that of the lowest bit first."""
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
        found = {t: self._checked(self._needs[t]) for t in range(len(net.transitions))}
        self.transitions = [t for t, condition in found.items() if condition is not None]
        self.enabling = found
        self.events = {
            t: event
            for t in self.transitions
            if (event := self._changed(self._needs[t], self._deltas[t])) is not None
        }

    # --- comparisons and additions ---

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
        bits, branch = self.bits[place], self.store.branch
        if need <= -delta:  # what cannot be taken is not there
            need = 0
        known: dict[tuple[int, int, bool], int | None] = {}

        def built(bit: int, carry: int, enough: bool) -> int | None:
            """What is left from a bit on; ``enough``: the bits before count as much as those needed."""
            wanted = need >> bit
            if carry == 0 and wanted == 0 and enough:
                return then
            if bit == len(bits):
                return None
            key = bit, carry, enough
            if key not in known:
                ways: dict[tuple[int, int], int | None] = {}
                for tokens in (0, 1):
                    total = tokens + carry
                    still = enough if tokens == wanted & 1 else tokens > wanted & 1
                    ways[tokens, total & 1] = built(bit + 1, total >> 1, still)
                zero, produce = ways.get((0, 0)), ways.get((0, 1))
                read, consume = ways.get((1, 1)), ways.get((1, 0))
                if (zero, read, produce, consume) == (None,) * 4:
                    known[key] = None
                elif zero == read and produce is None and consume is None:
                    known[key] = zero
                else:
                    known[key] = branch(bits[bit], consume, produce, read, zero)
            return known[key]

        return built(0, delta, True)

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
        found = []
        for t, deltas in enumerate(self._deltas):
            for place, delta in deltas.items():
                if delta > 0:
                    least = max(self._needs[t].get(place, 0), self.capacity(place) - delta + 1)
                    condition = self._checked(self._needs[t] | {place: least})
                    if condition is not None:
                        found.append((place, condition))
        return found

    @cached_property
    def undoing(self) -> dict[int, int]:
        """By transition, the event that takes a marking after its firing back to the one before."""
        found = {}
        for t in self.events:
            deltas = self._deltas[t]
            after = {place: max(need + deltas.get(place, 0), 0) for place, need in self._needs[t].items()}
            for place, delta in deltas.items():
                after.setdefault(place, max(delta, 0))
            event = self._changed(after, {place: -delta for place, delta in deltas.items()})
            assert event is not None, "what can be fired can be undone"
            found[t] = event
        return found

    # --- the same questions as of 1-safe nets ---

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
            for place, bits in self.bits.items()
            for bit, level in enumerate(bits)
            if marking[place] >> bit & 1
        ]

    def marking(self, levels: Iterable[int]) -> tuple[int, ...]:
        """The tokens by place of a marking given as its marked levels."""
        tokens = [0] * len(self.net.places)
        for level in levels:
            place = self.places[level]
            tokens[place] += 1 << (level - self.bits[place].start)
        return tuple(tokens)

    def weigh(self, weights: Mapping[int, int]) -> tuple[list[int], int]:
        """A weighted sum of tokens by what each marked level adds to it.

        Raises:
            LimitError: A weight is more than the kernel can say.
        """
        levels = [0] * len(self.places)
        for place, weight in weights.items():
            for bit, level in enumerate(self.bits[place]):
                levels[level] = weight << bit
        if max(map(abs, levels), default=0) >= 1 << 31:
            raise LimitError("a sum of tokens is beyond 2^31: the limit of the symbolic engine was hit")
        return levels, 0
