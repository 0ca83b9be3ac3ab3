"""What formulas on the Ulysse mission take, once its markings are reached.

Usage: ``python experiments/formulas.py [MISSION]``; it takes seconds for Ulysse.
"""

from __future__ import annotations

import argparse
import platform
import time
from pathlib import Path

from mcpn import __version__
from mcpn.drawing.compose import compose
from mcpn.logic.asking import Questions
from mcpn.mission.xml import read_mission

ULYSSE = Path(__file__).parent / "ulysse" / "mission.xml"
FORMULAS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("AG EF (success | failure)", ()),
    ("AF (success | failure)", ()),
    ("AF (success | failure)", ("progress",)),
    ("EF failure", ()),
    ("EF (oos(thruster_actuator) & !success & E[oos(thruster_actuator) U success])", ()),
    ("EF (oos(GPS_sensor) & !success & E[oos(GPS_sensor) U success])", ()),
)


def main() -> None:
    """Prints for each formula and graph the answer and milliseconds of CPU, its run apart."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mission", type=Path, nargs="?", default=ULYSSE)
    mission_net = compose(read_mission(parser.parse_args().mission))
    for on in ("markings", "alternatives"):
        questions = Questions(mission_net, on="markings" if on == "markings" else "alternatives")
        started = time.process_time()
        space = questions.space
        reached = (time.process_time() - started) * 1000
        print(f"{on}: reached in {reached:.0f} ms, {space.everything.count()} states")
        for text, fair in FORMULAS:
            asked = Questions(mission_net, on=on, fair=fair)
            formula = asked.formula(text)
            evaluation = asked.evaluation  # on a space of its own, reached before the clock runs
            started = time.process_time()
            holds = evaluation.holds(formula)
            decided = (time.process_time() - started) * 1000
            started = time.process_time()
            answer = asked.answer(text)
            shown = (time.process_time() - started) * 1000
            steps = len(answer.witness.steps)
            under = f" under {', '.join(fair)}" if fair else ""
            print(f"  {holds!s:5} {decided:7.1f} ms, run of {steps} steps {shown:7.1f} ms  {text}{under}")
    print(f"CPU; mcpn {__version__}, Python {platform.python_version()}, {platform.machine()}")


if __name__ == "__main__":
    main()
