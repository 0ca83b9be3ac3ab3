"""A mission with handlers that happen once: what checking, causes and the controller cost.

Run: python experiments/once.py [--handlers N...] [--rows N]

A sprayer treats rows of a field; each handler is of an event of its own, in turn of the mission, of the rows
and of what is done in one. Prints sections, their types, stable states and seconds of this process, for
each number of handlers. It takes about ten seconds.
"""

from __future__ import annotations

import argparse
import platform
import time
from dataclasses import replace
from itertools import pairwise

from mcpn import __version__
from mcpn.answers.causes.find import find_causes
from mcpn.answers.verdicts.mission import check
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.sections import SectionParts
from mcpn.mission.model import Each, Handler, Mission, Objective
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Hardware, Robot, Software


def sprayer(handlers: int, rows: int) -> Mission:
    """A way there, rows with a way, the treatment and a service, a way home; a pause, and the rows again."""
    locate = Activity(
        name="locate",
        produces=("position",),
        alternatives=tuple(Alternative(name=f"by_{k}", consumes=(k,)) for k in ("gps", "lidar")),
    )
    drive = Activity(name="drive", alternatives=(Alternative(name="drive", consumes=("position", "wheels")),))
    spray = Activity(name="spray", alternatives=(Alternative(name="spray", consumes=("pump",)),))
    fill = Activity(name="fill", alternatives=(Alternative(name="fill"),))
    robot = Robot(
        name="sprayer",
        hardware=tuple(Hardware(name=name) for name in ("gps", "lidar", "wheels", "pump")),
        software=(Software(name="position"),),
        activities=(locate, drive, spray, fill),
        events=tuple(DeclaredEvent(name=f"e{i}") for i in range(handlers)),
    )

    def once(turn: int, goto: str) -> tuple[Handler, ...]:
        return tuple(Handler(event=f"e{i}", goto=goto, once=True) for i in range(turn, handlers, 3))

    row = Each(
        name="row",
        values=tuple(f"r{i}" for i in range(rows)),
        success="home",
        failure="home",
        handlers=once(1, "pause"),
        blocks=(
            Objective(name="way", activities=("drive",), retries=1),
            Objective(
                name="treat", activities=("drive", "spray"), success="succeed", handlers=once(2, "service")
            ),
            Objective(name="service", activities=("fill",), success="way"),
        ),
    )
    there, home = (Objective(name=name, activities=("drive",), retries=1) for name in ("there", "home"))
    home = replace(home, success="succeed")
    pause = Objective(name="pause", activities=("fill",), success="row", failure="home")
    return Mission(name="once", robots=(robot,), blocks=(there, row, home, pause), handlers=once(0, "pause"))


def types(found: MissionNet) -> int:
    """Types of a mission's sections."""
    alone = SectionParts(found.usage).alone
    return len({alone(section).type for section in found.graph.sections})


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--handlers", type=int, nargs="*", default=[0, 2, 4, 6, 8, 10], metavar="N")
    parser.add_argument("--rows", type=int, default=6, metavar="N")
    arguments = parser.parse_args()
    print(f"mcpn {__version__}, Python {platform.python_version()}, {platform.machine()}")
    print(
        "handlers  sections  types  stable states       edges    check    causes  controller  its states"
        "   edges"
    )
    for handlers in arguments.handlers:
        begun = [time.process_time()]
        found = compose(sprayer(handlers, arguments.rows))
        checked = check(found, engine="local")
        begun.append(time.process_time())
        find_causes(found, engine="local")
        begun.append(time.process_time())
        controller = generate(found)
        begun.append(time.process_time())
        assert checked.passed
        assert checked.stable_sizes is not None
        states, edges = checked.stable_sizes
        check_, causes, control = (b - a for a, b in pairwise(begun))
        print(
            f"{handlers:8} {len(controller.sections):9,} {types(found):6} {states:14,} {edges:11,} "
            f"{check_:6.2f} s {causes:7.2f} s {control:9.2f} s {controller.states:11,} {controller.moves:7,}",
            flush=True,
        )


if __name__ == "__main__":
    main()
