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
from pathlib import Path
from typing import Any

import plots

import mcpn
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Use
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from mcpn.report.pictures.plots import Curves
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.testing.nets import FAMILIES

ULYSSE = Path(__file__).parent / "ulysse" / "mission.xml"
SIZES = {"philosophers": (20, 100, 500), "component_ring": (16, 32, 64), "slotted_ring": (5, 10, 20)}
"""By family of :mod:`mcpn.testing.nets`, the sizes that are measured."""


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
    return replace(mission, name=f"ulysse_{count}", blocks=tuple(blocks))


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
    nets: list[tuple[str, int, PetriNet, int | None]] = []
    for name, members in SIZES.items():
        nets += [(name, n, FAMILIES[name].net(n), FAMILIES[name].markings(n)) for n in members]
    nets += [("ulysse", n, compose(ulysses(n)).net, None) for n in (1, 10, 100)]
    for family, number, net, expected in nets:
        started = time.process_time()
        space = reach(net)
        states, seconds = space.states, time.process_time() - started
        shown = (
            str(states) if states < 10**20 else f"{str(states)[0]}.{str(states)[1:4]}e{len(str(states)) - 1}"
        )
        right = "" if expected is None else "yes" if states == expected else "NO"
        row = f"{f'{family} {number}':22}{len(net.places):8}{shown:>28}{right:>7}{seconds:9.2f}"
        nodes = space.reachable.nodes()
        print(f"{row}{space.peak_nodes:9}{nodes:8}", flush=True)
        sizes = {"places": len(net.places), "markings": states}
        took = {"seconds": seconds, "peak_nodes": space.peak_nodes, "nodes": nodes}
        lines.append({"family": family, "n": number, **sizes, **took})
    if arguments.output:
        save(lines, arguments.output)
    versions = f"mcpn {mcpn.__version__}, Python {platform.python_version()}"
    print(f"seconds of CPU, orders raced; {versions}, {platform.system()} {platform.machine()}")


if __name__ == "__main__":
    main()
