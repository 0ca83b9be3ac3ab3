"""Nets and missions that grow: N dining philosophers, a ring of N 8-state components, N missions in a row.

Usage: ``python experiments/families.py [-o FOLDER]``

Prints, for each size, the markings that the symbolic engine counts, whether the closed form agrees where
there is one, its seconds, and the nodes of the diagram at its peak and at its end. It takes some 20 seconds.
With ``-o`` the numbers go to ``families.csv`` and a plot (needs ``mcpn[experiments]``) to ``families.svg`` in
that folder.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from dataclasses import replace
from math import comb
from pathlib import Path
from typing import Any

import plots

import mcpn
from mcpn.mission.model import Mission, Use
from mcpn.mission.xml import read_mission
from mcpn.net.compose import compose
from mcpn.net.petri import NetBuilder, PetriNet
from mcpn.report.pictures.plots import Curves
from mcpn.space.diagrams.symbolic import reach

ULYSSE = Path(__file__).parent / "ulysse" / "mission.xml"


def philosophers(count: int) -> PetriNet:
    """Dining philosophers that take one fork after the other; forks are places: 6 places each."""
    builder = NetBuilder(f"philosophers-{count}")
    for i in range(count):
        for place, tokens in (
            ("think", 1),
            ("hungry", 0),
            ("left", 0),
            ("right", 0),
            ("eat", 0),
            ("fork", 1),
        ):
            builder.place(f"{place}{i}", initial=tokens)
    for i in range(count):
        mine, next_one = f"fork{i}", f"fork{(i + 1) % count}"
        builder.transition(f"wake{i}", consume=[f"think{i}"], produce=[f"hungry{i}"])
        builder.transition(f"left{i}", consume=[f"hungry{i}", mine], produce=[f"left{i}"])
        builder.transition(f"right{i}", consume=[f"hungry{i}", next_one], produce=[f"right{i}"])
        builder.transition(f"both{i}", consume=[f"left{i}", next_one], produce=[f"eat{i}"])
        builder.transition(f"also{i}", consume=[f"right{i}", mine], produce=[f"eat{i}"])
        builder.transition(f"done{i}", consume=[f"eat{i}"], produce=[f"think{i}", mine, next_one])
    return builder.build()


def ring(count: int) -> PetriNet:
    """Components of 8 states in a ring, every other one with a token to hand on: C(N, N/2) * 4^N markings."""
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


def ulysses(count: int) -> Mission:
    """So many Ulysse missions in a row, on the same robot; whatever happens in one, the next begins."""
    mission = read_mission(ULYSSE)
    first, second = mission.blocks
    blocks: list[Use] = []
    for i in range(count):
        assert isinstance(first, Use)
        assert isinstance(second, Use)
        following = f"head{i + 1}" if i + 1 < count else None
        blocks.append(replace(first, name=f"head{i}", failure=f"transect{i}"))
        blocks.append(replace(second, name=f"transect{i}", failure=following))
    return replace(mission, name=f"ulysse-{count}", blocks=tuple(blocks))


def save(lines: list[dict[str, Any]], folder: Path) -> None:
    """Writes the CSV, and the plot: seconds and nodes at the peak against places."""
    families = dict.fromkeys(line["family"] for line in lines)
    curves = [
        Curves(
            told,
            "places",
            told,
            {f: [(line["places"], line[column]) for line in lines if line["family"] == f] for f in families},
        )
        for told, column in (("seconds of CPU", "seconds"), ("nodes at the peak", "peak_nodes"))
    ]
    plots.save(folder, "families", lines, curves)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    arguments = plots.parsed(parser, "families")
    sys.set_int_max_str_digits(0)
    print(f"{'net':22}{'places':>8}{'markings':>28}{'right':>7}{'seconds':>9}{'peak':>9}{'nodes':>8}")
    lines: list[dict[str, Any]] = []
    nets: list[tuple[PetriNet, int | None]] = []
    nets += [(philosophers(n), None) for n in (20, 100, 500)]
    nets += [(ring(n), comb(n, n // 2) * 4**n) for n in (16, 32, 64)]
    nets += [(slotted_ring(n), None) for n in (5, 10, 20)]
    nets += [(compose(ulysses(n)).net, None) for n in (1, 10, 100)]
    for net, expected in nets:
        started = time.process_time()
        space = reach(net)
        states, seconds = space.states, time.process_time() - started
        shown = (
            str(states) if states < 10**20 else f"{str(states)[0]}.{str(states)[1:4]}e{len(str(states)) - 1}"
        )
        right = "" if expected is None else "yes" if states == expected else "NO"
        row = f"{net.name:22}{len(net.places):8}{shown:>28}{right:>7}{seconds:9.2f}"
        nodes = space.reachable.nodes()
        print(f"{row}{space.peak_nodes:9}{nodes:8}", flush=True)
        sizes = {"places": len(net.places), "markings": states}
        family, _, number = net.name.rpartition("-")
        took = {"seconds": seconds, "peak_nodes": space.peak_nodes, "nodes": nodes}
        lines.append({"family": family, "n": int(number), **sizes, **took})
    if arguments.output:
        save(lines, arguments.output)
    versions = f"mcpn {mcpn.__version__}, Python {platform.python_version()}"
    print(f"seconds of CPU, orders raced; {versions}, {platform.system()} {platform.machine()}")


if __name__ == "__main__":
    main()
