"""Explicit, symbolic and local side by side on growing missions, each until it gives up.

Usage: ``python experiments/counts/composition.py [--sections N...] [--hardware N...] [-o FOLDER]``

Ulysse first, every way in one process. Then the sweep: each run has a process, 20 s and 4 GiB of its own.
Explicit builds the markings graph and reduces it, direct runs to completion with its proof, symbolic
reaches the markings as a diagram, local explores each type of section on its own; local gives every verdict
and the exact sizes of the whole. An engine that has given up on a mission is not asked for a longer one.
Sections of the last part use much hardware each, up to 24 resources, so that their interface states are
diagrams. It takes some eight minutes on two cores with its defaults. With ``-o`` the numbers go to
``composition.csv`` and a plot (needs ``mcpn[experiments]``) to ``composition.svg`` in that folder.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.shared import plots
from experiments.shared.limits import Result, measured
from experiments.shared.missions import Parameters, generate
from mcpn import __version__
from mcpn.answers.verdicts.mission import check
from mcpn.composite.composing import composite_space
from mcpn.composite.composite import CompositeSpace
from mcpn.controller.generate import generate as generate_controller
from mcpn.controller.hierarchy import flat_controller
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.report.pictures.plots import Curves
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction, direct, direct_with_proof

GIB = 4
ENGINES = ("explicit", "direct", "symbolic", "local")


def run_engine(engine: str, mission: Mission) -> Result:
    """What one engine finds: sizes as far as it gives them."""
    mission_net = compose(mission)
    if engine == "explicit":
        return {"stable": by_reduction(explore(mission_net.net, max_memory=GIB << 30)).states}
    if engine == "direct":
        return {"stable": direct_with_proof(mission_net.net).states}
    if engine == "symbolic":
        space = reach(mission_net.net)
        assert space.stable is not None
        return {"stable": space.stable.count(), "markings": space.states}
    found = check(mission_net, engine="local")
    composite = found.alternatives
    assert isinstance(composite, CompositeSpace), {n: v.explanation for n, v in found.verdicts.items()}
    types = {placed.type for placed in composite.sections.values()}
    carried = (stage.type.carried for stage in composite.sections.values())
    most = max(sum(kind == "hardware" for kind, _ in of) for of in carried)
    local = sum(type_.inside.count() >> len(composite.layout.all_slots) for type_ in types)
    return {"stable": composite.everything.count(), "local": local, "types": len(types), "most": most}


def show(value: Result | None, key: str, form: Callable[[Any], str] = str) -> str:
    """A cell of the table."""
    if value is None:
        return ""
    return form(value[key]) if key in value else ("-" if "gave_up" in value else "")


def row(label: str, mission: Mission, gone: set[str], limit: float) -> dict[str, Result]:
    """Measures the engines that have not given up, prints a line, and checks that they agree."""
    results: dict[str, Result] = {}
    for engine in ENGINES:
        if engine not in gone:
            results[engine] = measured(run_engine, engine, mission, seconds=limit, gib=GIB)
            if "gave_up" in results[engine]:
                gone.add(engine)
    sizes = {r["stable"] for r in results.values() if "stable" in r}
    assert len(sizes) <= 1, f"the engines disagree: {results}"
    seconds = " ".join(f"{show(results.get(e), 'seconds', '{:.2f}'.format):>9}" for e in ENGINES)
    memory = " ".join(f"{show(results.get(e), 'megabytes'):>8}" for e in ENGINES)
    local = results.get("local", {})
    explored = (
        f"{local.get('types', '')} types, most hw {local.get('most', '')}, {local.get('local', '')} local"
    )
    stable = sizes.pop() if sizes else "?"
    print(f"{label:>22} {seconds} | {memory} | {explored}; stable states: {stable}", flush=True)
    return results


def ulysse() -> None:
    """Every way to the alternatives graph of Ulysse, in one run, and the sizes of its controllers."""
    mission_net = compose(read_mission(Path(__file__).parents[1] / "ulysse" / "mission.xml"))
    net = mission_net.net

    def local() -> tuple[int, int]:
        space = composite_space(mission_net)
        return space.everything.count(), sum(space.firings(space.everything).values())

    def sizes_of(graph: AlternativesGraph) -> tuple[int, int]:
        return graph.states, graph.edges

    ways: dict[str, Callable[[], tuple[int, int]]] = {
        "reduction": lambda: sizes_of(by_reduction(explore(net))),
        "direct, with proof": lambda: sizes_of(direct_with_proof(net)),
        "direct, without": lambda: sizes_of(direct(net, proof=False)),
        "local": local,
    }
    seconds: dict[str, float] = {}
    for name, way in ways.items():
        times = []
        for _ in range(7):
            started = time.process_time()
            sizes = way()
            times.append(time.process_time() - started)
        seconds[name] = sorted(times)[3]
        ratio = seconds["reduction"] / seconds[name]
        print(f"ulysse, {name:18} {sizes[0]} states, {sizes[1]} edges, {seconds[name]:.4f} s, {ratio:6.1f} x")
    for controller in (flat_controller(mission_net, direct(net)), generate_controller(mission_net)):
        print(f"ulysse, {controller.form} controller: {controller.size}")


def save(sweeps: dict[str, dict[str, list[tuple[int, float]]]], folder: Path) -> None:
    """Writes the CSV, and the plot: seconds against sections, each sweep on its own."""
    lines = [
        {"sweep": sweep, "engine": engine, "sections": sections, "seconds": seconds}
        for sweep, engines in sweeps.items()
        for engine, points in engines.items()
        for sections, seconds in points
    ]
    curves = [Curves(name, "sections", "CPU seconds", engines) for name, engines in sweeps.items()]
    plots.save(folder, "composition", lines, curves)


def overtakes(points: dict[str, list[tuple[int, float]]]) -> None:
    """Says from which number of sections on local is faster than each of the others."""
    local = dict(points["local"])
    for engine in ENGINES[:-1]:
        times = dict(points[engine])
        slower = [n for n in sorted(local) if n not in times or times[n] > local[n]]
        ahead = [n for n in slower if all(m in slower for m in local if m >= n)]
        print(f"{'':22} local overtakes {engine} at {ahead[0] if ahead else 'no size'}", flush=True)


def sweep(label: str, missions: dict[int, Mission], limit: float) -> dict[str, list[tuple[int, float]]]:
    """One line for each mission, by its number of sections."""
    gone: set[str] = set()
    points: dict[str, list[tuple[int, float]]] = {engine: [] for engine in ENGINES}
    for sections, mission in missions.items():
        results = row(f"{sections} sections, {label}", mission, gone, limit)
        for engine, result in results.items():
            if "seconds" in result:
                points[engine].append((sections, result["seconds"]))
    overtakes(points)
    return points


def main() -> None:
    """Ulysse first, then the sweep."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sections", type=int, nargs="+", default=[5, 10, 50, 100, 500, 1000])
    parser.add_argument("--hardware", type=int, nargs="+", default=[3, 6, 12, 30])
    parser.add_argument("--types", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=20, help="limit of each run (default 20)")
    arguments = plots.parsed(parser, "composition")
    machine = f"{platform.machine()}, Python {platform.python_version()}, mcpn {__version__}"
    print(f"{machine}; {arguments.seconds:g} s, {GIB} GiB")
    ulysse()
    heads = " ".join(f"{engine:>9}" for engine in ENGINES)
    print(f"{'':22} {heads} s| {' '.join(f'{engine:>8}' for engine in ENGINES)} MB")

    def some(sections: int, hardware: int, **more: int | float) -> Mission:
        return generate(Parameters(sections, min(arguments.types, sections), hardware, **more))  # type: ignore[arg-type]

    sweeps: dict[str, dict[str, list[tuple[int, float]]]] = {}
    for hardware in arguments.hardware:
        missions = {n: some(n, hardware, per_section=min(4, hardware)) for n in arguments.sections}
        sweeps[f"{hardware} hardware resources"] = sweep(f"{hardware} hw", missions, arguments.seconds)
    wide = {n: some(n, 30, per_section=12, alternatives=8, parallel=0.5) for n in arguments.sections}
    sweeps["wide sections"] = sweep("wide", wide, arguments.seconds)
    if arguments.output:
        save(sweeps, arguments.output)


if __name__ == "__main__":
    sys.exit(main())
