"""Drivers that are actions of PyRoboSim (``pip install "mcpn[worlds]"``), in a world of the workshop.

The folder of the worlds is ``MCPN_ROSCON``, the seed of what fails ``MCPN_SEED``.
"""

from __future__ import annotations

import asyncio
import logging
import math
import os
import zlib
from pathlib import Path
from typing import Any

from mcpn.robot.drivers.functions import Call

PROBABILITIES = {"navigate": 0.9, "pick": 0.5, "place": 0.5, "open": 0.75, "close": 0.75}
"""How probably each action succeeds in worlds 3 and 4; worlds 1 and 2, where all succeed, get the same."""
FASTEST = -1.0
"""Of PyRoboSim: poses follow each other without a pause, the same ones."""

MOST_NODES = 1500
"""Samples of a search for a way: of 250 the median took 60, the longest 560. It has no limit of time, so
that no run depends on the machine's load. Where there is no way, it takes some ten seconds of a core."""

_world: dict[str, Any] = {}


def begin(path: Path, seed: int) -> Any:
    """A world at its start, in which all that is drawn follows from a seed.

    Args:
        path: The world's file.
        seed: Of what fails, of poses, and of the ways that the planner finds.
    """
    import numpy
    from pyrobosim.core import WorldYamlLoader
    from pyrobosim.planning.actions import ExecutionOptions
    from pyrobosim.utils.logging import get_global_logger

    for name in (get_global_logger().name, "robot", "delib_ws_problem"):
        logging.getLogger(name).setLevel(logging.ERROR)
    numpy.random.seed(_drawn(path, seed, "poses"))  # the generator that PyRoboSim draws from
    logging.disable(logging.WARNING)  # each world makes a logger of its own
    world = WorldYamlLoader().from_file(str(path))
    logging.disable(logging.NOTSET)
    for logger in (world.logger, world.robots[0].logger):
        logger.setLevel(logging.ERROR)
    for action, probability in PROBABILITIES.items():
        own = world.robots[0].action_execution_options.get(action)
        world.robots[0].action_execution_options[action] = ExecutionOptions(
            success_probability=probability,
            rng_seed=_drawn(path, seed, action),
            battery_usage=0.0 if own is None else own.battery_usage,
        )
    planner: Any = world.robots[0].path_planner
    planner.max_time, planner.max_nodes_sampled = math.inf, MOST_NODES
    _world.update(now=world, battery=world.robots[0].battery_level, unforeseen=0)
    return world


def _drawn(path: Path, seed: int, of: str) -> int:
    return zlib.crc32(f"{path.name} {seed} {of}".encode())


def end() -> None:
    """Forgets the world, so that the next action begins anew."""
    _world.clear()


async def act(call: Call) -> bool:
    """Carries out one action; it is cancelled with its driver."""
    from pyrobosim.planning.actions import TaskAction

    if "now" not in _world:
        folder = os.environ.get("MCPN_ROSCON")
        if folder is None:
            raise RuntimeError("MCPN_ROSCON is to name the folder of the worlds")
        path = Path(folder) / "worlds" / call.parameters["world"]
        await asyncio.to_thread(begin, path, int(os.environ.get("MCPN_SEED", "0")))
    robot = _world["now"].robots[0]
    action = TaskAction(
        type=call.activity,
        **({"target_location": call.parameters["target"]} if call.activity == "navigate" else {}),
        **({"object": call.parameters["target"]} if call.activity == "pick" else {}),
    )
    try:
        result = await asyncio.to_thread(robot.execute_action, action, FASTEST)
    except asyncio.CancelledError:
        robot.path_executor.cancel_execution = True
        raise
    _world["battery"] = min(_world["battery"], robot.battery_level)
    if not result.is_success() and not result.message.startswith("Simulated"):
        _world["unforeseen"] += 1
    return bool(result.is_success())


def where() -> dict[str, str | bool | float]:
    """What the world is like: where each object is, whether each place is open.

    ``battery`` is the least that was left; ``unforeseen`` counts actions that failed undrawn.
    """
    world = _world["now"]
    things: dict[str, str | bool | float] = {thing.name: thing.parent.name for thing in world.objects}
    places = {place.name: place.is_open for place in world.locations}
    return things | places | {"battery": _world["battery"], "unforeseen": _world["unforeseen"]}
