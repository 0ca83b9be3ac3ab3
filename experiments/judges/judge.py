"""Drawn missions: an interpreter that draws no net beside every engine, the simulator and every controller.

Usage: ``python experiments/judges/judge.py [--missions N] [--seed S] [--jobs N] [--show N] [--of NAME]
[--unseen FIELD ...]``

The interpreter (``mcpn.testing.judge``) is made from the language page alone. In every reachable pair of
states are compared: what runs with which alternative, what waits, what is refused, hardware out of service,
running objectives, branches that have ended, the end of the mission, possible events, and the parameters
given. ``--of`` names a strategy of ``mcpn.testing.elements``. A mission that is not as the interpreter says
is printed, with the run that shows it. At the end it says how many missions, states, pairs and disagreements
there were, by kind; with a disagreement the exit code is 1.
With its defaults it takes some three minutes.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from hypothesis.strategies import SearchStrategy

from experiments.shared.drawing import drawn
from mcpn.mission.writer import write_mission
from mcpn.testing import elements
from mcpn.testing.judge.lockstep import Mismatch
from tests.judge.lockstep import Judge

SHARE = 100
"""Missions that one process draws at a time, from a seed of their own."""

STRATEGIES = [name for name, value in vars(elements).items() if isinstance(value, SearchStrategy)]


@dataclass
class Found:
    """What some missions showed.

    Args:
        kinds: How many missions, by kind; disagreements by what differs.
        states: Stable states of the interpreter.
        pairs: Pairs of states that were compared, by who was.
        shown: Missions that disagree, with the run, by kind.
        first: By kind of disagreement, how many missions had been drawn when it was first found.
    """

    kinds: Counter[str] = field(default_factory=Counter)
    states: int = 0
    pairs: Counter[str] = field(default_factory=Counter)
    shown: list[tuple[str, str]] = field(default_factory=list)
    first: dict[str, int] = field(default_factory=dict)

    def add(self, other: Found) -> None:
        """Adds what later missions showed."""
        drawn = self.kinds.total()
        for kind, number in other.first.items():
            self.first.setdefault(kind, drawn + number)
        self.kinds += other.kinds
        self.states += other.states
        self.pairs += other.pairs
        self.shown += other.shown


def judged(number: int, seed: int, unseen: tuple[str, ...], of: str) -> Found:
    """Draws missions and judges each."""
    found = Found()

    for mission in drawn(getattr(elements, of), number, seed):
        try:
            verdict = Judge(mission, unseen).judge()
        except Mismatch as error:
            kind = f"disagreement: {error.kind}"
            found.kinds[kind] += 1
            found.first.setdefault(kind, found.kinds.total())
            found.shown.append((kind, f"{write_mission(mission).decode()}{error}\n"))
        else:
            found.kinds[verdict.kind] += 1
            found.states += verdict.states
            found.pairs += verdict.pairs
    return found


def main() -> int:
    """Runs the campaign."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--missions", type=int, default=2000, help="how many are drawn (default 2000)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default 1)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--show", type=int, default=1, help="missions printed of each kind of disagreement")
    parser.add_argument("--of", default="WIDEST", choices=STRATEGIES, help="what is drawn (default all)")
    parser.add_argument("--unseen", nargs="*", default=[], help="what is not compared, such as waiting")
    arguments = parser.parse_args()
    began, found, shown = time.monotonic(), Found(), Counter[str]()
    shares = [
        (
            min(SHARE, arguments.missions - i),
            arguments.seed * 1_000_003 + i,
            tuple(arguments.unseen),
            arguments.of,
        )
        for i in range(0, arguments.missions, SHARE)
    ]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for share in pool.map(judged, *zip(*shares, strict=True)):
            found.add(share)
            for kind, text in share.shown:
                shown[kind] += 1
                if shown[kind] <= arguments.show:
                    print(f"{kind}\n{text}", flush=True)
    took = time.monotonic() - began
    print(
        f"{found.kinds.total()} missions, {found.states} states, {found.pairs.total()} pairs in {took:.0f} s"
    )
    for kind, number in sorted(found.kinds.items()):
        first = f", first after {found.first[kind]} missions" if kind in found.first else ""
        print(f"  {number} {kind}{first}")
    for who, pairs in found.pairs.items():
        print(f"  {pairs} pairs with the {who}")
    return 1 if found.first else 0


if __name__ == "__main__":
    sys.exit(main())
