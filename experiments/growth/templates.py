"""Two sets of templates, side by side: sizes of nets as missions grow, and what composing them costs.

Run: python experiments/growth/templates.py [--numbers N...] (10 seconds)

Three families of missions: a parallel block of N children; an alternative that consumes N resources, one of a
producer that may wait, so that requests are given up; an activity with N alternatives that returns to better
ones. Of each, places, transitions and CPU milliseconds of composing with the paper's templates and with the
compact ones (the best of three); ``-``: a limit of the template.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

from mcpn.drawing.compose import compose
from mcpn.drawing.templates import PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import LimitError
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.xml import read_mission

ULYSSE = Path(__file__).resolve().parents[1] / "ulysse" / "mission.xml"
SETS: dict[str, TemplateSet] = {
    "paper": PaperTemplates(),
    "compact": CompactTemplates(),
    "compact, nothing combined": CompactTemplates(at_once=0, combined=0),
}


def activity(
    name: str, *ways: tuple[str, ...], produces: tuple[str, ...] = (), back: bool = False
) -> Activity:
    """An activity by what its alternatives consume."""
    alternatives = tuple(Alternative(name=f"{name}{i}", consumes=way) for i, way in enumerate(ways))
    return Activity(name=name, alternatives=alternatives, produces=produces, switch_back=back)


def mission(
    hardware: list[str], activities: list[Activity], blocks: tuple[Parallel | Objective, ...]
) -> Mission:
    """A mission of one robot."""
    robot = Robot(
        name="r",
        hardware=tuple(Hardware(name=h) for h in hardware),
        software=tuple(Software(name=s) for a in activities for s in a.produces),
        activities=tuple(activities),
    )
    return Mission(name="m", robots=(robot,), blocks=blocks)


def beside(*names: str) -> tuple[Parallel, ...]:
    """A block with an objective for each activity."""
    return (Parallel(name="all", blocks=tuple(Objective(name=f"o{a}", activities=(a,)) for a in names)),)


def children(number: int) -> Mission:
    """A parallel block."""
    names = [f"a{i}" for i in range(number)]
    return mission([], [activity(a, ()) for a in names], beside(*names))


def resources(number: int) -> Mission:
    """An alternative with much to consume; it may wait for the producer of one."""
    owned = [f"h{i}" for i in range(number - 1)]
    makes = activity("make", ("h",), produces=("s",))
    return mission(
        ["h", *owned], [makes, activity("a", ("s", *owned)), activity("b", ("h",))], beside("a", "b")
    )


def alternatives(number: int) -> Mission:
    """An activity that returns to better alternatives."""
    names = [f"h{i}" for i in range(number)]
    going = activity("go", *((h,) for h in names), back=True)
    return mission(names, [going], (Objective(name="x", activities=("go",)),))


def row(drawn: Mission) -> str:
    """What each set makes of a mission."""
    cells = []
    for templates in SETS.values():
        try:
            took = []
            for _ in range(3):
                begun = time.process_time()
                net = compose(drawn, templates).net
                took.append(time.process_time() - begun)
            sizes = f"{len(net.places):,} + {len(net.transitions):,}"
            cells.append(f"{sizes:>16} {1000 * min(took):>7.1f}")
        except LimitError:
            cells.append(f"{'-':>24}")
    return "   ".join(cells)


def main() -> None:
    """Prints a row for each mission."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--numbers", type=int, nargs="*", default=[3, 6, 10, 12, 24])
    numbers = parser.parse_args().numbers
    print(f"{'places + transitions, milliseconds':<24}")
    print(f"{'':<16}" + "   ".join(f"{name:>24}" for name in SETS))
    print(f"{'Ulysse':<16}" + row(read_mission(ULYSSE)))
    families: tuple[Callable[[int], Mission], ...] = (children, resources, alternatives)
    for family in families:
        for number in numbers:
            print(f"{f'{number} {family.__name__}':<16}" + row(family(number)), flush=True)


if __name__ == "__main__":
    main()
