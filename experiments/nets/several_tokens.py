"""Nets with several tokens in a place, marking by marking and as a diagram: counts and processor seconds.

Usage: ``python experiments/nets/several_tokens.py [--most-states N] [--seconds S]``

*Kanban* and *FMS* are the systems of G. Ciardo and M. Tilgner (ICASE report 96-35, 1996), with N cards in
each cell and N parts of each kind; in a *token ring* N tokens go round N places. Counts that differ from the
closed forms of ``mcpn.testing.nets``, or between engines, end the script.
Each run has a process of its own; the explicit engine is asked up to a number of markings. It takes about
half a minute.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

import mcpn
from experiments.shared.limits import Result, measured
from mcpn.spaces.sizes import summarise
from mcpn.testing.nets import FAMILIES

SIZES = {
    "kanban": (1, 2, 3, 4, 5, 6, 10, 20, 50, 100),
    "fms": (1, 2, 3, 4, 5, 6, 10, 20, 50),
    "token_ring": (5, 8, 10, 11, 12, 20, 50),
}


def find(engine: str, family: str, number: int) -> Result:
    """The counts of one net by one engine, and its seconds of the processors."""
    net = FAMILIES[family].net(number)
    started = time.process_time()
    found = summarise(net, engine)
    return {
        "cpu": time.process_time() - started,
        "counts": (found.states, found.edges, found.dead_states, found.max_tokens, found.max_tokens_in_place),
        "nodes": found.nodes,
    }


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--most-states", type=int, default=3_000_000, help="what the explicit engine is asked"
    )
    parser.add_argument("--seconds", type=float, default=60, help="limit of each run")
    options = parser.parse_args()
    print(f"{'net':12}{'markings':>27}{'edges':>28}{'nodes':>8}{'symbolic':>10}{'explicit':>10}  CPU seconds")
    for family, sizes in SIZES.items():
        for number in sizes:
            found = measured(find, "symbolic", family, number, seconds=options.seconds)
            if "gave_up" in found:
                print(f"{family} {number}: {found['gave_up']}", flush=True)
                continue
            states, edges, *_ = found["counts"]
            known = FAMILIES[family].markings(number)
            assert states == known, f"{family} {number} has {states} markings, not {known}"
            name, explicit = f"{family}-{number}", "-"
            if states <= options.most_states:
                listed = measured(find, "explicit", family, number, seconds=options.seconds)
                explicit = listed.get("gave_up") or f"{listed['cpu']:.2f}"
                assert listed.get("counts", found["counts"]) == found["counts"], (
                    f"{family} {number}: {listed}"
                )
            name = f"{family}-{number}"
            print(
                f"{name:12}{_short(states):>27}{_short(edges):>28}{found['nodes']:8}"
                f"{found['cpu']:10.2f}{explicit:>10}",
                flush=True,
            )
    print(f"mcpn {mcpn.__version__}, Python {platform.python_version()}, {platform.machine()}")


def _short(count: int) -> str:
    return f"{count:,}" if count < 10**18 else f"{count:.3e}"


if __name__ == "__main__":
    main()
