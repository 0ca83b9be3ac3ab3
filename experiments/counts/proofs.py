"""What each way of the proof that events have one outcome decides, section by section, and what it leaves.

Usage: ``python experiments/counts/proofs.py [--missions N] [--seed S] [--seconds S]``

Members of the families of ``growth.py`` that can be listed, the worked missions, and missions
drawn as those for ``judge.py``. Of each the local net of each type of section is asked in three ways:
stable states are listed in enough orders, and a section counts for the last means that an edge of it needed
(as in ``orders.py``); big steps are found, without listing; and the diagram of all markings is asked for
conflicts (Propositions 3, 4 and 5, and 1 and 2 of ``papers/mcpn.md``). *Two outcomes* are sections of which
a run to an event with two ends is known: there is nothing to be proved. What is *left* after the given
seconds is undecided. CPU milliseconds. With its defaults it takes some four minutes.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.growth.growth import FAMILIES
from experiments.shared.drawing import drawn
from experiments.shared.limits import Result, measured
from mcpn.composite.explored_section import Explored, explore_local
from mcpn.drawing.compose import compose
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.sections import SectionParts
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.run_to_completion import settled
from mcpn.testing.elements import MISSIONS

MEANS = ("one at a time", "no arcs conflict", "units exclude", "out of reach", "every way tried")
TWO = "two outcomes"
LEFT = "left"
"""Undecided."""
SIZES = {"ladder": 30, "producers": 8, "share": 5, "drivers": 4, "sites": 5, "hardware": 8, "data": 8}
MOST = 500_000
"""Stable states that are listed of a section."""
HEADS = (
    "set",
    "missions",
    "sections",
    *MEANS,
    TWO,
    "left by listing",
    "proved by big steps",
    "left by these",
    "proved by the diagram",
    "left by it",
    "listing, CPU ms",
    "big steps, CPU ms",
    "the diagram, CPU ms",
)


def sets(number: int, seed: int) -> Iterator[tuple[str, Callable[[], list[Mission]]]]:
    """What makes the missions, by name of the set."""
    for family, size in SIZES.items():
        yield f"{family} {size}", partial(lambda made, size: [made(size)], FAMILIES[family][0], size)
    beside = sorted(Path(__file__).parents[1].glob("*/mission.xml"))
    yield "worked", lambda: [read_mission(path) for path in beside]
    yield "drawn", lambda: drawn(MISSIONS, number, seed)


def sections(mission: Mission) -> list[PetriNet]:
    """The local nets of a mission's sections, one of each type."""
    found = compose(mission)
    alone = SectionParts(found.usage).alone
    parts = {(part := alone(section)).type: part for section in found.graph.sections}
    return [local_net(part).net for part in parts.values()]


def listed(net: PetriNet) -> Result:
    """The last means that listing in enough orders needed."""
    prepared = KernelNet(net)
    begin = time.process_time()
    found = settled(prepared, orders="enough", max_states=MOST)
    last = max((i for i, edges in enumerate(found.decided) if edges), default=0)
    return {"by": TWO if found.trouble else MEANS[last], "ms": 1000 * (time.process_time() - begin)}


def in_big_steps(net: PetriNet) -> Result:
    """Whether big steps are found, and prove it."""
    begin = time.process_time()
    found = explore_local(net).steps is not None
    return {"by": "proved" if found else "not", "ms": 1000 * (time.process_time() - begin)}


def by_diagram(net: PetriNet) -> Result:
    """Whether the diagram of all markings proves it."""
    begin = time.process_time()
    found = Explored(reach(net))
    proved = found.ends and not found.conflicts
    return {"by": "proved" if proved else "not", "ms": 1000 * (time.process_time() - begin)}


def rows(
    number: int, seed: int, seconds: float, wanted: Callable[[str], bool] = lambda _: True
) -> Iterator[tuple[object, ...]]:
    """What the ways decide of each set of missions, and what they take.

    Args:
        number: Of drawn missions.
        seed: Of these.
        seconds: For each section and way.
        wanted: Says of the name of a set whether it is asked of.
    """
    for name, made in sets(number, seed):
        if not wanted(name):
            continue
        missions = made()
        nets = [net for mission in missions for net in sections(mission)]
        parted, row, costs = set[int](), list[object](), list[str]()
        for way in (listed, in_big_steps, by_diagram):
            counts, spent = Counter[str](), 0.0
            for i, net in enumerate(nets):
                found = measured(way, net, seconds=seconds)
                by = found.get("by", LEFT)
                if by == TWO:
                    parted.add(i)
                if by == "not":
                    by = TWO if i in parted else LEFT
                counts[by] += 1
                spent += found.get("ms", 1000 * seconds)
            shown = (*MEANS, TWO, LEFT) if way is listed else ("proved", LEFT)
            row += [counts[by] for by in shown]
            costs.append(f"{spent:.0f}")
        yield (name, len(missions), len(nets), *row, *costs)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--missions", type=int, default=200, help="drawn (default 200)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=5, help="for each section and way (default 5)")
    options = parser.parse_args()
    print(f"| {' | '.join(HEADS)} |\n{'|---' * len(HEADS)}|")
    for row in rows(options.missions, options.seed, options.seconds):
        print(f"| {' | '.join(map(str, row))} |", flush=True)


if __name__ == "__main__":
    main()
