"""Compares the coverage of lines and branches, by room, with the figures that the repository keeps.

``python .ci/coverage.py FOUND.json`` reads what ``slipcover --branch --json`` wrote and prints a line for
each room of the package; it ends with 1 if a figure fell by more than a tenth of a percent. ``--write`` keeps
the new figures.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

KEPT = Path(__file__).with_name("coverage.json")
SLACK = 0.1
"""Percent by which a figure may fall: some lines run only where a race of engines ends in one way."""

Figures = dict[str, dict[str, float]]


def by_room(found: Mapping[str, Any]) -> Figures:
    """Percent of the lines and of the branches that ran, by room.

    Args:
        found: What ``slipcover --branch --json`` says.
    """
    counts: dict[str, list[int]] = {}
    for name, of in found["files"].items():
        parts = PurePosixPath(name).parts
        inside = parts[len(parts) - parts[::-1].index("mcpn") :]
        room = inside[0] if len(inside) > 1 else "mcpn"
        said = of["summary"]
        known = counts.setdefault(room, [0, 0, 0, 0])
        for number, of_what in enumerate(("lines", "branches")):
            known[2 * number] += said[f"covered_{of_what}"]
            known[2 * number + 1] += said[f"covered_{of_what}"] + said[f"missing_{of_what}"]
    return {
        room: {"lines": percent(lines, statements), "branches": percent(taken, branches)}
        for room, (lines, statements, taken, branches) in sorted(counts.items())
    }


def percent(part: int, whole: int) -> float:
    """With one decimal; of nothing, all."""
    return round(100 * part / whole, 1) if whole else 100.0


def fallen(kept: Figures, found: Figures) -> list[str]:
    """What is lower than it was, in sentences."""
    return [
        f"{room}: {what} fell from {before} to {found[room][what]} percent"
        for room, figures in kept.items()
        if room in found
        for what, before in figures.items()
        if found[room][what] < before - SLACK
    ]


def main() -> int:
    """Prints the figures, then what fell."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("found", type=Path)
    parser.add_argument("--write", action="store_true", help="keep the new figures")
    given = parser.parse_args()
    found = by_room(json.loads(given.found.read_text()))
    for room, figures in found.items():
        print(f"{room:12} lines {figures['lines']:5.1f} %, branches {figures['branches']:5.1f} %")
    if given.write:
        KEPT.write_text(json.dumps(found, indent=2) + "\n")
        return 0
    if not KEPT.exists():
        print("no figures are kept yet: --write keeps these")
        return 0
    worse = fallen(json.loads(KEPT.read_text()), found)
    print(*worse, sep="\n", end="\n" if worse else "")
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
