"""Nets with several tokens in a place, marking by marking and as a diagram: counts and processor seconds.

Usage: ``python experiments/several_tokens.py [--most-states N] [--seconds S]``

*Kanban* and *FMS* are the systems of G. Ciardo and M. Tilgner (ICASE report 96-35, 1996), with N cards in
each cell and N parts of each kind; their counts are those that papers on saturation give. *Ring*: N tokens go
round N places, C(2N - 1, N - 1) markings. Counts that differ from these, or between engines, end the script.
Each run has a process of its own; the explicit engine is asked up to a number of markings. It takes about
half a minute.
"""

from __future__ import annotations

import argparse
import platform
import time
from math import comb

from limits import Result, measured

import mcpn
from mcpn.check.sizes import summarise
from mcpn.net.petri import NetBuilder, PetriNet


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
SIZES = {
    "kanban": (1, 2, 3, 4, 5, 6, 10, 20, 50, 100),
    "fms": (1, 2, 3, 4, 5, 6, 10, 20, 50),
    "ring": (5, 8, 10, 11, 12, 20, 50),
}
COUNTS = {
    "kanban": {1: 160, 2: 4_600, 3: 58_400, 4: 454_475, 5: 2_546_432, 6: 11_261_376, 10: 1_005_927_208},
    "fms": {1: 120, 2: 3_444, 3: 48_590, 4: 438_600, 5: 2_895_018},
    "ring": {n: comb(2 * n - 1, n - 1) for n in SIZES["ring"]},
}
"""Markings, as published or by the closed form."""


def find(engine: str, family: str, number: int) -> Result:
    """The counts of one net by one engine, and its seconds of the processors."""
    net = FAMILIES[family](number)
    started = time.process_time()
    found = summarise(net, engine)
    return {
        "cpu": time.process_time() - started,
        "counts": (found.states, found.edges, found.dead_states, found.max_tokens, found.max_tokens_in_place),
        "nodes": found.nodes,
    }


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--most-states", type=int, default=3_000_000, help="what the explicit engine is asked"
    )
    parser.add_argument("--seconds", type=float, default=60, help="limit of each run")
    options = parser.parse_args()
    print(f"{'net':12}{'markings':>27}{'edges':>28}{'nodes':>8}{'symbolic':>10}{'explicit':>10}  CPU seconds")
    for family, sizes in SIZES.items():
        for number in sizes:
            found = measured(find, "symbolic", family, number, seconds=options.seconds)
            if "gave_up" in found:
                print(f"{family} {number}: {found['gave_up']}", flush=True)
                continue
            states, edges, *_ = found["counts"]
            published = COUNTS[family].get(number, states)
            assert states == published, f"{family} {number} has {states} markings, not {published}"
            name, explicit = f"{family}-{number}", "-"
            if states <= options.most_states:
                listed = measured(find, "explicit", family, number, seconds=options.seconds)
                explicit = listed.get("gave_up") or f"{listed['cpu']:.2f}"
                assert listed.get("counts", found["counts"]) == found["counts"], (
                    f"{family} {number}: {listed}"
                )
            name = f"{family}-{number}"
            print(
                f"{name:12}{_short(states):>27}{_short(edges):>28}{found['nodes']:8}"
                f"{found['cpu']:10.2f}{explicit:>10}",
                flush=True,
            )
    print(f"mcpn {mcpn.__version__}, Python {platform.python_version()}, {platform.machine()}")


def _short(count: int) -> str:
    return f"{count:,}" if count < 10**18 else f"{count:.3e}"


if __name__ == "__main__":
    main()
