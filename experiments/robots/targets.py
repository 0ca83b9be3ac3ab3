"""Which forms and targets the controllers of missions have, and why not all: the table of docs/controller.md.

    python experiments/robots/targets.py [MISSION ...]

Takes about a minute.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Literal

from mcpn.controller.document import document
from mcpn.errors import McpnError
from mcpn.robot.targets import TARGETS, files
from mcpn.study import open_study

FORMS: tuple[Literal["hierarchical", "modular", "flat"], ...] = ("hierarchical", "modular", "flat")
MOST_STATES = 50_000
EXAMPLES = Path(__file__).parents[1]


def answer(path: Path, form: Literal["hierarchical", "modular", "flat"]) -> str:
    """The targets of a form, and why it has not all of them, or none."""
    study = open_study(path)
    try:
        controller = study.controller(form, max_states=MOST_STATES)
    except McpnError as error:
        first, _, _ = str(error).partition("\n")
        return f"none: {first}"
    found, why = [], []
    for target in TARGETS:
        try:
            files(document(controller, study.mission_net), target)
        except McpnError as error:
            why.append(f"{target}: {error}")
        else:
            found.append(target)
    return "; ".join((", ".join(found), *why))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("missions", nargs="*", type=Path, help="by default those of this folder")
    paths = parser.parse_args().missions or sorted(
        (*EXAMPLES.glob("*/mission.xml"), *EXAMPLES.glob("roscon/problem*.xml"))
    )
    print(f"| mission | {' | '.join(FORMS)} |\n|---|{'---|' * len(FORMS)}")
    for path in paths:
        name = path.parent.name if path.stem == "mission" else path.stem
        print(f"| {name} | {' | '.join(answer(path, form) for form in FORMS)} |", flush=True)


if __name__ == "__main__":
    main()
