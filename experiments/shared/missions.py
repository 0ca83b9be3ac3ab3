"""Missions of any size, by parameters and a seed, for experiments and tests.

Usage: ``python experiments/shared/missions.py OUT.xml [--sections N] [--types N] ...`` writes one as a
mission file. It takes seconds.
"""

from __future__ import annotations

import argparse
import random
from dataclasses import dataclass
from pathlib import Path

from mcpn.mission.model import Block, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.writer import save_mission


@dataclass(frozen=True)
class Parameters:
    """What a generated mission is like.

    Args:
        sections: Sections of the objectives graph: elementary objectives and parallel blocks.
        types: Kinds of sections; those of one kind start the same activities.
        hardware: Hardware resources of the robot; each kind of section uses a few of them.
        per_section: Hardware resources that the chain under one activity stands on, at most.
        alternatives: Alternatives of an activity, at most.
        depth: Software resources in a chain under an activity. Each link doubles the internal runs after a
            failure at the chain's foot, by the paper's rule of evaluation (6.2).
        width: Children of a parallel block.
        parallel: Share of sections that are parallel blocks.
        recursive: Share of sections that stand in recursive objectives.
        loops: Share of sections whose failure leads back to an earlier one instead of onward.
    """

    sections: int = 10
    types: int = 4
    hardware: int = 6
    per_section: int = 4
    alternatives: int = 3
    depth: int = 2
    width: int = 2
    parallel: float = 0.25
    recursive: float = 0.2
    loops: float = 0.1


def generate(parameters: Parameters, seed: int = 0) -> Mission:
    """A mission; the same parameters and seed give the same one.

    What runs together never shares a resource, so nothing contends.

    Args:
        parameters: What it is like.
        seed: Any number.

    Returns:
        A valid mission.
    """
    return _Generator(parameters, random.Random(seed)).mission()


class _Generator:
    def __init__(self, parameters: Parameters, rng: random.Random) -> None:
        self.p = parameters
        self.rng = rng
        self.software: list[Software] = []
        self.activities: list[Activity] = []
        self.shapes: set[object] = set()

    def mission(self) -> Mission:
        p, rng = self.p, self.rng
        kinds = [self.kind(number) for number in range(min(p.types, p.sections))]
        order = [*range(len(kinds)), *(rng.randrange(len(kinds)) for _ in range(p.sections - len(kinds)))]
        rng.shuffle(order)
        names = [f"s{i}" for i in range(p.sections)]
        blocks: list[Block] = []
        for i, kind in enumerate(order):
            onward = names[i + 1] if i + 1 < p.sections else None
            failure = rng.choice(names[: i + 1]) if rng.random() < p.loops else onward
            blocks.append(self.section(names[i], kinds[kind], failure))
        hardware = tuple(Hardware(name=f"h{i}") for i in range(p.hardware))
        robot = Robot(
            name="robot",
            hardware=hardware,
            software=tuple(self.software),
            activities=tuple(self.activities),
        )
        return Mission(name=f"generated_{p.sections}", blocks=tuple(blocks), robots=(robot,))

    def kind(self, number: int) -> list[str]:
        """The activities of one kind of section: several run in parallel, one alone.

        Kinds differ in more than names, as long as the parameters leave room for that.
        """
        p, rng = self.p, self.rng
        for _ in range(200):
            branches = p.width if rng.random() < p.parallel else 1
            sizes = tuple(rng.randint(1, p.per_section) for _ in range(branches))
            depths = tuple(rng.randint(0, p.depth) for _ in range(branches))
            ways = tuple(rng.randint(1, p.alternatives) for _ in range(branches))
            if (sizes, depths, ways) not in self.shapes and sum(sizes) <= p.hardware:
                break
        self.shapes.add((sizes, depths, ways))
        # Branches share nothing: each has hardware of its own.
        chosen = rng.sample(range(p.hardware), min(p.hardware, sum(sizes)))
        activities = []
        for i, (size, depth, count) in enumerate(zip(sizes, depths, ways, strict=True)):
            share, chosen = chosen[:size], chosen[size:]
            activities.append(self.activity(f"a{number}_{i}", share, depth, count))
        return activities

    def activity(
        self, name: str, hardware: list[int], depth: int, count: int, produces: tuple[str, ...] = ()
    ) -> str:
        """An activity over a chain of software resources that stands on hardware; adds what is under it."""
        ways: list[tuple[str, ...]] = [(f"h{h}",) for h in hardware[:count]] or [()]
        rest = tuple(f"h{h}" for h in hardware[count:])
        if depth > 0:
            data = f"{name}_data"
            self.software.append(Software(name=data))
            self.activity(f"{name}_source", hardware[:count], depth - 1, count, (data,))
            ways = [(data, *rest)]
        elif rest:
            ways[0] = (*ways[0], *rest)
        alternatives = tuple(Alternative(name=f"{name}_way{i}", consumes=way) for i, way in enumerate(ways))
        self.activities.append(Activity(name=name, alternatives=alternatives, produces=produces))
        return name

    def section(self, name: str, activities: list[str], failure: str | None) -> Block:
        if len(activities) == 1:
            if self.rng.random() < self.p.recursive:
                inner = Objective(name=f"{name}_inner", activities=(activities[0],))
                return Recursive(name=name, blocks=(inner,), failure=failure)
            return Objective(name=name, activities=(activities[0],), failure=failure)
        branches = tuple(
            Objective(name=f"{name}_b{i}", activities=(activity,), mandatory=i == 0)
            for i, activity in enumerate(activities)
        )
        return Parallel(name=name, blocks=branches, failure=failure)


def main() -> None:
    """Writes a generated mission."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("output", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    for name, default in vars(Parameters()).items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=type(default), default=default)
    arguments = vars(parser.parse_args())
    output, seed = arguments.pop("output"), arguments.pop("seed")
    save_mission(generate(Parameters(**arguments), seed), output)


if __name__ == "__main__":
    main()
