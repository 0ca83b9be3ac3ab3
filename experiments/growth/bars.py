"""What commands take on large members of the growing families, beside what they should take.

Usage: ``python experiments/growth/bars.py [--rows asked|others|all] [--family NAME ...] [--beside FOLDER ...]
[--runs N] [--seconds S]``

Each row is a command as a whole process: seconds of CPU, user and system together, and the largest MB. Its
bytecode is cached, in a folder of its own. ``--beside`` names other checkouts with a kernel: each row is run
with each of them, oldest first, in turn with this one, so that all columns of a row are of the same hour. Of
``--runs`` runs the one counts that took least. Of families with several sizes the exponents of seconds and MB
are printed: cost goes as size to that power. The rows that are *asked* are those of the request that the
README answers, *others* are of earlier ones; together they take some ten minutes with this code alone.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.growth.growth import FAMILIES, exponent
from experiments.shared.missions import Parameters, generate
from experiments.shared.rates import rated
from mcpn.mission.writer import write_mission

ROOT = Path(__file__).resolve().parents[2]


class Bar(NamedTuple):
    """What a command should take on a member of a family, at most.

    Args:
        family: Its name; ``courier`` and ``ulysse`` are worked missions, ``net`` is a net of two places.
        size: Of the member; 0 where there is one.
        command: By its name in :data:`COMMANDS`.
        seconds: Of CPU; where there are none, the row is there for its exponent.
        memory: MB.
        switches: Of contexts, which the process asks for.
    """

    family: str
    size: int
    command: str
    seconds: float | None = None
    memory: int | None = None
    switches: int | None = None


ASKED = (
    Bar("sites", 1000, "causes"),
    Bar("sites", 3000, "causes", 12, 500),
    Bar("sites", 10_000, "causes", 45, 1500),
    Bar("sites", 1000, "check", 1.6, 70),
    Bar("sites", 3000, "check", 5),
    Bar("sites", 10_000, "check", 18, 600),
    Bar("hardware", 40, "causes --json", 2.5, None, 1000),
    Bar("hardware", 40, "modular", 2.5),
    Bar("hardware", 40, "report", 6),
    *(
        Bar("fused", size, "check", most)
        for size, most in ((4, None), (6, None), (8, 1), (12, 4), (16, None))
    ),
    Bar("crashing", 8, "check"),
    Bar("crashing", 12, "check", 1.3),
    Bar("crashing", 16, "check", 3),
    *(
        Bar("pausing", size, "check", most)
        for size, most in ((6, None), (8, None), (10, 0.8), (12, 1.5), (16, None))
    ),
    Bar("sites with rates", 5, "causes --rates", 1),
    Bar("sites", 5, "flat", 1.2),
    Bar("branches", 6, "hierarchical", 2),
)
"""The rows of the request."""
OTHERS = (
    *(
        Bar(family, size, "check --json", 5)
        for family, size in (("data", 20), ("ladder", 30), ("producers", 12))
    ),
    *(Bar(family, 8, "check --json", 5) for family in ("share", "drivers", "branches")),
    Bar("hardware", 40, "check --json", 5),
    Bar("100 sections of", 30, "causes --json", 2),
    Bar("overlapping", 16, "check --json", 3),
    Bar("chains", 8, "check --json", 3),
    Bar("tasks", 64, "check --json", 5),
    Bar("pausing", 10, "modular", 5),
    Bar("quadruped", 6, "modular", 3),
    Bar("sites", 5, "tests", 5),
    Bar("inspecting", 10_000, "check --json", 15, 500),
    Bar("inspecting", 10_000, "causes --json", 40),
    Bar("inspecting", 10_000, "report", 45),
    Bar("courier", 0, "check --json", 1),
    Bar("ulysse", 0, "check --json", 0.16),
    Bar("net", 0, "check --json", 0.09),
    Bar("past", 8, "check --json", 5),
    Bar("passing", 8, "check --json", 1.3),
    Bar("sites", 1000, "check --json"),
    Bar("sites", 3000, "check --json"),
    Bar("sites", 10_000, "check --json"),
    Bar("sites", 10_000, "causes --json", 60),
    Bar("branches", 5, "modular", 2),
    Bar("sites", 10_000, "report", 60),
)
"""Rows of earlier requests. ``passing`` may contend and does not: it should take at most so many times what
``past`` takes, which is the same and cannot contend."""
COMMANDS = {
    "check": ("check",),
    "check --json": ("check", "--json"),
    "causes": ("causes",),
    "causes --json": ("causes", "--json"),
    "causes --rates": ("causes", "--rates"),
    "modular": ("controller", "-o", "controller", "--form", "modular"),
    "flat": ("controller", "-o", "controller", "--form", "flat"),
    "hierarchical": ("controller", "-o", "controller", "--form", "hierarchical"),
    "report": ("report", "-o", "report.html"),
    "tests": ("tests", "-o", "tests"),
}
"""By the name of a row's command its words; the mission stands behind the first."""


class Took(NamedTuple):
    """What a process took: seconds, MB, switches of contexts, and how it ended."""

    seconds: float
    memory: float
    switches: int
    refused: bool


def write(family: str, size: int, folder: Path) -> Path:
    """Writes a member of a family."""
    worked = ROOT / "experiments" / family / "mission.xml"
    if worked.exists():
        return worked
    if family == "net":
        path = folder / "net.net"
        path.write_text("pl a (1)\ntr t a -> b\ntr u b -> a\n", encoding="utf-8")
        return path
    if family == "100 sections of":
        made = generate(Parameters(100, 20, size, per_section=4))
    elif family == "sites with rates":
        made = rated(FAMILIES["sites"][0](size))
    else:
        made = FAMILIES[family][0](size)
    path = folder / f"{family.replace(' ', '_')}{size}.xml"
    path.write_bytes(write_mission(made))
    return path


