"""A mission with rates and durations, drawn once: what numbers of risk are measured on."""

from __future__ import annotations

import random
from dataclasses import replace

from mcpn.mission.model import Block, Mission, Objective, Parallel, Recursive


def rated(mission: Mission) -> Mission:
    """The mission with rates and durations."""
    drawn = random.Random(1)
    (robot,) = mission.robots
    hardware = tuple(
        replace(h, failure_rate=drawn.uniform(0.001, 0.05), repair_rate=drawn.uniform(0.1, 2.0))
        for h in robot.hardware
    )
    events = tuple(replace(event, rate=0.02) for event in robot.events)

    def lasting(block: Block) -> Block:
        if isinstance(block, Objective):
            return replace(block, duration=0.5, failure_probability=0.05)
        if isinstance(block, Recursive | Parallel):
            return replace(block, blocks=tuple(map(lasting, block.blocks)))
        return block

    robots = (replace(robot, hardware=hardware, events=events),)
    return replace(mission, robots=robots, blocks=tuple(map(lasting, mission.blocks)))
