"""A long mission with facts: what checking it costs by the number of facts.

Run: python experiments/growth/facts.py [--sections N] [--facts N...]

Objectives follow one another; each sets one of the facts, in turn, and its activity has an alternative that
the fact allows and one for when it does not; every tenth leads on by the fact that was set before. Prints the
sections, their types, stable states, and seconds of this process for composing it and for every verdict.
"""

from __future__ import annotations

import argparse
import time

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.drawing.sections import SectionParts
from mcpn.mission.model import FactRoute, Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Fact, FactChange, Hardware, Robot


def corridor(sections: int, facts: int) -> Mission:
    """Doors in a row that are opened and closed."""
    doors = tuple(Fact(name=f"door{i}", values=("closed", "open")) for i in range(facts))
    activities = tuple(
        Activity(
            name=f"pass{i}",
            alternatives=(
                Alternative(name="through", consumes=("wheels",), requires=(f"door{i}=open",) * (facts > 0)),
                Alternative(name="around", consumes=("wheels", "lidar")),
            ),
        )
        for i in range(max(1, facts))
    )
    blocks = []
    for n in range(sections):
        i, last = n % max(1, facts), n + 1 == sections
        sets = (FactChange(fact=f"door{i}", to="open" if n // facts % 2 == 0 else "closed"),) if facts else ()
        goto = "succeed" if last else f"o{n + 1}"
        closed = FactRoute(when=(f"door{i}=closed",), goto=goto, on="failure")
        routes = (closed,) if facts and n % 10 == 0 else ()
        blocks.append(Objective(name=f"o{n}", activities=(f"pass{i}",), sets=sets, routes=routes))
    hardware = tuple(Hardware(name=name) for name in ("wheels", "lidar"))
    robot = Robot(name="robot", hardware=hardware, facts=doors, activities=activities)
    return Mission(name="corridor", robots=(robot,), blocks=tuple(blocks))


def main() -> None:
    """Prints a row for each number of facts."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--sections", type=int, default=1000)
    parser.add_argument("--facts", type=int, nargs="*", default=[0, 1, 5, 20])
    arguments = parser.parse_args()
    print(f"{'facts':>5} {'sections':>8} {'types':>5} {'stable states':>24} {'seconds':>8}")
    for facts in arguments.facts:
        begun = time.process_time()
        mission_net = compose(corridor(arguments.sections, facts))
        alone = SectionParts(mission_net.usage).alone
        types = {alone(section).type for section in mission_net.graph.sections}
        found = check(mission_net, engine="local")
        assert found.verdicts["success_reachable"].holds
        assert found.stable_sizes is not None
        states, _ = found.stable_sizes
        seconds = time.process_time() - begun
        print(f"{facts:5} {arguments.sections:8} {len(types):5} {states:24,} {seconds:8.2f}", flush=True)


if __name__ == "__main__":
    main()
