"""Failure causes: the tables of papers/causes.md, each cut set confirmed, and missions with redundancy.

python experiments/counts/causes.py            cut sets and FMECA of Ulysse (seconds)
python experiments/counts/causes.py --growth   seconds for missions with more and more hardware (some minutes)

With ``--growth -o FOLDER`` the numbers go to ``causes.csv`` and a plot (needs ``mcpn[experiments]``) to
``causes.svg`` in that folder.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.shared import plots
from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.mission_names import MissionNames
from mcpn.drawing.compose import MissionNet, compose
from mcpn.events import Event, What
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.syntax import parse
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.xml import read_mission
from mcpn.report.failures.fmeca_table import fmeca_rows
from mcpn.report.pictures.plots import Curves
from mcpn.sentences import enumeration
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach

ULYSSE = Path(__file__).parents[1] / "ulysse" / "mission.xml"


def ulysse() -> None:
    """Prints the cut sets of Ulysse, confirmed for every subset of its hardware, and its FMECA table."""
    found = compose(read_mission(ULYSSE))
    causes = find_causes(found, engine="explicit")
    confirm(found, causes)
    print("| fails | if |\n|---|---|")
    for goal in (causes.mission, *causes.objectives.values()):
        told = ", or ".join(enumeration(names) for names in goal.cut_sets) or "never by hardware"
        print(f"| {goal.name} | {told} |")
    shown = ("local_effect", "mission_effect", "compensation", "recovery", "severity", "with_others")
    print(f"\n| hardware | objective | {' | '.join(shown)} |\n{'|---' * (len(shown) + 2)}|")
    for row in fmeca_rows(fmeca(causes.prospects)):
        print("| " + " | ".join(row[c] for c in ("hardware", "objective", *shown)) + " |")


def confirm(found: MissionNet, causes: Causes) -> None:
    """Holds the mission's cut sets against CTL on its net, for every subset of hardware, and composition.

    Raises:
        AssertionError: Some subset says otherwise.
    """
    hardware = [h.name for h in found.core.hardware if h.faulty]
    for size in range(len(hardware) + 1):
        for dead in combinations(hardware, size):
            lost = any(set(names) <= set(dead) for names in causes.mission.cut_sets)
            assert success_reachable(found, dead) is not lost, dead
    assert find_causes(found, engine="local").mission.moments == causes.mission.moments
    print(f"confirmed by CTL for {2 ** len(hardware)} subsets, and by composition\n")


def success_reachable(found: MissionNet, dead: tuple[str, ...]) -> bool:
    """Whether some run succeeds with hardware out of service from the initial marking on, not repaired."""
    tokens = {f"{h}_{place}": int(place == "OOS") for h in dead for place in ("free", "available", "OOS")}
    places = tuple(replace(p, initial=tokens.get(p.name, p.initial)) for p in found.net.places)
    kept = tuple(t for t in found.net.transitions if t.event not in {Event(What.REPAIRED, h) for h in dead})
    net = replace(found.net, places=places, transitions=kept)
    return Evaluation(DiagramMarkings(reach(net))).holds(parse("EF success", MissionNames(found, net=net)))


def in_a_row(objectives: int, ways: int) -> Mission:
    """Objectives in a row, each with its own activity, of so many alternatives with a sensor each."""
    hardware = [[f"h{i}_{k}" for k in range(ways)] for i in range(objectives)]
    activities = tuple(
        Activity(name=f"a{i}", alternatives=tuple(Alternative(name=f"by_{h}", consumes=(h,)) for h in own))
        for i, own in enumerate(hardware)
    )
    robot = Robot(
        name="robot",
        hardware=tuple(Hardware(name=h) for own in hardware for h in own),
        activities=activities,
    )
    blocks = tuple(Objective(name=f"x{i}", activities=(f"a{i}",)) for i in range(objectives))
    return Mission(name="in_a_row", robots=(robot,), blocks=blocks)


def in_a_chain(resources: int, ways: int) -> Mission:
    """One objective on a chain of software: each is made in so many ways, of a sensor and the one before."""
    hardware = [[f"h{i}_{k}" for k in range(ways)] for i in range(resources)]
    makers = tuple(
        Activity(
            name=f"make{i}",
            produces=(f"s{i}",),
            alternatives=tuple(
                Alternative(name=f"by_{h}", consumes=(h, *([f"s{i - 1}"] if i else []))) for h in own
            ),
        )
        for i, own in enumerate(hardware)
    )
    use = Activity(name="use", alternatives=(Alternative(name="use", consumes=(f"s{resources - 1}",)),))
    robot = Robot(
        name="robot",
        hardware=tuple(Hardware(name=h) for own in hardware for h in own),
        software=tuple(Software(name=f"s{i}") for i in range(resources)),
        activities=(*makers, use),
    )
    return Mission(name="in_a_chain", robots=(robot,), blocks=(Objective(name="go", activities=("use",)),))


def growth() -> list[dict[str, Any]]:
    """Prints seconds by the graph of the whole mission, where that ends, and by composition; as rows too."""
    lines: list[dict[str, Any]] = []
    print(
        "| mission | hardware | cut sets | path sets | whole, s | composition, s |\n|---|---|---|---|---|---|"
    )
    for shape, sizes_of in ((in_a_row, (2, 3, 10, 20)), (in_a_chain, (2, 3, 6, 8))):
        for parts in sizes_of:
            found = compose(shape(parts, 3))
            started = time.perf_counter()
            local = find_causes(found, engine="local")
            seconds = time.perf_counter() - started
            # Closed form: any of the parts with its three ways.
            assert len(local.mission.cut_sets) == parts
            line: dict[str, Any] = {"mission": shape.__name__, "hardware": 3 * parts, "composition": seconds}
            whole = "-"
            if parts <= 3:
                started = time.perf_counter()
                whole_causes = find_causes(found, engine="explicit")
                assert whole_causes.mission.moments == local.mission.moments
                line["whole"] = time.perf_counter() - started
                whole = f"{line['whole']:.2f}"
            lines.append(line)
            sizes = f"{3 * parts} | {parts} | {3**parts}"
            print(f"| {shape.__name__} of {parts} | {sizes} | {whole} | {seconds:.2f} |", flush=True)
    return lines


def save(lines: list[dict[str, Any]], folder: Path) -> None:
    """Writes the CSV, and the plot: seconds against hardware, each shape of missions on its own."""
    curves = [
        Curves(
            shape,
            "hardware resources",
            "seconds",
            {
                way: [
                    (line["hardware"], line[way])
                    for line in lines
                    if line["mission"] == shape and way in line
                ]
                for way in ("whole", "composition")
            },
        )
        for shape in dict.fromkeys(line["mission"] for line in lines)
    ]
    plots.save(folder, "causes", lines, curves)


def main() -> None:
    """Ulysse, or missions that grow."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--growth", action="store_true", help="missions with more and more hardware")
    arguments = plots.parsed(parser, "causes")
    if arguments.output and not arguments.growth:
        parser.error("-o is for --growth")
    if not arguments.growth:
        ulysse()
        return
    lines = growth()
    if arguments.output:
        save(lines, arguments.output)


if __name__ == "__main__":
    main()
