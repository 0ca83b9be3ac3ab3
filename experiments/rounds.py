"""A visit that is repeated, tried again each time: what composing, checking and its controller cost.

Run: python experiments/rounds.py [--repeat N...] [--retries N]

Prints seconds of this process for each number of rounds, with the seconds that a thousand sections took; the
last rounds of the default are 19,892 sections. It takes a minute.
"""

from __future__ import annotations

import argparse
import platform
import time
from itertools import pairwise

from mcpn import __version__
from mcpn.answers.verdicts.mission import check
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software


def rounds(repeat: int, retries: int) -> Mission:
    """A way there, visits in which a camera's image serves two activities, and a way home."""
    film = Activity(
        name="film", produces=("image",), alternatives=(Alternative(name="film", consumes=("camera",)),)
    )
    look = Activity(name="look", alternatives=(Alternative(name="look", consumes=("image",)),))
    ways = Alternative(name="fast", consumes=("arm",)), Alternative(name="seen", consumes=("image",))
    robot = Robot(
        name="robot",
        hardware=(Hardware(name="camera"), Hardware(name="arm")),
        software=(Software(name="image"),),
        activities=(film, look, Activity(name="go", alternatives=ways)),
    )
    see = Objective(name="see", activities=("look", "go"), retries=retries)
    start, home = (Objective(name=name, activities=("go",)) for name in ("start", "home"))
    visit = Recursive(name="visit", blocks=(see,), repeat=repeat)
    return Mission(name="rounds", robots=(robot,), blocks=(start, visit, home))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeat", type=int, nargs="*", default=[50, 100, 200, 390], metavar="N")
    parser.add_argument("--retries", type=int, default=50, metavar="N")
    arguments = parser.parse_args()
    print(f"mcpn {__version__}, Python {platform.python_version()}, {platform.machine()}")
    print("sections  compose    check  controller  check of 1,000  stable states       edges")
    for repeat in arguments.repeat:
        mission = rounds(repeat, arguments.retries)
        times = [time.process_time()]
        mission_net = compose(mission)
        times.append(time.process_time())
        found = check(mission_net, engine="local")
        times.append(time.process_time())
        controller = generate(mission_net)
        times.append(time.process_time())
        composed, checked, generated = (b - a for a, b in pairwise(times))
        assert found.passed
        assert found.stable_sizes is not None
        sections = len(controller.sections)
        print(
            f"{sections:8,} {composed:6.1f} s {checked:6.1f} s {generated:9.1f} s "
            f"{1000 * checked / sections:13.2f} s {found.stable_sizes[0]:14,} {found.stable_sizes[1]:11,}",
            flush=True,
        )


if __name__ == "__main__":
    main()
