"""Missions for the problems of the ROS deliberation workshop 2024, in its worlds, beside the numbers of risk.

Usage: ``python experiments/robots/roscon.py --roscon FOLDER [--runs N] [--seed S] [--jobs N] [--write]``

FOLDER (or ``MCPN_ROSCON``) has the workshop's worlds, as PyRoboSim reads them (``mcpn[worlds]``). Each
mission is verified, and run N times with seeded failures (default 100); the share of successes is to be what
risk says. Each run is replayed on the mission's net, and watched by its monitors; where the mission has ended
well, the world must be as its goal says. It takes some thirty minutes for 100 runs of each on two
busy cores. ``--write`` puts the table into papers/roscon.md.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import os
import re
import sys
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from mcpn.answers.causes.risk import risk
from mcpn.controller.document import document
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.controller.simulator import Simulation
from mcpn.events import Event
from mcpn.robot.bench.runs import interval
from mcpn.robot.drivers.mapping import check_plan
from mcpn.robot.drivers.reading import read_drivers
from mcpn.robot.drivers.running import RobotRun
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.monitors import Monitors
from mcpn.study import Study, open_study

HERE = Path(__file__).parents[1] / "roscon"
PAGE = Path(__file__).parents[2] / "papers" / "roscon.md"
BLOCK = re.compile(r"(<!-- measured: roscon -->\n).*?(<!-- end -->)", re.DOTALL)
CONFIDENCE = 0.99

Seen = Mapping[str, str | bool | float]
GOALS: dict[str, Callable[[Seen], bool]] = {
    "problem1": lambda seen: seen["snacks0"] == "table_tabletop",
    "problem2": lambda seen: (
        seen["waste0"] == seen["waste1"] == "dumpster_disposal" and seen["dumpster"] is False
    ),
    "problem3": lambda seen: (
        seen["bread0"] == seen["butter0"] == "table_tabletop"
        and seen["pantry"] is False
        and seen["fridge"] is False
    ),
    "problem4": lambda seen: (
        GOALS["problem2"](seen) and GOALS["problem3"](seen) and float(seen["battery"]) > 0
    ),
}
"""By mission, its goal in the words of the world."""


@dataclass(frozen=True)
class Prepared:
    """A mission, ready to be run many times."""

    study: Study
    tables: Tables
    monitors: Mapping[str, Any]


@dataclass(frozen=True)
class OneRun:
    """What came of one run."""

    outcome: str | None
    events: int
    refused: int
    violated: tuple[str, ...]
    replayed: bool
    goal: bool
    seen: Seen
    battery: float
    unforeseen: int
    failures: int


@cache
def prepared(name: str) -> Prepared:
    """A mission of this folder, by its file."""
    study = open_study(HERE / f"{name}.xml")
    tables = Tables(document(study.controller("auto"), study.mission_net))
    return Prepared(study, tables, json.loads(files(monitors_of(study.spaces))["monitors.json"]))


def run(name: str, folder: Path, seed: int, goal: str | None = None) -> OneRun:
    """Runs a mission once, in a world at its start."""
    made, plan = prepared(name), read_drivers(HERE / "drivers.toml")
    check_plan(plan, made.tables)  # which finds the drivers beside the file
    import actions

    laws = made.tables.laws.objectives
    (world,) = {row["parameters"]["world"]["value"] for row in laws.values()}
    actions.begin(folder / "worlds" / world, seed)
    controller = Controller(made.tables)
    monitors = Monitors(made.monitors)
    controller.observe(lambda step: monitors.take(step.event) if step.taken else None)
    asyncio.run(RobotRun(controller, made.tables, plan).run())
    beside = Simulation(made.study.mission_net)
    replayed = all(beside.take(Event.parse(step.event)) for step in controller.log if step.taken)
    replayed = replayed and beside.situation.outcome == controller.outcome
    seen = actions.where()
    actions.end()
    failures = sum(step.event.endswith("_EV_FAIL") for step in controller.log)
    return OneRun(
        controller.outcome,
        controller.count,
        controller.refusals,
        tuple(monitors.violated),
        replayed,
        GOALS[goal or name](seen),
        seen,
        float(seen["battery"]),
        int(seen["unforeseen"]),
        failures,
    )


def runs(name: str, folder: Path, seeds: range) -> list[OneRun]:
    """Some runs of a mission, in a process of their own."""
    logging.disable(logging.WARNING)
    return [run(name, folder, seed) for seed in seeds]


def row(name: str, folder: Path, number: int, seed: int, jobs: int) -> tuple[list[str], bool]:
    """A row of the table, and whether all is as it should be."""
    study = prepared(name).study
    checked = study.verdicts()
    expected = risk(study.causes().prospects).success
    started = time.monotonic()
    parts = [range(seed + part, seed + number, jobs) for part in range(jobs)]
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        found = [one for some in pool.map(runs, [name] * jobs, [folder] * jobs, parts) for one in some]
    minutes = (time.monotonic() - started) / 60
    ended = [one for one in found if one.outcome == "success"]
    low, high = interval(len(ended), number, CONFIDENCE)
    failures = sum(one.failures for one in found)
    refused, violated = sum(one.refused for one in found), sum(bool(one.violated) for one in found)
    as_it_should_be = (
        checked.passed
        and low <= expected <= high
        and refused == violated == 0
        and all(one.replayed for one in found)
        and all(one.goal for one in ended)
        and all(one.battery > 0 for one in found)
    )
    cells = [
        name,
        str(len(study.verdicts().requirements)),
        f"{len(ended)} of {number}",
        f"[{low:.3f}, {high:.3f}]",
        f"{expected:.3f}",
        str(sum(one.goal for one in ended)),
        str(sum(one.events for one in found)),
        f"{failures}, {sum(one.unforeseen for one in found)}",
        str(refused),
        f"{min(one.battery for one in found):.0f} %",
        str(sum(one.replayed for one in found)),
        f"{minutes:.1f}",
    ]
    return cells, as_it_should_be


HEADS = [
    "mission",
    "requirements met",
    "successes",
    "99 % interval",
    "risk",
    "goals in the world",
    "events",
    "failures of actions, of them not drawn",
    "refused",
    "least battery",
    "runs replayed",
    "minutes",
]


def published(folder: Path) -> tuple[str, bool]:
    """The published tree's steps of problem 2: what verification says, and what a run shows in the world."""
    name = "problem2_published"
    found = prepared(name).study.verdicts()
    unmet = [answer.asked.name for answer in found.requirements if not answer.met]
    for seed in range(100):
        one = run(name, folder, seed, "problem2")
        if one.outcome == "success":
            open_ = "open" if one.seen["dumpster"] else "closed"
            waste = ", ".join(str(one.seen[name]) for name in ("waste0", "waste1"))
            text = (
                f"The steps of the published tree of problem 2: `check` fails the requirement "
                f"`{', '.join(unmet)}`; run with seed {seed} the mission ends in success, the waste is in "
                f"{waste}, the dumpster {open_}."
            )
            return text, unmet == ["shut"] and open_ == "open" and not one.goal and one.violated == ("shut",)
    return "No run of the published steps has succeeded.", False


