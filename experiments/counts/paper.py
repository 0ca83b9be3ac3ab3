"""Every table of papers/mcpn.md and papers/comparison.md, measured and written anew.

Usage: ``python experiments/counts/paper.py [TABLE...] [--seconds S]``

Each table stands in a page between ``<!-- measured: TABLE -->`` and ``<!-- end -->``; without arguments all
are renewed. Times are CPU time; what does not end within S seconds of it (default 10; long missions six times
that, engines side by side thirty times) is marked ``-``. It takes some eleven minutes on two cores with its
defaults. Columns whose heads end with CPU s, CPU ms or MB depend on the machine; all others are counts, the
same everywhere, and ``tests/test_experiments.py`` holds the pages to them.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.counts import comparison, explicit_vs_symbolic, orders, table1
from experiments.counts import proofs as ways_of_proof
from experiments.counts.causes import in_a_chain, in_a_row
from experiments.counts.composition import run_engine
from experiments.shared.limits import Result, measured
from experiments.shared.missions import Parameters, generate
from mcpn import __version__
from mcpn.answers.causes.find import find_causes
from mcpn.controller.generate import Form
from mcpn.controller.generate import generate as generate_controller
from mcpn.controller.minimise import minimise
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission

PAPERS = Path(__file__).parents[2] / "papers"
PAGES = (PAPERS / "mcpn.md", PAPERS / "comparison.md")
BLOCK = re.compile(r"(<!-- measured: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


@dataclass(frozen=True)
class Asked:
    """What of a table is measured.

    Args:
        seconds: CPU time that a small run may take.
        wanted: Says of the name of a row whether it is measured.
        timed: Whether what adds nothing but its seconds is run, too.
    """

    seconds: float = 10
    wanted: Callable[[str], bool] = lambda _: True
    timed: bool = True


def markdown(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown."""
    names = list(heads)
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def machine(_: Asked) -> str:
    """The machine and versions."""
    cpu = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        found = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
        cpu = found[1] if found else cpu
    gib = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    libraries = []
    for name in ("numpy", "scipy", "pyeda"):
        try:
            libraries.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            libraries.append(f"no {name}")
    load = os.getloadavg()[0]
    return (
        f"{cpu}, {os.cpu_count()} processors, {gib:.0f} GiB, {platform.system()}; CPython "
        f"{platform.python_version()}, mcpn {__version__}, {', '.join(libraries)}. Load of the machine when "
        f"tables were measured: {load:.1f} (above {os.cpu_count()} other work slowed them down)."
    )


def sizes(_: Asked) -> str:
    """The counts of Table 1."""
    return markdown(("Ulysse", "TAROS 2017, Table 1", "mcpn"), table1.counts())


def times(_: Asked) -> str:
    """The seconds of Table 1."""
    return markdown(("Ulysse", "TAROS 2017, Table 1, s", "mcpn, CPU s"), table1.seconds(3))


def proofs(asked: Asked) -> str:
    """What each way of the proof decides of sections, and what it leaves."""
    return markdown(ways_of_proof.HEADS, ways_of_proof.rows(200, 1, asked.seconds, asked.wanted))


def ways(asked: Asked) -> str:
    """What decides that events have one outcome."""
    return markdown(orders.HEADS, orders.rows(asked.seconds, asked.wanted))


def growth(asked: Asked) -> str:
    """Explicit against symbolic."""
    engines = explicit_vs_symbolic.ENGINES if asked.timed else ("symbolic",)
    lines = explicit_vs_symbolic.measure(6, asked.seconds, engines, asked.wanted)
    return explicit_vs_symbolic.table(list(lines))


def side_by_side(asked: Asked) -> str:
    """Every engine on worked missions and families."""
    return markdown(comparison.HEADS, comparison.rows(30 * asked.seconds, 1, asked.wanted))


def sections(asked: Asked) -> str:
    """Composition on long missions."""
    engines = ("direct", "symbolic", "local")
    gone = set[str]()
    rows = []
    for number in (10, 100, 1000):
        if not asked.wanted(str(number)):
            continue
        mission = generate(Parameters(number, min(20, number), 30, per_section=4))
        found = {
            engine: measured(run_engine, engine, mission, seconds=6 * asked.seconds)
            for engine in engines
            if engine not in gone and (asked.timed or engine == "local")
        }
        gone |= {engine for engine, of in found.items() if "seconds" not in of}
        told = (found.get(engine, {}).get("seconds") for engine in engines)
        local = found["local"]
        counts = (local.get(key, "-") for key in ("types", "most", "local", "stable"))
        rows.append((number, *counts, *("-" if s is None else f"{s:.1f}" for s in told)))
    heads = ("sections", "types", "most hardware of a section", "local states", "stable states of the whole")
    return markdown((*heads, *(f"{engine}, CPU s" for engine in engines)), rows)


