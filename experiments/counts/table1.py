"""The paper's Table 1 beside ours: net, markings graph and alternatives graph of the Ulysse mission.

Run: python experiments/counts/table1.py [--repeat N]

Times are medians of N runs in CPU seconds, side by side in this process; the paper's are its own, of 2017.
It takes seconds.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import networkx
import numpy
from rich.console import Console
from rich.table import Table

import mcpn
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import by_reduction, direct

MISSION = Path(__file__).parents[1] / "ulysse" / "mission.xml"
T = TypeVar("T")

WHY = """\
The figures of the paper's templates are lost: ours were rebuilt from its sentences and give its net size
exactly, but the sentences do not fix every arc, so its program explored another net than ours.
The counts are therefore shown side by side as they are; nothing here was tuned to the paper's."""


def counts() -> list[tuple[str, str, str]]:
    """What is counted, the paper's number and ours: the same on every machine."""
    net = compose(read_mission(MISSION)).net
    markings = explore(net)
    alternatives = by_reduction(markings)
    return [
        ("places", "133", f"{len(net.places)}"),
        ("transitions", "150", f"{len(net.transitions)}"),
        ("markings", "819111", f"{markings.states}"),
        ("edges between them", "1907422", f"{markings.edges}"),
        ("stable markings", "765", f"{alternatives.states}"),
        ("event edges between them", "3602", f"{alternatives.edges}"),
    ]


def seconds(repeat: int) -> list[tuple[str, str, str]]:
    """What is timed, the paper's seconds and ours: medians of CPU time."""
    found, generation = timed(repeat, lambda: compose(read_mission(MISSION)))
    markings, exploring = timed(repeat, lambda: explore(found.net))
    _, reducing = timed(repeat, lambda: by_reduction(markings))
    _, proved = timed(repeat, lambda: direct(found.net))
    return [
        ("Petri net", "0.24", f"{generation:.3f}"),
        ("markings graph", "116", f"{exploring:.3f}"),
        ("alternatives graph by reduction of it", "191", f"{reducing:.3f}"),
        ("alternatives graph directly, with its proof", "", f"{proved:.3f}"),
    ]


def timed(repeat: int, action: Callable[[], T]) -> tuple[T, float]:
    """What an action returns, with the median of its CPU seconds."""
    seconds = []
    for _ in range(repeat):
        started = time.process_time()
        result = action()
        seconds.append(time.process_time() - started)
    return result, statistics.median(seconds)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, default=5, help="runs of each measurement")
    repeat = parser.parse_args().repeat

    found, generation = timed(repeat, lambda: compose(read_mission(MISSION)))
    markings, exploring = timed(repeat, lambda: explore(found.net))
    reduced, reducing = timed(repeat, lambda: by_reduction(markings))
    bare, unproved = timed(repeat, lambda: direct(found.net, proof=False))
    proved, with_proof = timed(repeat, lambda: direct(found.net, proof=True))
    for graph in (bare, proved):
        same = all(
            numpy.array_equal(getattr(graph, part), getattr(reduced, part))
            for part in ("markings", "offsets", "targets", "labels")
        )
        assert same, "the ways to the alternatives graph disagree"

    console = Console()
    table = Table("", "paper", "mcpn", title="Table 1: Ulysse mission", title_justify="left")
    for label, paper, ours in (
        ("Petri net: generation", "0.24 s", f"{generation:.3f} s"),
        ("places", "133", f"{len(found.net.places)}"),
        ("transitions", "150", f"{len(found.net.transitions)}"),
        ("markings graph: generation", "116 s", f"{exploring:.3f} s"),
        ("states", "819111", f"{markings.states}"),
        ("edges", "1907422", f"{markings.edges}"),
        ("alternatives graph: generation", "191 s", f"{reducing:.3f} s"),
        ("states", "765", f"{reduced.states}"),
        ("edges", "3602", f"{reduced.edges}"),
    ):
        table.add_row(label, paper, ours)
    console.print(table)

    reduction = exploring + reducing
    ways = Table("way to the same alternatives graph", "seconds", "against reduction", title_justify="left")
    for label, seconds in (
        ("by reduction: markings graph, then its stable markings", reduction),
        ("directly, without proof", unproved),
        ("directly, with its proof", with_proof),
    ):
        ways.add_row(label, f"{seconds:.4f}", f"{reduction / seconds:.1f} x")
    ways.add_row("the proof alone", f"{with_proof - unproved:.4f}", "")
    console.print(ways)
    console.print(WHY, highlight=False, soft_wrap=True)
    versions = f"mcpn {mcpn.__version__}, Python {platform.python_version()}, numpy {numpy.__version__}"
    console.print(f"{versions}, networkx {networkx.__version__}; {platform.system()} {platform.machine()}")


if __name__ == "__main__":
    main()
