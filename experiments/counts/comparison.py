"""Every engine on worked missions and on families of nets: one table, and a plot of each family.

Run: python experiments/counts/comparison.py [--seconds S] [--repeat N] [--format FORM] [-o FOLDER]
(some three minutes; pyeda takes most of it, a minute for the courier alone)

The missions are those of the folder above; the families are nets of :mod:`mcpn.testing.nets` and the missions
with branches of ``explicit_vs_symbolic.py``, three sizes of each.
An engine that does not end within S seconds of wall time says so in its row. With a folder, a plot of each
family is written there. The measurements are those of ``mcpn compare``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

import click

from experiments.counts.explicit_vs_symbolic import branches
from mcpn.answers.compare import Measured, Runs, disagreement, measure
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from mcpn.report.comparison import print_comparison, table
from mcpn.report.pictures.plots import save_engines
from mcpn.testing.nets import FAMILIES

MISSIONS = ("ulysse", "courier", "drone", "glider", "rover")
SIZES = {
    "philosophers": (4, 6, 8),
    "component_ring": (3, 4, 5),
    "slotted_ring": (2, 3, 4),
    "eratosthenes": (10, 20, 30),
    "queens": (3, 4, 5),
    "branches": (2, 3, 4),
    "kanban": (1, 2, 3),
}
"""Sizes of families; pyeda counts all of them but kanban from 2 on, whose places hold several tokens."""


def subjects() -> Iterator[tuple[str, list[tuple[int | None, Mission | PetriNet]]]]:
    """The missions one by one, then each family with its sizes."""
    here = Path(__file__).parents[1]
    for name in MISSIONS:
        yield name, [(None, read_mission(here / name / "mission.xml"))]
    for name, sizes in SIZES.items():
        made = branches if name == "branches" else FAMILIES[name].net
        yield name, [(size, made(size)) for size in sizes]


def measured(
    seconds: float, repeats: int, wanted: Callable[[str], bool] = lambda _: True
) -> Iterator[tuple[str, list[Measured]]]:
    """What is measured, by name: the missions one by one, then each family.

    Args:
        seconds: Limit of each run.
        repeats: Runs of each engine.
        wanted: Says of the name of a mission or a family whether it is measured.
    """
    for name, members in subjects():
        if wanted(name):
            found = [measure(of, Runs(seconds=seconds, repeats=repeats), size=size) for size, of in members]
            assert not any(disagreement(member.engines) for member in found), "engines count the same"
            yield name, found


HEADS = (
    *("net", "engine", "places", "transitions", "markings", "edges", "stable", "dead", "nodes", "peak nodes"),
    *("order", "CPU s", "MB"),
)


def rows(
    seconds: float, repeats: int, wanted: Callable[[str], bool] = lambda _: True
) -> Iterator[tuple[object, ...]]:
    """A row for each net and engine; what an engine does not count is a dash, as is all where it gives up."""
    counted = ("states", "edges", "stable_states", "dead_states", "nodes", "peak_nodes")
    for name, members in measured(seconds, repeats, wanted):
        for member in members:
            net = name if member.size is None else f"{name} {member.size}"
            for m in member.engines:
                sizes = m.sizes or {}
                counts = (sizes.get(key) for key in counted)
                told = ("-" if count is None else count for count in counts)
                took = (f"{m.cpu_seconds:.3f}", m.megabytes) if m.sizes else ("-", "-")
                yield (net, m.engine, member.places, member.transitions, *told, m.order or "-", *took)


def main() -> None:
    """Prints the table."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--seconds", type=float, default=300, help="limit of each run (default 300)")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each engine (default 1)")
    parser.add_argument("--format", choices=["text", "csv", "latex"], default="text", dest="form")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="where plots are written")
    asked = parser.parse_args()
    found = dict(measured(asked.seconds, asked.repeat))
    if asked.output is not None:
        asked.output.mkdir(parents=True, exist_ok=True)
        for name in SIZES:
            save_engines(asked.output / f"{name}.svg", found[name])
    if asked.form != "text":
        click.echo(table([member for members in found.values() for member in members], asked.form), nl=False)
        return
    for members in found.values():
        click.echo(f"{members[0].name}: {members[0].places} places, {members[0].transitions} transitions")
        print_comparison(members)


if __name__ == "__main__":
    main()
