"""Missions with shared data that grow: what a check costs beside listing the stable states along one run.

Usage: ``python experiments/growth/growth.py [--family NAME ...] [--sizes N ...] [--seconds S]
[--python PYTHON]``

Five families: a *ladder* of data, each made of the two before it or of one; *producers* with fallbacks, all
of which one activity wants; branches that *share* one localisation, each with a sensor of its own; branches
with *drivers* of their own beside it; and a *natural* mission (sites, branches, hardware, data, an
interruption), of which one number grows at a time. Beside them the walls of ``walls.py``: producers that
crash, data of one camera, common causes that overlap, branches of tasks that share one localisation, pauses,
sites that are inspected again, a resource that branches could contend for. Each row runs in a process of its
own: CPU seconds and MB of the listing without proof, and of ``check`` with all verdicts. At the end it fits
exponents: cost goes as size to that power. ``--python`` names another interpreter, with another mcpn
installed, to run the same rows with beside. A check should take at most twice the listing and 0.3 s; the last
column says by how much more it takes.
What whole commands take on large members, ``bars.py`` measures.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from math import log
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.growth.walls import LOCALISATION, WALLS, activity, mission
from mcpn.mission.model import SUCCEED, Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.writer import write_mission


def ladder(size: int) -> Mission:
    """A ladder of data, each made of the two before it, or of the one before those."""
    makers = [activity("make0", ("camera",), ("lidar",), produces=("d0",))]
    for i in range(1, size):
        first = [f"d{i - 1}", *([f"d{i - 2}"] if i > 1 else [])]
        makers.append(activity(f"make{i}", first, (f"d{max(i - 2, 0)}",), produces=(f"d{i}",)))
    drive = activity("drive", (f"d{size - 1}", "wheels"))
    look = activity("look", (f"d{size // 2}",))
    blocks = [
        Objective(name="go", activities=("drive", "look")),
        Objective(name="back", activities=("drive",)),
    ]
    return mission(("camera", "lidar", "wheels"), [*makers, drive, look], blocks)


def producers(size: int) -> Mission:
    """Producers with hardware of their own that fall back on the product of the one before."""
    makers = [
        activity(f"make{i}", (f"h{i}",), *([(f"d{i - 1}",)] if i else []), produces=(f"d{i}",))
        for i in range(size)
    ]
    fuse = activity("fuse", tuple(f"d{i}" for i in range(size)), ("d0",))
    drive = activity("drive", (f"d{size - 1}",))
    blocks = [
        Objective(name="go", activities=("fuse", "drive")),
        Objective(name="back", activities=("drive",)),
    ]
    return mission([f"h{i}" for i in range(size)], [*makers, fuse, drive], blocks)


def share(size: int) -> Mission:
    """Branches that need one localisation, each with a sensor of its own or without."""
    work = [activity(f"work{i}", ("position", f"h{i}"), ("position",)) for i in range(size)]
    blocks = tuple(Objective(name=f"o{i}", activities=(f"work{i}",)) for i in range(size))
    hardware = ["gps", "imu", *(f"h{i}" for i in range(size))]
    return mission(hardware, [LOCALISATION, *work], [Parallel(name="all", blocks=blocks)])


def drivers(size: int) -> Mission:
    """Branches with a driver of their own beside one localisation."""
    work = [
        each
        for i in range(size)
        for each in (
            activity(f"driver{i}", ("position", f"h{i}"), ("position",), produces=(f"d{i}",)),
            activity(f"work{i}", (f"d{i}", "position"), ("position",)),
        )
    ]
    blocks = tuple(Objective(name=f"o{i}", activities=(f"work{i}",)) for i in range(size))
    hardware = ["gps", "imu", *(f"h{i}" for i in range(size))]
    return mission(hardware, [LOCALISATION, *work], [Parallel(name="all", blocks=blocks)])


BASE = {"sites": 5, "branches": 2, "hardware": 8, "data": 5}


def natural(sites: int, branches: int, hardware: int, data: int) -> Mission:
    """Sites that are visited and worked on in branches; data with fallbacks; the battery calls back.

    The hardware is the wheels, a sensor for each second datum from the first on, and tools; the branches of a
    site take the tools in turn.
    """
    sensors = [f"sensor{i}" for i in range(0, data, 2)]
    tools = [f"tool{i}" for i in range(max(branches, hardware - len(sensors) - 1))]
    makers = []
    for i in range(data):
        ways = [[f"sensor{i}"]] if i % 2 == 0 else [[f"d{i - 1}"]]
        ways += [[f"d{max(i - 2, 0)}"]] if i > 1 else []
        makers.append(activity(f"make{i}", *ways, produces=(f"d{i}",)))
    drive = activity("drive", ("wheels", f"d{data - 1}"), ("wheels",))
    dock = activity("dock", ("wheels",))
    work = [
        activity(f"work{i}", (*tools[i::branches], f"d{i % data}"), (f"d{data - 1 - i % data}",), ())
        for i in range(branches)
    ]
    blocks: list[Block] = []
    for site in range(sites):
        parts = tuple(Objective(name=f"do{site}_{i}", activities=(f"work{i}",)) for i in range(branches))
        inside = (
            Objective(name=f"reach{site}", activities=("drive",)),
            Parallel(name=f"at{site}", blocks=parts),
        )
        onward = f"site{site + 1}" if site + 1 < sites else SUCCEED
        blocks.append(Recursive(name=f"site{site}", blocks=inside, success=onward, failure=onward))
    blocks.append(Objective(name="home", activities=("dock",)))
    handlers = (Handler(event="battery_low", goto="home"),)
    return mission(
        ["wheels", *sensors, *tools], [*makers, drive, dock, *work], blocks, handlers, ("battery_low",)
    )


def of_natural(parameter: str) -> Callable[[int], Mission]:
    """The natural mission of which one number grows."""
    return lambda size: natural(**{**BASE, parameter: size})


FAMILIES: dict[str, tuple[Callable[[int], Mission], tuple[int, ...]]] = {
    "ladder": (ladder, (6, 10, 20, 30)),
    "producers": (producers, (4, 8, 10, 12)),
    "share": (share, (2, 4, 6, 8)),
    "drivers": (drivers, (2, 4, 5, 6, 8)),
    "sites": (of_natural("sites"), (5, 100, 1000, 10_000)),
    "branches": (of_natural("branches"), (2, 3, 4, 5, 6, 8)),
    "hardware": (of_natural("hardware"), (8, 16, 24, 40)),
    "data": (of_natural("data"), (5, 8, 10, 20)),
    **WALLS,
}

LIST = """
import json, resource, sys, time
from mcpn.mission.xml import read_mission
from mcpn.drawing.compose import compose
from mcpn.spaces.stable.alternatives import direct
net = compose(read_mission(sys.argv[1])).net
begin = time.process_time()
graph = direct(net, proof=False, max_states=2_000_000)
print(json.dumps([graph.states, time.process_time() - begin]))
"""
CHECK = """
import json, sys, time
import mcpn
study = mcpn.open(sys.argv[1])
begin = time.process_time()
found = study.check()
print(json.dumps([found.failing, time.process_time() - begin]))
"""


def run(
    arguments: Sequence[str], folder: Path, seconds: float
) -> tuple[bytes, resource.struct_rusage] | None:
    """What a program prints, and what it used; nothing where it fails, or does not end in time."""
    limit = int(seconds) + 1

    def bounded() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))

    process = subprocess.Popen(
        arguments, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, preexec_fn=bounded, cwd=folder
    )
    assert process.stdout is not None
    told = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    return (told, used) if status in (0, 256) and told else None


def measured(python: str, script: str, path: Path, seconds: float) -> tuple[object, float, float] | None:
    """What a script prints first, its CPU seconds and peak MB; nothing where it does not end in time."""
    found = run([python, "-c", script, str(path)], path.parent, seconds)
    if found is None:
        return None
    value, spent = json.loads(found[0])
    return value, spent, found[1].ru_maxrss / 1024


def exponent(rows: Sequence[tuple[int, float]]) -> float:
    """The slope of a line through the logarithms of sizes and seconds."""
    points = [(log(size), log(max(seconds, 1e-3))) for size, seconds in rows]
    x, y = (sum(p[i] for p in points) / len(points) for i in (0, 1))
    spread = sum((p - x) ** 2 for p, _ in points)
    return sum((p - x) * (q - y) for p, q in points) / spread if spread else 0.0


def said(found: tuple[object, float, float] | None) -> str:
    """Seconds and MB, or that there are none."""
    return "-, -" if found is None else f"{found[1]:.2f}, {found[2]:.0f}"


def over(listed: tuple[object, float, float] | None, checked: tuple[object, float, float] | None) -> str:
    """By how many seconds a check took more than twice the listing and 0.3 s."""
    if listed is None or checked is None:
        return "-"
    more = checked[1] - 2 * listed[1] - 0.3
    return f"{more:.2f}" if more > 0 else "kept"


def write(family: str, size: int, folder: str) -> Path:
    """Writes a member of a family."""
    path = Path(folder) / f"{family}{size}.xml"
    path.write_bytes(write_mission(FAMILIES[family][0](size)))
    return path


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--family", nargs="+", choices=FAMILIES)
    parser.add_argument("--sizes", nargs="+", type=int)
    parser.add_argument("--seconds", type=float, default=60, help="of CPU for each row (default 60)")
    parser.add_argument("--python", help="another interpreter to run the same rows with")
    options = parser.parse_args()
    pythons = [sys.executable, *([options.python] if options.python else [])]
    others = "| check beside, s, MB " * (len(pythons) - 1)
    print(f"| family | size | stable states | listed, s, MB | check, s, MB {others}| over |")
    print("|---|---|---|---|---|---|" + "---|" * (len(pythons) - 1))
    begin = time.monotonic()
    fitted = {}
    with tempfile.TemporaryDirectory() as folder:
        for family in options.family or FAMILIES:
            rows = []
            for size in options.sizes or FAMILIES[family][1]:
                path = write(family, size, folder)
                listed = measured(sys.executable, LIST, path, options.seconds)
                checks = [measured(python, CHECK, path, options.seconds) for python in pythons]
                states = "-" if listed is None else f"{listed[0]}"
                rest = " | ".join(said(found) for found in checks)
                print(
                    f"| {family} | {size} | {states} | {said(listed)} | {rest} | {over(listed, checks[0])} |",
                    flush=True,
                )
                if checks[0] is not None:
                    rows.append((size, checks[0][1]))
            if len(rows) > 1:
                fitted[family] = exponent(rows)
    print("exponents:", ", ".join(f"{family} {power:.1f}" for family, power in fitted.items()))
    print(f"{time.monotonic() - begin:.0f} s; CPython {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
