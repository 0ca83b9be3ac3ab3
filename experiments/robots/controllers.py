"""Sizes of controllers, and what an event costs: bytes of tables and code, instructions at worst.

Usage: ``python experiments/robots/controllers.py [--sections N] [--events N]``

Ulysse and the courier, whose sections events interrupt, flat and hierarchical, minimised and not, and a
generated mission of many sections, whose flat controller cannot be built. The C target is compiled with
``gcc -Os``; ``size`` tells the bytes. The instructions of ``*_handle`` are counted by callgrind, event by
event: of Ulysse on a run that takes every edge from every state, so that the most seen is the worst; of the
others on a random run (needs gcc, size and valgrind; no valgrind, no instructions).
With its defaults it takes a minute or two.
"""

from __future__ import annotations

import argparse
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.shared.missions import Parameters
from experiments.shared.missions import generate as generate_mission
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import TableController
from mcpn.controller.minimise import minimise
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files

HERE = Path(__file__).parents[1]


def events_of(controller: TableController, mission_net: MissionNet, count: int | None) -> list[str]:
    """A random run, or one that takes every edge; an empty event begins again."""
    if count is None:
        sys.path.insert(0, str(Path(__file__).parents[2]))
        from tests.controller.traces import Traced, tour

        return tour(Traced(document(controller, mission_net)))[0]
    said, rng = document(controller, mission_net), random.Random(0)
    runtime, events = Runtime.from_document(said, log=1), list[str]()
    start = runtime.snapshot()
    while len(events) < count:
        if runtime.outcome or not runtime.possible:
            runtime.restore(start)
            events.append("")
            continue
        events.append(rng.choice(runtime.possible))
        runtime.handle(events[-1])
    return events


def harness(prefix: str) -> str:
    """A program that handles the events of its input."""
    upper = prefix.upper()
    return f"""
#include <stdio.h>
#include <string.h>
#include "{prefix}.h"
int main(void)
{{
    static {prefix}_controller controller;
    static {prefix}_action actions[{upper}_MAX_ACTIONS];
    static char line[1024];
    size_t count;
    {prefix}_init(&controller);
    while (fgets(line, sizeof line, stdin) != NULL) {{
        {prefix}_event event;
        size_t length = strcspn(line, "\\n");
        if (length == 0) {{ {prefix}_init(&controller); continue; }}
        event = {prefix}_event_of(line, length);
        (void){prefix}_handle(&controller, event, actions, &count);
    }}
    return 0;
}}
"""


def measure(name: str, controller: TableController, mission_net: MissionNet, count: int | None) -> None:
    """Prints a row for one controller."""
    texts = files(document(controller, mission_net), "c")
    prefix = next(n for n in texts if n.endswith(".h")).removesuffix(".h")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for file, text in texts.items():
            (folder / file).write_text(text)
        subprocess.run(["gcc", "-std=c99", "-Os", "-c", f"{prefix}.c"], cwd=folder, check=True)
        size = subprocess.run(
            ["size", "-A", f"{prefix}.o"], cwd=folder, capture_output=True, text=True, check=True
        )
        sections = dict(re.findall(r"^(\.\S+)\s+(\d+)", size.stdout, re.M))
        code = sum(int(v) for k, v in sections.items() if k.startswith(".text"))
        data = sum(int(v) for k, v in sections.items() if k.startswith((".rodata", ".data")))
        tables = int(re.findall(r"(\d+) bytes of constant tables", texts[f"{prefix}.h"])[0])
        worst, mean = instructions(prefix, events_of(controller, mission_net, count), folder)
    print(
        f"| {name} | {controller.states} | {controller.moves} | {tables} | {data} | {code} "
        f"| {worst} | {mean} |",
        flush=True,
    )


def instructions(prefix: str, events: list[str], folder: Path) -> tuple[str, str]:
    """The most and the mean instructions of an event."""
    if shutil.which("valgrind") is None:
        return "", ""
    (folder / "harness.c").write_text(harness(prefix))
    subprocess.run(
        ["gcc", "-std=c99", "-Os", "-o", "harness", "harness.c", f"{prefix}.c"], cwd=folder, check=True
    )
    subprocess.run(
        [
            "valgrind",
            "--tool=callgrind",
            "--callgrind-out-file=out",
            f"--toggle-collect={prefix}_handle",
            f"--dump-after={prefix}_handle",
            "./harness",
        ],
        cwd=folder,
        input="\n".join(events) + "\n",
        text=True,
        capture_output=True,
        check=True,
    )
    counts = []
    for path in folder.glob("out.*"):
        found = re.search(r"^(?:totals|summary): (\d+)", path.read_text(), re.M)
        if found and int(found[1]):
            counts.append(int(found[1]))
    return str(max(counts)), str(round(sum(counts) / len(counts)))


def main() -> None:
    """Measures them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--sections", type=int, default=1000)
    parser.add_argument("--events", type=int, default=2000, help="of each run")
    arguments = parser.parse_args()
    heads = ("states", "edges", "bytes of tables", "of data", "of code", "most instructions", "mean")
    print(f"| controller | {' | '.join(heads)} |")
    print("|---" * (len(heads) + 1) + "|")
    for name, count in (("ulysse", None), ("courier", arguments.events)):
        mission_net = compose(read_mission(HERE / name / "mission.xml"))
        for form in ("flat", "hierarchical"):
            found = generate(mission_net, "flat" if form == "flat" else "hierarchical")
            measure(f"{name}, {form}", found, mission_net, count)
            measure(f"{name}, {form}, minimised", minimise(found), mission_net, count)
    large = compose(generate_mission(Parameters(sections=arguments.sections, types=8, hardware=30), 0))
    try:
        generate(large, "flat")
    except LimitError as error:
        print(f"{arguments.sections} sections, flat: {error}")
    found = generate(large)
    measure(f"{arguments.sections} sections, hierarchical", found, large, arguments.events)
    measure(
        f"{arguments.sections} sections, hierarchical, minimised", minimise(found), large, arguments.events
    )


if __name__ == "__main__":
    main()
