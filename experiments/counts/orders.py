"""What the proof along with listing stable states costs, and what decides each edge; about two minutes.

Usage: ``python experiments/counts/orders.py [--seconds S]``

The growing missions of ``growth.py`` and the worked missions. Each is listed three times: along
one run behind each event, without proof; in enough orders of internal transitions to prove that all have one
end (stubborn sets, ``papers/mcpn.md``, Proposition 3); and in every order, each transient marking once, as
the proof did before. An edge counts for the last means that a marking on its way needed. CPU milliseconds in
the kernel, and how many transient markings are kept.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import get_args

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.growth.growth import FAMILIES
from experiments.shared.limits import Result, measured
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.run_to_completion import Orders, settled

SIZES = {
    "ladder": (10, 30),
    "producers": (4, 8, 10),
    "share": (2, 4),
    "drivers": (2, 3),
    "sites": (5,),
    "branches": (3,),
    "data": (8,),
}
HEADS = (
    "mission",
    "stable states",
    "edges",
    "one at a time",
    "no arcs conflict",
    "units exclude",
    "out of reach",
    "every way tried",
    "kept in enough orders",
    "kept in every order",
    "units, CPU ms",
    "tables, CPU ms",
    "one run, CPU ms",
    "enough orders, CPU ms",
    "every order, CPU ms",
)
MOST = 1_000_000
"""Stable states that a mission may have."""


def nets() -> Iterator[tuple[str, PetriNet]]:
    """Each mission's name and net."""
    for path in sorted(Path(__file__).parents[1].glob("*/mission.xml")):
        yield path.parent.name, compose(read_mission(path)).net
    for family, sizes in SIZES.items():
        for size in sizes:
            yield f"{family} {size}", compose(FAMILIES[family][0](size)).net


def listed(net: PetriNet, orders: Orders) -> Result:
    """Sizes of what is found, and the CPU milliseconds it took."""
    prepared = KernelNet(net)
    begin = time.process_time() if prepared.kernel else 0
    found = settled(prepared, orders=orders, max_states=MOST)
    spent = time.process_time() - begin
    return {
        "states": found.states,
        "edges": found.edges,
        "decided": found.decided,
        "cost": f"{1000 * spent:.1f}",
        "kept": found.transient,
        "end": found.trouble[2] if found.trouble else "confluent",
    }


def prepared_in(net: PetriNet) -> tuple[str, str]:
    """CPU milliseconds for what is done once for a net: finding units, and all tables of the proof beside."""
    prepared = KernelNet(net)
    begin = time.process_time() if prepared.kernel else 0
    prepared.kernel.units(prepared.initial)
    units = time.process_time() - begin
    begin = time.process_time()
    with suppress(LimitError):
        settled(prepared, orders="enough", max_states=1)  # ends at the second state
    return f"{1000 * units:.1f}", f"{1000 * max(0, time.process_time() - begin - units):.1f}"


def rows(seconds: float, wanted: Callable[[str], bool] = lambda _: True) -> Iterator[tuple[object, ...]]:
    """What each mission costs, and what decides its edges.

    Args:
        seconds: For each listing.
        wanted: Says of the name of a mission whether it is asked of.
    """
    for name, net in nets():
        if not wanted(name):
            continue
        one, enough, every = (measured(listed, net, o, seconds=seconds) for o in get_args(Orders))
        ends = {found["end"] for found in (enough, every) if "end" in found}
        assert len(ends) <= 1, "one verdict"
        edges = enough.get("edges", "-")
        decided = enough.get("decided", ["-"] * 5)
        assert edges == "-" or sum(decided) == edges
        kept = (enough.get("kept", "-"), every.get("kept", "-"))
        costs = (of.get("cost", "-") for of in (one, enough, every))
        yield (name, enough.get("states", "-"), edges, *decided, *kept, *prepared_in(net), *costs)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5, help="for each listing (default 5)")
    options = parser.parse_args()
    begin = time.monotonic()
    print(f"| {' | '.join(HEADS)} |")
    print("|---" * len(HEADS) + "|")
    for row in rows(options.seconds):
        print(f"| {' | '.join(map(str, row))} |", flush=True)
    print(f"{time.monotonic() - begin:.0f} s; CPython {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
