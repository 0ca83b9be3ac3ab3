"""Places before and after each transition of a net, as sets of bits; and members of such sets.

A read arc counts as consuming and producing a token at once: its place stands before and after the
transition, unless the transition consumes from it besides.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from mcpn.nets.petri import PetriNet

Places: TypeAlias = tuple[int, ...]
"""A set of places, in their order."""


def surroundings(net: PetriNet) -> list[tuple[int, int]]:
    """Places before and after each transition, as sets of bits.

    A place that is read as well as consumed from stands before only: its token does not stay.
    """
    pairs = []
    for t in net.transitions:
        taken, put, still = (bits_of(p for p, _ in arcs) for arcs in (t.consume, t.produce, t.read))
        pairs.append((taken | still, put | still & ~taken))
    return pairs


def bits_of(members: Iterable[int]) -> int:
    """A set of numbers as bits."""
    return sum(1 << member for member in set(members))


def members(bits: int) -> list[int]:
    """The members of a set of bits, in their order."""
    return [i for i in range(bits.bit_length()) if bits >> i & 1]