def main() -> None:
    """Verifies, runs, compares."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--roscon", type=Path, default=os.environ.get("MCPN_ROSCON"), metavar="FOLDER")
    parser.add_argument("--runs", type=int, default=100, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--jobs", type=int, default=2, metavar="N")
    parser.add_argument("--only", nargs="*", choices=GOALS, default=list(GOALS), metavar="MISSION")
    parser.add_argument("--write", action="store_true", help="put the table into papers/roscon.md")
    arguments = parser.parse_args()
    if arguments.roscon is None:
        parser.error("--roscon FOLDER, or MCPN_ROSCON, is needed")
    folder = Path(arguments.roscon).resolve()
    lines = ["| " + " | ".join(HEADS) + " |", "|" + "---|" * len(HEADS)]
    good = True
    for name in arguments.only:
        cells, as_it_should_be = row(name, folder, arguments.runs, arguments.seed, arguments.jobs)
        good &= as_it_should_be
        lines.append("| " + " | ".join(cells) + " |")
        print(lines[-1], "" if as_it_should_be else "NOT AS IT SHOULD BE", flush=True)
    text, shown = published(folder)
    print(text)
    if arguments.write and arguments.only == list(GOALS):
        page = PAGE.read_text()
        table = "\n".join([*lines, "", text]) + "\n"
        PAGE.write_text(BLOCK.sub(lambda found: found[1] + table + found[2], page))
    sys.exit(0 if good and shown else 1)


if __name__ == "__main__":
    main()
