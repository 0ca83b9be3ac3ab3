"""Explicit, direct, symbolic, local and pyeda side by side: counts and cost over two families of missions.

Usage: ``python experiments/counts/explicit_vs_symbolic.py [-o FOLDER] [--most N] [--seconds S]``

*Branches*: one parallel block of N branches, each with a sensor of its own that may fail; the markings graph
holds every interleaving of their internal steps. *Row*: N objectives one after the other, each with a sensor
of its own and a spare that all share. Explicit lists the markings, symbolic counts them on a diagram; direct
lists the stable markings after a proof, local counts them type of section by type. pyeda is the small
reference. Counts that differ between engines end the script. Each run has a process of
its own; an engine that gave up is not asked for a larger mission of the family.

With ``-o`` the numbers go to ``explicit_vs_symbolic.csv`` and a plot (needs ``mcpn[experiments]``) to
``explicit_vs_symbolic.svg`` in that folder. With its defaults it takes some 20 seconds, and up to a few
minutes where engines are stopped by their limit.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.shared import plots
from experiments.shared.limits import Result, measured
from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.report.pictures.plots import Curves
from mcpn.spaces.sizes import summarise
from mcpn.spaces.stable.alternatives import direct_with_proof

ENGINES = ("explicit", "symbolic", "direct", "local", "pyeda")


def branches(number: int) -> Mission:
    """N branches side by side, each with a sensor of its own."""
    hardware = tuple(Hardware(name=f"sensor{i}") for i in range(number))
    activities = tuple(
        Activity(name=f"task{i}", alternatives=(Alternative(name=f"task{i}", consumes=(f"sensor{i}",)),))
        for i in range(number)
    )
    children = tuple(Objective(name=f"part{i}", activities=(f"task{i}",)) for i in range(number))
    block = Parallel(name="together", blocks=children) if number > 1 else children[0]
    return Mission(
        name=f"branches{number}",
        blocks=(block,),
        robots=(Robot(name="robot", hardware=hardware, activities=activities),),
    )


def row(number: int) -> Mission:
    """N objectives in a row, each with a sensor of its own and a spare that all share."""
    hardware = (*(Hardware(name=f"sensor{i}") for i in range(number)), Hardware(name="spare"))
    activities = tuple(
        Activity(
            name=f"task{i}",
            alternatives=(
                Alternative(name=f"with_sensor{i}", consumes=(f"sensor{i}",)),
                Alternative(name=f"with_spare{i}", consumes=("spare",)),
            ),
        )
        for i in range(number)
    )
    return Mission(
        name=f"row{number}",
        blocks=tuple(Objective(name=f"part{i}", activities=(f"task{i}",)) for i in range(number)),
        robots=(Robot(name="robot", hardware=hardware, activities=activities),),
    )


FAMILIES = {"branches": branches, "row": row}


def find(engine: str, family: str, number: int) -> Result:
    """The counts of one mission by one engine; what it does not count is left out."""
    mission_net = compose(FAMILIES[family](number))
    if engine == "direct":
        return {"stable": direct_with_proof(mission_net.net).states}
    if engine == "local":
        return {"stable": composite_space(mission_net).everything.count()}
    found = summarise(mission_net.net, engine)
    counts = {"markings": found.states, "stable": found.stable_states, "nodes": found.nodes}
    return {name: value for name, value in counts.items() if value is not None}


def measure(
    most: int,
    seconds: float,
    engines: Sequence[str] = ENGINES,
    wanted: Callable[[str], bool] = lambda _: True,
) -> Iterator[dict[str, Any]]:
    """A row for each mission: its sizes, and the CPU seconds of each engine that does not give up.

    Args:
        most: The largest size of each family.
        seconds: Limit of each run.
        engines: Those that are asked.
        wanted: Says of a family and a size whether the mission is measured.
    """
    for family, make in FAMILIES.items():
        gone: set[str] = set()
        for number in range(1, most + 1):
            if not wanted(f"{family} {number}"):
                continue
            net = compose(make(number)).net
            line: dict[str, Any] = {"family": family, "n": number, "places": len(net.places)}
            counts: dict[str, set[int]] = {"markings": set(), "stable": set()}
            for engine in engines:
                if engine in gone:
                    continue
                found = measured(find, engine, family, number, seconds=seconds)
                if "gave_up" in found:
                    gone.add(engine)
                    continue
                line[engine] = found["seconds"]
                if engine == "symbolic":
                    line["nodes"] = found["nodes"]
                for name, values in counts.items():
                    values |= {found[name]} if name in found else set()
            assert all(len(values) <= 1 for values in counts.values()), (
                f"the engines disagree: {line}, {counts}"
            )
            yield line | {name: values.pop() for name, values in counts.items() if values}


COLUMNS = ("family", "n", "places", "markings", "stable", "nodes", *ENGINES)


def table(lines: list[dict[str, Any]]) -> str:
    """The rows as a Markdown table; seconds with two digits, ``-`` where an engine gave up."""

    def cell(value: object) -> str:
        return "-" if value is None else f"{value:.2f}" if isinstance(value, float) else f"{value}"

    heads = [*COLUMNS[:6], *(f"{engine}, CPU s" for engine in ENGINES)]
    rows = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    rows += ["| " + " | ".join(cell(line.get(column)) for column in COLUMNS) + " |" for line in lines]
    return "\n".join(rows)


def save(lines: list[dict[str, Any]], folder: Path) -> None:
    """Writes the CSV, and the plot: seconds against the number of branches or objectives."""
    curves = [
        Curves(
            family,
            f"N ({family})",
            "CPU seconds",
            {
                engine: [
                    (line["n"], line[engine]) for line in lines if line["family"] == family and engine in line
                ]
                for engine in ENGINES
            },
        )
        for family in FAMILIES
    ]
    plots.save(folder, "explicit_vs_symbolic", lines, curves)


def main() -> None:
    """Prints the table, and writes the files where they are wanted."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--most", type=int, default=8, help="the largest N of each family (default 8)")
    parser.add_argument("--seconds", type=float, default=15, help="limit of each run (default 15)")
    arguments = plots.parsed(parser, "explicit_vs_symbolic")
    lines = list(measure(arguments.most, arguments.seconds))
    print(table(lines))
    if arguments.output:
        save(lines, arguments.output)


if __name__ == "__main__":
    main()
