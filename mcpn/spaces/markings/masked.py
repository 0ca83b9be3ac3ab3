"""1-safe markings as integers, a bit for each place, and what fires in them.

This is :meth:`mcpn.nets.petri.PetriNet.fire` for 1-safe nets, made quick: after a firing only the transitions
beside a place that changed are looked at again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mcpn.errors import UnsafeError
from mcpn.nets.petri import PetriNet


def unsafe_at_start(net: PetriNet) -> UnsafeError | None:
    """The error of an initial marking that holds several tokens in a place."""
    for place in net.places:
        if place.initial > 1:
            return UnsafeError(place.name, "", net.marked(net.initial), [])
    return None


def mask_of(marking: Sequence[int]) -> int:
    """A 1-safe marking as an integer, a bit for each place."""
    return sum(1 << place for place, tokens in enumerate(marking) if tokens)


def bits_of(mask: int) -> list[int]:
    """The places of a mask, ascending."""
    return [place for place in range(mask.bit_length()) if mask >> place & 1]


def unsafe_after(net: PetriNet, run: Sequence[int]) -> UnsafeError:
    """The error of a run whose last firing puts a second token in a place.

    Args:
        net: The net.
        run: Transitions from the initial marking on.
    """
    *run, last = run
    marking = net.initial
    for t in run:
        marking = net.fire(marking, t)
    after = net.fire(marking, last)
    place = next(p for p, tokens in enumerate(after) if tokens > 1)
    names = [net.transitions[t].name for t in run]
    return UnsafeError(net.places[place].name, net.transitions[last].name, net.marked(marking), names)


class MaskedNet:
    """A net prepared for firing on integers.

    Args:
        net: The net.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        safe = net.safe_transitions
        self.need = [_bits(t.consume) | _bits(t.read) for t in safe]
        self.take = [_bits(t.consume) for t in safe]
        self.put = [_bits(t.produce) for t in safe]
        self.overflow = [_bits(t.overflow) for t in safe]
        blocked = [t.blocked for t in safe]
        users: list[list[int]] = [[] for _ in net.places]
        for number, t in enumerate(safe):
            if not blocked[number]:
                for place in (*t.consume, *t.read):
                    users[place].append(number)
        self.candidates = [t for t in range(len(safe)) if not blocked[t]]
        # By transition: those that its firing may disable, a bit for each, and those that it may enable.
        self.losers = [_bits(u for p in t.consume for u in users[p]) for t in safe]
        self.winners = [sorted({u for p in t.produce for u in users[p]}) for t in safe]
        self.ranks = [_bits(rank) for rank in net.internal_ranks] if net.priorities else []
        self.internal = sum(self.ranks)

    def initial(self) -> int:
        """The initial marking.

        Raises:
            UnsafeError: It holds two tokens in a place.
        """
        if error := unsafe_at_start(self.net):
            raise error
        return mask_of(self.net.initial)

    def covered(self, marking: int) -> int:
        """The transitions whose tokens are there, a bit for each."""
        return _bits(t for t in self.candidates if marking & self.need[t] == self.need[t])

    def covered_after(self, covered: int, marking: int, fired: int) -> int:
        """The transitions whose tokens are there after a firing, from those before it.

        Args:
            covered: What was covered before.
            marking: The marking after the firing.
            fired: The transition fired.
        """
        covered &= ~self.losers[fired]
        for t in self.winners[fired]:
            if marking & self.need[t] == self.need[t]:
                covered |= 1 << t
        return covered

    def first(self, covered: int) -> int:
        """Those of some covered transitions that may fire, a bit for each."""
        return next((left for rank in self.ranks if (left := covered & rank)), covered)

    def allowed(self, covered: int) -> Iterator[int]:
        """The transitions that may fire among those covered: internal ones first, by rank."""
        left = self.first(covered)
        while left:
            lowest = left & -left
            yield lowest.bit_length() - 1
            left ^= lowest

    def fire(self, marking: int, transition: int) -> tuple[int, int]:
        """The marking after a firing, and the places that would hold two tokens (0 where it is safe)."""
        kept = marking & ~self.take[transition]
        put = self.put[transition]
        return kept | put, kept & put | self.overflow[transition]

    def marked(self, marking: int) -> frozenset[str]:
        """Names of the marked places."""
        return frozenset(place.name for i, place in enumerate(self.net.places) if marking >> i & 1)


def _bits(indices: Iterator[int] | tuple[int, ...] | list[int]) -> int:
    mask = 0
    for index in indices:
        mask |= 1 << index
    return mask
