"""Faults seeded in templates, and which of them the checkers of certificates refute.

Run: python experiments/faults/certified_faults.py [--draws N] [--seed S] [WORDS...] (some ten minutes)

Each fault of ``template_faults.py`` draws nets of drawn missions, N of each strategy. Where the net is not as
that of the right templates, it is *refused*, since certcheck finds it not safe or not confluent; or
certcheck proves claims of a wrong net, which corecheck has *refuted*, walking it beside the core mission, or
*accepted*. Faults that make no difference to the runs of a mission are accepted rightly.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from hypothesis import HealthCheck, Phase, given, seed, settings

from experiments.faults.template_faults import BY_ELEMENT, Fault, Faulty
from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import McpnError
from mcpn.mission.model import Mission
from mcpn.testing import elements

BY_KIND = {
    "late loss": ["LATE", "LATE_APART"],
    "facts": ["WORLD", "WORLD_APART", "GUARDED"],
    "crashes": ["CRASHING", "CRASHING_APART"],
    "timeout": ["TIMED", "PAUSING_IN_TIME"],
    "handlers, once": ["INTERRUPTED", "PAUSING_APART"],
    "abort, early ends": ["EARLY", "ABORTED", "ENDS_AT_ONCE"],
    "guards, recovery, rounds": ["GUARDED", "RECOVERING"],
    "shared producers": ["SHARING", "SHARING_FACTS"],
    "pause": ["PAUSING", "PAUSING_APART"],
}
"""By kind of element the strategies that have it; the others are drawn from ``ANY`` and ``MIXED``."""
MOST = 20_000


def outcome(mission: Mission, fault: Fault) -> str:
    """What the checkers say of the net that faulty templates draw of a mission."""
    templates = Faulty(*fault)
    try:
        net = compose(mission, templates)
        return "same" if not templates.changed else _judged(net)
    except (McpnError, ValueError):  # ValueError: no place says that the mission has not begun
        return "not drawn"


def _judged(net: MissionNet) -> str:
    read = certcheck.Net(json.loads(json.dumps(net_entry(net))))
    mission = corecheck.CoreMission(json.loads(json.dumps(core_entry(net))))
    how = "refused"
    try:
        graph, how = certcheck.Listing(read, MOST, float("inf")), "refuted"
        corecheck.walked(graph, mission)
    except certcheck.Refuted:
        return how
    except certcheck.Limit:
        return "too large"
    return "accepted"


def judged(element: str, fault: Fault, draws: int, start: int) -> Counter[str]:
    """How often the net of a drawn mission is the same, refused, refuted or accepted."""
    found = Counter[str]()
    for name in BY_KIND.get(element, ["ANY", "MIXED"]):

        @seed(start)
        @settings(
            max_examples=draws,
            deadline=None,
            database=None,
            suppress_health_check=list(HealthCheck),
            phases=[Phase.generate],
        )
        @given(getattr(elements, name))
        def draw(mission: Mission) -> None:
            found[outcome(mission, fault)] += 1

        draw()
    return found


def rows(words: list[str]) -> Iterator[tuple[str, str, Fault]]:
    """The faults whose element or name has one of some words; all where none is given."""
    for element, faults in BY_ELEMENT.items():
        for name, fault in faults.items():
            if not words or any(word in f"{element} {name}" for word in words):
                yield element, name, fault


def main() -> None:
    """Prints a row for each fault, then how many corecheck alone refutes."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("words", nargs="*")
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    words = ["refused", "refuted", "accepted"]
    print(f"| element | fault | nets | {' | '.join(words)} |\n|---|---|---|---|---|---|")
    caught = Counter[str]()
    for element, name, fault in rows(asked.words):
        found = judged(element, fault, asked.draws, asked.seed)
        drawn = sum(found[word] for word in words)
        print(f"| {element} | {name} | {drawn} | {' | '.join(str(found[w]) for w in words)} |", flush=True)
        caught[
            "refuted by corecheck" if found["refuted"] else "refused" if found["refused"] else "never"
        ] += 1
    print(", ".join(f"{count} {how}" for how, count in caught.items()))


if __name__ == "__main__":
    main()
