"""Families of small nets with known numbers of markings: what researchers of Petri nets measure engines with.

Each family makes a net for a size and says how many markings it has: by a closed form, or counted without a
net. The numbers are no answers of this program, so that engines, also those of others, can be tested.

>>> from mcpn.study import Study
>>> family = FAMILIES["kanban"]
>>> net = family.net(2)
>>> Study(net).states().states, family.markings(2)
(4600, 4600)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import comb

from mcpn.nets.petri import NetBuilder, PetriNet


@dataclass(frozen=True)
class NetFamily:
    """Nets that grow, with the number of their markings.

    Args:
        net: Makes the net of a size.
        known: The number of its markings by size: a closed form, or some numbers.
        source: Where the number comes from.
        least: The smallest size.
        safe: Whether all its nets are 1-safe.
    """

    net: Callable[[int], PetriNet]
    known: Callable[[int], int] | Mapping[int, int]
    source: str
    least: int = 1
    safe: bool = True

    def markings(self, size: int) -> int | None:
        """How many markings the net of a size has; ``None`` where that is not known."""
        return self.known(size) if callable(self.known) else self.known.get(size)


def philosophers(count: int) -> PetriNet:
    """Dining philosophers that take one fork after the other, in any order; two markings are dead."""
    _at_least("philosophers", count, 2)
    builder = NetBuilder(f"philosophers-{count}")
    for i in range(count):
        for place in ("think", "hungry", "left", "right", "eat", "fork"):
            builder.place(f"{place}{i}", initial=int(place in ("think", "fork")))
    for i in range(count):
        mine, next_one = f"fork{i}", f"fork{(i + 1) % count}"
        builder.transition(f"wake{i}", consume=[f"think{i}"], produce=[f"hungry{i}"])
        builder.transition(f"left{i}", consume=[f"hungry{i}", mine], produce=[f"left{i}"])
        builder.transition(f"right{i}", consume=[f"hungry{i}", next_one], produce=[f"right{i}"])
        builder.transition(f"both{i}", consume=[f"left{i}", next_one], produce=[f"eat{i}"])
        builder.transition(f"also{i}", consume=[f"right{i}", mine], produce=[f"eat{i}"])
        builder.transition(f"done{i}", consume=[f"eat{i}"], produce=[f"think{i}", mine, next_one])
    return builder.build()


def component_ring(count: int) -> PetriNet:
    """Components of 8 states in a ring, every other one with a token to hand on."""
    _at_least("component_ring", count, 2)
    builder = NetBuilder(f"ring-{count}")
    for i in range(count):
        for state in range(8):
            builder.place(f"c{i}s{state}", initial=int(state == 4 * (i % 2)))
    for i in range(count):
        for state in range(8):
            after = state + 1 if state % 4 < 3 else state - 3
            builder.transition(f"c{i}t{state}", consume=[f"c{i}s{state}"], produce=[f"c{i}s{after}"])
        j = (i + 1) % count
        builder.transition(f"hand{i}", consume=[f"c{i}s4", f"c{j}s0"], produce=[f"c{i}s0", f"c{j}s4"])
    return builder.build()


def slotted_ring(count: int) -> PetriNet:
    """The slotted ring of Pastor, Roig, Cortadella and Badia (ICATPN 1994): 8 places a node.

    Their net has ten; the two that hold an acknowledgement on its way are left out here, as in the form that
    papers on saturation count. A node passes the slot on free, or fills it, or takes note of its use.
    """
    _at_least("slotted_ring", count, 1)
    builder = NetBuilder(f"slotted-ring-{count}")
    for i in range(count):
        for place in "ABCDEFGH":
            builder.place(f"n{i}{place}", initial=int(place in "BD"))
    for i in range(count):
        here, before, after = f"n{i}", f"n{(i - 1) % count}", f"n{(i + 1) % count}"
        for name, consume, produce in (
            ("give", [f"{here}A", f"{here}C"], [f"{here}B", f"{before}D"]),
            ("free", [f"{here}B", f"{here}D"], [f"{here}C", f"{after}F"]),
            ("other", [f"{here}E"], [f"{here}G"]),
            ("owner", [f"{here}E"], [f"{here}F"]),
            ("go", [f"{here}F"], [f"{here}A"]),
            ("write", [f"{here}F"], [f"{here}G"]),
            ("put", [f"{here}C", f"{here}G"], [f"{here}H", f"{before}D"]),
            ("used", [f"{here}D", f"{here}H"], [f"{here}C", f"{after}E"]),
        ):
            builder.transition(f"{name}{i}", consume=consume, produce=produce)
    return builder.build()


def kanban(cards: int) -> PetriNet:
    """Four cells with so many cards each; a part enters the second and the third together."""
    _at_least("kanban", cards, 1)
    builder = NetBuilder(f"kanban-{cards}")
    for cell in range(1, 5):
        for part in ("machine", "rework", "out"):
            builder.place(f"{part}{cell}")
        builder.place(f"card{cell}", initial=cards)
        builder.transition(f"bad{cell}", consume=[f"machine{cell}"], produce=[f"rework{cell}"])
        builder.transition(f"good{cell}", consume=[f"machine{cell}"], produce=[f"out{cell}"])
        builder.transition(f"again{cell}", consume=[f"rework{cell}"], produce=[f"machine{cell}"])
    for name, consume, produce in (
        ("enter", ["card1"], ["machine1"]),
        ("part", ["out1", "card2", "card3"], ["card1", "machine2", "machine3"]),
        ("join", ["out2", "out3", "card4"], ["card2", "card3", "machine4"]),
        ("leave", ["out4"], ["card4"]),
    ):
        builder.transition(name, consume=consume, produce=produce)
    return builder.build()


def fms(parts: int) -> PetriNet:
    """A flexible manufacturing system: three kinds of parts, three kinds of machines, two kinds joined."""
    _at_least("fms", parts, 1)
    builder = NetBuilder(f"fms-{parts}")
    for machine, count in ((1, 3), (2, 1), (3, 2)):
        builder.place(f"machine{machine}", initial=count)
    for kind in (1, 2, 3):
        builder.place(f"raw{kind}", initial=parts)
        builder.place(f"shipped{kind}")
    for kind in (1, 2):  # worked on by the machine of that number, then shipped alone or with the other
        for place in ("waiting", "worked", "done", "joining"):
            builder.place(f"{place}{kind}")
        for name, takes, puts in (
            ("fetch", ["raw"], ["waiting"]),
            ("start", ["waiting", "machine"], ["worked"]),
            ("end", ["worked"], ["done", "machine"]),
            ("alone", ["done"], ["shipped"]),
            ("joined", ["done"], ["joining"]),
            ("ship", ["shipped"], ["raw"]),
        ):
            consume, produce = ([f"{place}{kind}" for place in side] for side in (takes, puts))
            builder.transition(f"{name}{kind}", consume=consume, produce=produce)
    for place in ("pair", "queue", "work", "ready"):
        builder.place(place)
    for name, consume, produce in (
        ("join", ["joining1", "joining2"], ["pair"]),
        ("fetch12", ["pair"], ["queue"]),
        ("start12", ["queue", "machine3"], ["work"]),
        ("end12", ["work"], ["ready", "machine3"]),
        ("ship12", ["ready"], ["raw1", "raw2"]),
        ("fetch3", ["raw3"], ["waiting3"]),
        ("ship3", ["shipped3"], ["raw3"]),
    ):
        builder.transition(name, consume=consume, produce=produce)
    builder.place("waiting3")
    # The second machine need not be kept for the third kind, but must be free.
    builder.transition("work3", consume=["waiting3"], produce=["shipped3"], read=["machine2"])
    return builder.build()


def token_ring(tokens: int) -> PetriNet:
    """As many places as tokens, all of them in the first; each goes round."""
    _at_least("token_ring", tokens, 1)
    builder = NetBuilder(f"token-ring-{tokens}")
    for place in range(tokens):
        builder.place(f"p{place}", initial=0 if place else tokens)
        builder.transition(f"t{place}", consume=[f"p{place}"], produce=[f"p{(place + 1) % tokens}"])
    return builder.build()


def eratosthenes(most: int) -> PetriNet:
    """The sieve: a number from 2 on that has a divisor among those that are left goes; primes stay."""
    _at_least("eratosthenes", most, 2)
    builder = NetBuilder(f"eratosthenes-{most}")
    for number in range(2, most + 1):
        builder.place(f"p{number}", initial=1)
    for divisor in range(2, most + 1):
        for number in range(2 * divisor, most + 1, divisor):
            builder.transition(f"t{number}.{divisor}", consume=[f"p{number}"], read=[f"p{divisor}"])
    return builder.build()


def queens(size: int) -> PetriNet:
    """Queens that are put on a board, one after the other, so that none attacks another."""
    _at_least("queens", size, 1)
    builder = NetBuilder(f"queens-{size}")
    for line in range(size):
        builder.place(f"row{line}", initial=1)
        builder.place(f"column{line}", initial=1)
    for line in range(2 * size - 1):
        builder.place(f"falling{line}", initial=1)
        builder.place(f"rising{line}", initial=1)
    for row in range(size):
        for column in range(size):
            lines = [f"row{row}", f"column{column}", f"falling{row - column + size - 1}"]
            lines.append(f"rising{row + column}")
            queen = builder.place(f"queen{row}.{column}")
            builder.transition(f"put{row}.{column}", consume=lines, produce=[queen])
    return builder.build()


def _at_least(family: str, size: int, least: int) -> None:
    if size < least:
        raise ValueError(f"{family}: found the size {size}, expected {least} or more")


def lucas(number: int) -> int:
    """The Lucas numbers: 2, 1, 3, 4, 7, ..., each the sum of the two before it."""
    one, next_one = 2, 1
    for _ in range(number):
        one, next_one = next_one, one + next_one
    return one


def _slotted_ring_markings(nodes: int) -> int:
    return sum(comb(nodes, k) ** 2 * 4**k * 2 ** (nodes - k) for k in range(nodes + 1))


def _fms_markings(parts: int) -> int:
    def shared(tokens: int, places: int, busy: int) -> int:
        """Ways to put tokens in some places, of which so many at most may be on machines besides."""
        return sum(comb(tokens - b + places - 1, places - 1) for b in range(min(tokens, busy) + 1))

    return comb(parts + 2, 2) * sum(
        shared(joined, 3, 2) * shared(parts - joined, 5, 3) * shared(parts - joined, 5, 1)
        for joined in range(parts + 1)
    )


def _composites(most: int) -> int:
    return sum(any(number % divisor == 0 for divisor in range(2, number)) for number in range(2, most + 1))


FAMILIES: Mapping[str, NetFamily] = {
    "philosophers": NetFamily(
        philosophers,
        lambda n: lucas(3 * n),
        "the trace of the n-th power of a matrix over the states of a fork (free, in the left hand, in the"
        " right one; who has no fork thinks or is hungry), whose eigenvalues are 2 + sqrt 5, 2 - sqrt 5, 0",
        least=2,
    ),
    "component_ring": NetFamily(
        component_ring,
        lambda n: comb(n, n // 2) * 4**n,
        "who has the tokens, and which of its four states each component is in",
        least=2,
    ),
    "slotted_ring": NetFamily(
        slotted_ring,
        _slotted_ring_markings,
        "invariants: one token in B, C, H of each node, one in D of each and A, E, F, G of the next; in k of"
        " the former C is marked and in k of the latter D is not, which may be any k; 53,856 for 5",
    ),
    "kanban": NetFamily(
        kanban,
        lambda n: comb(n + 3, 3) ** 2 * sum(comb(k + 2, 2) ** 2 for k in range(n + 1)),
        "n cards on four places in the first and the last cell; as many cards free in the second cell as in"
        " the third; 2,546,432 for 5 in the Model Checking Contest (Kanban-PT-00005)",
        safe=False,
    ),
    "fms": NetFamily(
        fms,
        _fms_markings,
        "how many parts are joined, then where the others are, no more at machines than these; 120, 3,444,"
        " 48,590, 438,600, 2,895,018 for 1 to 5: Ciardo and Tilgner 1996, the Model Checking Contest",
        safe=False,
    ),
    "token_ring": NetFamily(
        token_ring, lambda n: comb(2 * n - 1, n - 1), "ways to share n tokens among n places", safe=False
    ),
    "eratosthenes": NetFamily(
        eratosthenes,
        lambda n: 2 ** _composites(n),
        "each composite number is there or gone, for its prime divisors stay; 32 for 10 in the Model"
        " Checking Contest (Eratosthenes-PT-010)",
        least=2,
    ),
    "queens": NetFamily(
        queens,
        {1: 2, 2: 5, 3: 18, 4: 87, 5: 462, 8: 118_969},
        "sets of queens of which none attacks another, counted on boards; 462 and 118,969 for 5 and 8 in the"
        " Model Checking Contest (NQueens-PT-05, NQueens-PT-08)",
    ),
}
"""The families by name."""
