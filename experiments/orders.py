"""What the proof along with listing stable states costs, and how many orders it tries; about three minutes.

Usage: ``python experiments/orders.py [--seconds S]``

The growing missions of ``growth.py`` and the missions beside these scripts. Each is listed three times: along
one run behind each event, without proof; in enough orders of internal transitions to prove that all have one
end (stubborn sets, ``papers/mcpn.md``, Proposition 3); and in every order, each transient marking once, as
the proof did before. CPU seconds in the kernel, how many transient markings are kept, and how many are left
in all ways.
"""

from __future__ import annotations

import argparse
import platform
import time
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from growth import FAMILIES
from limits import Result, measured

from mcpn.mission.xml import read_mission
from mcpn.net.compose import compose
from mcpn.net.petri import PetriNet
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.stable.settling import Orders, settled

SIZES = {
    "ladder": (6, 10, 30),
    "producers": (4, 6, 8),
    "share": (2, 4, 5),
    "drivers": (2, 3, 5),
    "sites": (5, 20),
    "branches": (2, 3),
    "data": (5, 8, 10),
}
MOST = 1_000_000
"""Stable states that a mission may have."""


def nets() -> Iterator[tuple[str, PetriNet]]:
    """Each mission's name and net."""
    for path in sorted(Path(__file__).parent.glob("*/mission.xml")):
        yield path.parent.name, compose(read_mission(path)).net
    for family, sizes in SIZES.items():
        for size in sizes:
            yield f"{family} {size}", compose(FAMILIES[family][0](size)).net


def listed(net: PetriNet, orders: Orders) -> Result:
    """Sizes of what is found, and the CPU seconds it took."""
    prepared = KernelNet(net)
    begin = time.process_time() if prepared.kernel else 0
    found = settled(prepared, orders=orders, max_states=MOST)
    spent = time.process_time() - begin
    end = found.trouble[2] if found.trouble else "confluent"
    return {"states": found.states, "kept": found.transient, "ways": found.parted, "cpu": spent, "end": end}


def said(found: Result) -> str:
    """The cells of one way to list."""
    return found.get("gave_up") or f"{found['cpu']:.3f}; {found['kept']}; {found['ways']}"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5, help="for each listing (default 5)")
    options = parser.parse_args()
    begin = time.monotonic()
    print(
        "| mission | stable states | one run, s | enough orders: s; kept; in all ways | "
        "every order: s; kept; in all ways |"
    )
    print("|---|---|---|---|---|")
    for name, net in nets():
        one, enough, every = (measured(listed, net, o, seconds=options.seconds) for o in get_args(Orders))
        states = one.get("states", "-")
        alone = one.get("gave_up") or f"{one['cpu']:.3f}"
        print(f"| {name} | {states} | {alone} | {said(enough)} | {said(every)} |", flush=True)
        ends = {found["end"] for found in (enough, every) if "end" in found}
        assert len(ends) <= 1, "one verdict"
    print(f"{time.monotonic() - begin:.0f} s; CPython {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
