"""Nets with several tokens in a place, marking by marking and as a diagram: counts and processor seconds.

Usage: ``python experiments/tokens.py [--most-states N] [--seconds S]``

*Kanban* and *FMS* are the systems of G. Ciardo and M. Tilgner (ICASE report 96-35, 1996), with N cards in each
cell and N parts of each kind; their counts are those that papers on saturation give. *Ring*: N tokens go round
N places, C(2N - 1, N - 1) markings. Counts that differ from these, or between engines, end the script. Each
run has a process of its own; the explicit engine is asked up to a number of markings. It takes about a
minute.
"""

from __future__ import annotations

from math import comb

from limits import Result

from mcpn.net.petri import NetBuilder, PetriNet
from mcpn.space.summary import summarise

ENGINES = ("symbolic", "explicit")


def kanban(cards: int) -> PetriNet:
    """Four cells with so many cards each; a part enters the second and the third together."""
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
    builder = NetBuilder(f"fms-{parts}")
    for machine, count in ((1, 3), (2, 1), (3, 2)):
        builder.place(f"machine{machine}", initial=count)
    for kind in (1, 2, 3):
        builder.place(f"raw{kind}", initial=parts)
        builder.place(f"shipped{kind}")
    for kind in (
        1,
        2,
    ):  # worked on by the machine of that number, then shipped alone or joined with the other
        for place in ("waiting", "worked", "done", "joining"):
            builder.place(f"{place}{kind}")
        for name, consume, produce in (
            ("fetch", ["raw"], ["waiting"]),
            ("start", ["waiting", "machine"], ["worked"]),
            ("end", ["worked"], ["done", "machine"]),
            ("alone", ["done"], ["shipped"]),
            ("joined", ["done"], ["joining"]),
            ("ship", ["shipped"], ["raw"]),
        ):
            builder.transition(
                f"{name}{kind}",
                consume=[p + str(kind) for p in consume],
                produce=[p + str(kind) for p in produce],
            )
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


def ring(tokens: int) -> PetriNet:
    """As many places as tokens, all of them in the first."""
    builder = NetBuilder(f"ring-{tokens}")
    for place in range(tokens):
        builder.place(f"p{place}", initial=0 if place else tokens)
        builder.transition(f"t{place}", consume=[f"p{place}"], produce=[f"p{(place + 1) % tokens}"])
    return builder.build()


FAMILIES = {"kanban": kanban, "fms": fms, "ring": ring}
COUNTS = {
    "kanban": {1: 160, 2: 4_600, 3: 58_400, 4: 454_475, 5: 2_546_432, 6: 11_261_376, 10: 1_005_927_208},
    "fms": {2: 3_444, 3: 48_590, 4: 438_600, 5: 2_895_018},
    "ring": {n: comb(2 * n - 1, n - 1) for n in (2, 5, 8, 10, 11, 12, 20, 50)},
}
"""Markings, as published or by the closed form."""
SIZES = {
    "kanban": (3, 4, 5, 6, 10, 20, 50, 100, 200),
    "fms": (3, 4, 5, 6, 10, 20, 50, 100),
    "ring": (8, 10, 11, 12, 20, 50),
}


def find(engine: str, family: str, number: int) -> Result:
    """The counts of one net by one engine."""
    found = summarise(FAMILIES[family](number), engine)
    return {
        "markings": found.states,
        "edges": found.edges,
        "tokens": found.max_tokens,
        "in_place": found.max_tokens_in_place,
    }
