"""Ulysse with a parallel block of branches on disjoint resources: what interleaving costs each way.

Usage: ``python experiments/five_branches.py [--branches 5] [-o FOLDER]``

After Ulysse's own blocks comes a parallel one, each child with a sensor of its own that may fail. The
markings graph holds every interleaving of their internal steps; the direct way, with its proof on diagrams,
does not. The reduction is left out where there are more markings than ``--most`` (five branches have
253,598,916). With its defaults it takes two seconds.

With ``-o`` blocks of fewer branches are measured first; the numbers go to ``five_branches.csv`` and a plot
(needs ``mcpn[experiments]``) to ``five_branches.svg`` in that folder. That takes a minute or two.
"""

from __future__ import annotations

import argparse
import platform
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import plots

from mcpn import __version__
from mcpn.drawing.compose import compose
from mcpn.mission.model import Block, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.xml import read_mission
from mcpn.report.pictures.plots import Curves
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import by_reduction, direct_with_proof

ULYSSE = Path(__file__).parent / "ulysse" / "mission.xml"


def with_branches(mission: Mission, count: int) -> Mission:
    """The mission with a block of so many branches after its own blocks, each on resources of its own."""
    hardware = tuple(Hardware(name=f"extra_sensor{i}") for i in range(count))
    software = tuple(Software(name=f"extra_data{i}") for i in range(count))
    activities: list[Activity] = []
    branches: list[Block] = []
    for i in range(count):
        read = Alternative(name=f"extra_read{i}", consumes=(f"extra_sensor{i}",))
        use = Alternative(name=f"extra_use{i}", consumes=(f"extra_data{i}",))
        activities.append(Activity(name=f"extra_read{i}", alternatives=(read,), produces=(f"extra_data{i}",)))
        activities.append(Activity(name=f"extra_use{i}", alternatives=(use,)))
        branches.append(Objective(name=f"extra{i}", activities=(f"extra_use{i}",)))
    robot = Robot(name="extra", hardware=hardware, software=software, activities=tuple(activities))
    block = Parallel(name="extra_block", blocks=tuple(branches))
    own = Recursive(name="own", blocks=mission.blocks)
    return replace(
        mission, name=f"ulysse_{count}_branches", blocks=(own, block), robots=(*mission.robots, robot)
    )


def measure(branches: int, most: int) -> dict[str, Any]:
    """Both ways in one run, from the net to the same alternatives graph; printed, and as a row."""
    net = compose(with_branches(read_mission(ULYSSE), branches)).net
    started = time.process_time()
    direct = direct_with_proof(net)
    direct_seconds = time.process_time() - started
    print(f"{net.name}: {len(net.places)} places, {direct.states} stable states, {direct.edges} edges")
    print(f"directly, proof included: {direct_seconds:.2f} s ({direct.proof})", flush=True)
    markings = reach(net).states
    print(f"markings: {markings}", flush=True)
    line = {"branches": branches, "markings": markings, "stable": direct.states, "directly": direct_seconds}
    if markings > most:
        print(f"by reduction: left out, more than {most} markings")
        return line
    started = time.process_time()
    reduced = by_reduction(explore(net))
    seconds = time.process_time() - started
    assert (reduced.states, reduced.edges) == (direct.states, direct.edges)
    print(
        f"by reduction of the markings graph: {seconds:.2f} s, {seconds / direct_seconds:.1f} times as long"
    )
    return line | {"by reduction": seconds}


def save(lines: list[dict[str, Any]], folder: Path) -> None:
    """Writes the CSV, and the plot: seconds against branches."""
    ways = ("directly", "by reduction")
    points = {way: [(line["branches"], line[way]) for line in lines if way in line] for way in ways}
    curves = Curves("the alternatives graph", "branches side by side", "seconds of CPU", points)
    plots.save(folder, "five_branches", lines, [curves])


def main() -> None:
    """One block, or with ``-o`` a block of each number of branches up to it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--branches", type=int, default=5)
    parser.add_argument("--most", type=int, default=20_000_000)
    arguments = plots.parsed(parser, "five_branches")
    first = 1 if arguments.output else arguments.branches
    lines = [measure(number, arguments.most) for number in range(first, arguments.branches + 1)]
    if arguments.output:
        save(lines, arguments.output)
    print(f"seconds of CPU; mcpn {__version__}, Python {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