def ran(checkout: Path, words: Sequence[str], path: Path, folder: Path, seconds: float) -> Took | None:
    """What a command takes with the code of a checkout; nothing where it fails, or does not end in time."""
    limit = int(seconds) + 1

    def bounded() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))

    caches = folder / f"bytecode{abs(hash(checkout))}"
    said = {"PYTHONPATH": str(checkout), "PYTHONPYCACHEPREFIX": str(caches)}
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    command, *options = words
    process = subprocess.Popen(
        [sys.executable, "-m", "mcpn.cli", command, str(path), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        preexec_fn=bounded,
        cwd=folder,
        env=kept | said,
    )
    assert process.stdout is not None
    while process.stdout.read(1 << 20):
        pass
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1, 2):
        return None
    refused = process.returncode == 2
    return Took(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, used.ru_nvcsw, refused)


def verdict(bar: Bar, took: Took | None, most: float | None) -> str:
    """Whether a bar is kept, or by how much it is missed."""
    if most is None:
        return ""
    if took is None:
        return "missed"
    over = [f"{took.seconds - most:.2f} s"] if took.seconds > most else []
    if bar.memory is not None and took.memory > bar.memory:
        over.append(f"{took.memory - bar.memory:.0f} MB")
    if bar.switches is not None and took.switches > bar.switches:
        over.append(f"{took.switches - bar.switches} switches")
    return f"missed by {', '.join(over)}" if over else "kept"


def shown(bar: Bar, took: Took | None, seconds: float) -> str:
    """What a process took, in a cell."""
    if took is None:
        return f"- ({seconds:g})"
    more = "" if bar.switches is None else f", {took.switches}"
    return f"{'refused: ' if took.refused else ''}{took.seconds:.2f}, {took.memory:.0f}{more}"


Curves = dict[tuple[str, str, int], list[tuple[int, Took]]]
"""By family, command and number of the code, the sizes of members with what they took."""


def print_exponents(curves: Curves, names: str, codes: int) -> None:
    """Prints the exponents of families of which several sizes were answered."""
    print(f"\n| exponents: s, MB | of sizes | {names} |\n|---|---|{'---|' * codes}")
    for family, command in dict.fromkeys(key[:2] for key in curves):
        of = [curves.get((family, command, number), []) for number in range(codes)]
        sizes = [size for size, _ in max(of, key=len)]
        cells = []
        for each in of if len(sizes) > 1 else ():
            seconds = exponent([(size, took.seconds) for size, took in each])
            memory = exponent([(size, took.memory) for size, took in each])
            cells.append(f"{seconds:.1f}, {memory:.1f}" if len(each) == len(sizes) else "-")
        if cells:
            print(f"| {family}, {command} | {', '.join(map('{:,}'.format, sizes))} | {' | '.join(cells)} |")


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rows", choices=("asked", "others", "all"), default="all")
    parser.add_argument("--family", nargs="+", choices=dict.fromkeys(b.family for b in (*ASKED, *OTHERS)))
    parser.add_argument(
        "--beside", nargs="+", type=Path, default=[], help="checkouts with a kernel, oldest first"
    )
    parser.add_argument(
        "--runs", type=int, default=3, help="of each row that takes less than 5 s (default 3)"
    )
    parser.add_argument("--seconds", type=float, default=60, help="of CPU for each row (default 60)")
    options = parser.parse_args()
    codes = [*(path.resolve() for path in options.beside), ROOT]
    every = {"asked": ASKED, "others": OTHERS, "all": (*ASKED, *OTHERS)}[options.rows]
    bars = [bar for bar in every if not options.family or bar.family in options.family]
    names = " | ".join(path.name for path in codes)
    print(
        f"| mission | command | {names} | asked: s, MB | |\n|---|---|{'---|' * len(codes)}---|---|",
        flush=True,
    )
    curves: Curves = {}
    past = 0.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for code in codes:  # makes the bytecode
            for words in sorted({bar.command for bar in bars}):
                ran(code, COMMANDS[words], write("sites", 1, folder), folder, options.seconds)
        for bar in bars:
            path = write(bar.family, bar.size, folder)
            least: list[Took | None] = [None] * len(codes)
            for _ in range(options.runs):
                for number, code in enumerate(codes):
                    before = least[number]
                    took = ran(code, COMMANDS[bar.command], path, folder, options.seconds)
                    if took is not None and (before is None or took.seconds < before.seconds):
                        least[number] = took
                if all(took is None or took.seconds >= 5 for took in least):
                    break
            for number, took in enumerate(least):
                if took is not None and not took.refused:
                    curves.setdefault((bar.family, bar.command, number), []).append((bar.size, took))
            now, most = least[-1], bar.seconds
            if bar.family == "passing" and most is not None:
                most *= past
            past = now.seconds if now and bar.family == "past" else past
            asked = "-" if most is None else f"{most:.3g}" + (f", {bar.memory}" if bar.memory else "")
            cells = " | ".join(shown(bar, took, options.seconds) for took in least)
            name = f"{bar.family} {bar.size:,}" if bar.size else bar.family
            print(f"| {name} | {bar.command} | {cells} | {asked} | {verdict(bar, now, most)} |", flush=True)
    print_exponents(curves, names, len(codes))
    versions = ", ".join(
        f"{each} {metadata.version(each)}" for each in ("numpy", "scipy", "lxml", "networkx")
    )
    print(
        f"\nCPython {platform.python_version()}, {versions}; {os.cpu_count()} cores, {platform.machine()}; "
        f"load {os.getloadavg()[2]:.1f}"
    )


if __name__ == "__main__":
    main()
