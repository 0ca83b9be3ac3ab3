"""Every table of papers/mcpn.md, measured and written anew.

Usage: ``python experiments/paper.py [TABLE...] [--seconds S]``

Each table stands in the page between ``<!-- measured: TABLE -->`` and ``<!-- end -->``; without arguments all
are renewed. Engines that do not end within S seconds (default 10; long missions six times that) are marked
``-``. It takes some eleven minutes on two cores with its defaults. ``sizes`` and ``controllers`` hold counts
alone, which are the same on every machine.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import sys
from collections.abc import Callable, Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import explicit_vs_symbolic
import orders
import proofs as ways_of_proof
import table1
from causes import in_a_chain, in_a_row
from composition import run_engine
from limits import Result, measured
from missions import Parameters, generate

from mcpn import __version__
from mcpn.answers.causes.find import find_causes
from mcpn.controller.generate import Form
from mcpn.controller.generate import generate as generate_controller
from mcpn.controller.minimise import minimise
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission

PAGE = Path(__file__).parents[1] / "papers" / "mcpn.md"
BLOCK = re.compile(r"(<!-- measured: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def markdown(heads: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A table in Markdown."""
    names = list(heads)
    lines = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def machine(_: float) -> str:
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


def sizes(_: float) -> str:
    """The counts of Table 1."""
    return markdown(("Ulysse", "TAROS 2017, Table 1", "mcpn"), table1.counts())


def times(_: float) -> str:
    """The seconds of Table 1."""
    return markdown(("Ulysse, seconds", "TAROS 2017, Table 1", "mcpn"), table1.seconds(3))


def proofs(seconds: float) -> str:
    """What each way of the proof decides of sections, and what it leaves."""
    return markdown(ways_of_proof.HEADS, ways_of_proof.rows(200, 1, seconds / 2))


def ways(seconds: float) -> str:
    """What decides that events have one outcome."""
    return markdown(orders.HEADS, orders.rows(seconds))


def growth(seconds: float) -> str:
    """Explicit against symbolic."""
    return explicit_vs_symbolic.table(list(explicit_vs_symbolic.measure(6, seconds)))


def sections(seconds: float) -> str:
    """Composition on long missions."""
    rows = []
    for number in (10, 100, 1000):
        mission = generate(Parameters(number, min(20, number), 30, per_section=4))
        found = {
            e: measured(run_engine, e, mission, seconds=6 * seconds) for e in ("direct", "symbolic", "local")
        }
        told = [f"{f['seconds']:.1f}" if "seconds" in f else "-" for f in found.values()]
        local = found["local"]
        rows.append((number, *(local.get(key, "-") for key in ("types", "most", "local", "stable")), *told))
    heads = ("sections", "types", "most hardware of a section", "local states", "stable states of the whole")
    return markdown((*heads, "direct, s", "symbolic, s", "local, s"), rows)


def _causes(engine: str, shape: Callable[[int, int], Mission], parts: int) -> Result:
    causes = find_causes(compose(shape(parts, 3)), engine=engine)
    return {"cut_sets": len(causes.mission.cut_sets)}


def causes(seconds: float) -> str:
    """Failure causes on redundant missions; cut sets against their closed form."""
    rows = []
    for shape, numbers in ((in_a_row, (2, 3, 10, 20)), (in_a_chain, (2, 3, 6))):
        for parts in numbers:
            whole = measured(_causes, "explicit", shape, parts, seconds=seconds)
            local = measured(_causes, "local", shape, parts, seconds=6 * seconds)
            for found in (whole, local):
                assert found.get("cut_sets", parts) == parts, "each part with its three ways is a cut set"
            told = [f"{f['seconds']:.2f}" if "seconds" in f else "-" for f in (whole, local)]
            rows.append((f"{shape.__name__.replace('_', ' ')} of {parts}", 3 * parts, parts, 3**parts, *told))
    heads = ("mission", "hardware", "cut sets", "path sets", "whole graph, s", "composition, s")
    return markdown(heads, rows)


def controllers(_: float) -> str:
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


TABLES: dict[str, Callable[[float], str]] = {
    made.__name__: made
    for made in (machine, sizes, times, ways, proofs, growth, sections, causes, controllers)
}


def renewed(page: str, wanted: Iterable[str], seconds: float) -> str:
    """The page with some of its tables measured anew."""
    chosen = set(wanted)

    def write(match: re.Match[str]) -> str:
        if match[2] not in chosen:
            return match[0]
        print(f"{match[2]} ...", file=sys.stderr, flush=True)
        return f"{match[1]}{TABLES[match[2]](seconds)}\n{match[3]}"

    return BLOCK.sub(write, page)


def main() -> None:
    """Renews the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tables", nargs="*", choices=[[], *TABLES], default=[], metavar="TABLE")
    parser.add_argument("--seconds", type=float, default=10, help="limit of small runs (default 10)")
    arguments = parser.parse_args()
    PAGE.write_text(renewed(PAGE.read_text(), arguments.tables or TABLES, arguments.seconds))


if __name__ == "__main__":
    main()
