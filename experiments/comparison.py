"""Every engine on worked missions and on families of nets: one table, and a plot of each family.

Run: python experiments/comparison.py [--seconds S] [--repeat N] [--format FORM] [-o FOLDER]
(some three minutes; pyeda takes most of it, a minute for the courier alone)

The missions are those beside the scripts; the families are of :mod:`mcpn.testing.nets`, three sizes of each.
An engine that does not end within S seconds of wall time says so in its row. With a folder, a plot of each
family is written there. The measurements are those of ``mcpn compare``.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import click

from mcpn.answers.compare import Measured, disagreement, grown, measure
from mcpn.mission.xml import read_mission
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
    "kanban": (1, 2, 3),
}
"""Sizes of families; pyeda counts the nets of all of them but kanban, whose places hold several tokens."""


def measured(seconds: float, repeats: int) -> list[list[Measured]]:
    """What is measured: the missions together, then each family."""
    here = Path(__file__).parent
    missions = [
        measure(read_mission(here / name / "mission.xml"), seconds=seconds, repeats=repeats)
        for name in MISSIONS
    ]
    families = [
        list(
            grown(
                ((size, FAMILIES[name].net(size)) for size in sizes),
                max_states=None,
                seconds=seconds,
                repeats=repeats,
            )
        )
        for name, sizes in SIZES.items()
    ]
    return [missions, *families]


def main() -> None:
    """Prints the table."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--seconds", type=float, default=300, help="limit of each run (default 300)")
    parser.add_argument("--repeat", type=int, default=1, help="runs of each engine (default 1)")
    parser.add_argument("--format", choices=["text", "csv", "latex"], default="text", dest="form")
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help="where plots are written")
    asked = parser.parse_args()
    missions, *families = measured(asked.seconds, asked.repeat)
    every = [member for members in (missions, *families) for member in members]
    assert not any(disagreement(member.engines) for member in every), "engines count the same"
    if asked.output is not None:
        asked.output.mkdir(parents=True, exist_ok=True)
        for name, members in zip(SIZES, families, strict=True):
            save_engines(asked.output / f"{name}.svg", members)
    if asked.form != "text":
        click.echo(table(every, asked.form), nl=False)
        return
    for members in (*([mission] for mission in missions), *families):
        click.echo(f"{members[0].name}: {members[0].places} places, {members[0].transitions} transitions")
        print_comparison(members)


if __name__ == "__main__":
    main()