def _causes(engine: str, shape: Callable[[int, int], Mission], parts: int) -> Result:
    causes = find_causes(compose(shape(parts, 3)), engine=engine)
    return {"cut_sets": len(causes.mission.cut_sets)}


def causes(asked: Asked) -> str:
    """Failure causes on redundant missions; cut sets against their closed form."""
    rows = []
    for shape, numbers in ((in_a_row, (2, 3, 10, 20)), (in_a_chain, (2, 3, 6))):
        for parts in numbers:
            name = f"{shape.__name__.replace('_', ' ')} of {parts}"
            if not asked.wanted(name):
                continue
            local = measured(_causes, "local", shape, parts, seconds=6 * asked.seconds)
            whole: Result = {}
            if asked.timed:
                whole = measured(_causes, "explicit", shape, parts, seconds=asked.seconds)
            for found in (whole, local):
                assert found.get("cut_sets", parts) == parts, "each part with its three ways is a cut set"
            told = [f"{f['seconds']:.2f}" if "seconds" in f else "-" for f in (whole, local)]
            rows.append((name, 3 * parts, local.get("cut_sets", "-"), 3**parts, *told))
    heads = ("mission", "hardware", "cut sets", "path sets", "whole graph, CPU s", "composition, CPU s")
    return markdown(heads, rows)


def controllers(_: Asked) -> str:
    """Sizes of controllers."""
    rows: list[tuple[object, ...]] = []
    ulysse = read_mission(table1.MISSION)
    forms: tuple[Form, ...] = ("flat", "hierarchical")
    many = generate(Parameters(100, 20, 30, per_section=4))
    for name, mission, wanted in (("Ulysse", ulysse, forms), ("100 sections, 30 hardware", many, forms[1:])):
        for form in wanted:
            found = generate_controller(compose(mission), form)
            small = minimise(found)
            rows.append((f"{name}, {form}", found.states, found.moves, small.states, small.moves))
    return markdown(("controller", "states", "edges", "states, minimised", "edges, minimised"), rows)


TABLES: dict[str, Callable[[Asked], str]] = {
    made.__name__: made
    for made in (machine, sizes, times, ways, proofs, growth, sections, causes, controllers, side_by_side)
}
NAMED = {"growth": 2, "side_by_side": 2}
"""How many columns name a row, where it is not the first alone."""

Rows = dict[str, dict[str, str]]
"""By the name of a row, what it says in each column that holds counts."""


def counts(name: str, table: str) -> Rows:
    """What a table counts; a table of the page, or one that has just been made."""
    heads, _, *lines = ([cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines())
    names = NAMED.get(name, 1)
    counted = [head for head in heads if not head.endswith(("CPU s", "CPU ms", "MB"))]
    found = Rows()
    for line in lines:
        said = dict(zip(heads, line, strict=True))
        found[" ".join(line[:names])] = {head: said[head] for head in counted}
    return found


def stale(name: str, asked: Asked) -> list[str]:
    """Where a page says another count than what is counted now.

    What took too long, then or now, is not compared; of rows that are not asked for nothing is said.
    """
    (page,) = (m[0] for path in PAGES for m in BLOCK.finditer(path.read_text()) if m[2] == name)
    then = counts(name, "\n".join(page.splitlines()[1:-1]))
    now = counts(name, TABLES[name](asked))
    every = all(map(asked.wanted, then))
    found = (
        [f"{name}: rows {', '.join(then.keys() ^ now.keys())}"] if every and then.keys() != now.keys() else []
    )
    for row, said in now.items():
        for head, count in said.items():
            told = then.get(row, {}).get(head, "nothing")
            if "-" not in (count, told) and count != told:
                found.append(f"{name}, {row}, {head}: the page says {told}, today's code {count}")
    return found


def renewed(page: str, wanted: Iterable[str], seconds: float) -> str:
    """A page with some of its tables measured anew."""
    chosen = set(wanted)

    def write(match: re.Match[str]) -> str:
        if match[2] not in chosen:
            return match[0]
        print(f"{match[2]} ...", file=sys.stderr, flush=True)
        return f"{match[1]}{TABLES[match[2]](Asked(seconds))}\n{match[3]}"

    return BLOCK.sub(write, page)


def main() -> None:
    """Renews the pages."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="*", choices=[[], *TABLES], default=[], metavar="TABLE")
    parser.add_argument("--seconds", type=float, default=10, help="limit of small runs (default 10)")
    arguments = parser.parse_args()
    for path in PAGES:
        path.write_text(renewed(path.read_text(), arguments.tables or TABLES, arguments.seconds))


if __name__ == "__main__":
    main()
