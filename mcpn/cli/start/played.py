"""The robot of drivers.toml, played: put your robot's own functions and programs in their place.

A function may also be one without async: it then runs on a thread, and is to look at call.stopping.
"""

import asyncio
import signal
import sys

from mcpn.robot.drivers.functions import Call


async def drive(call: Call) -> bool:
    """Drives to a place; what is returned says in drivers.toml whether the objective succeeds."""
    call.say(f"to {call.parameters.get('place', 'base')}")
    await asyncio.sleep(0.2)
    return True


async def take_picture(call: Call) -> bool:
    """Takes a picture."""
    await asyncio.sleep(0.1)
    call.say("click")
    return True


async def measure(call: Call) -> bool:
    """Measures something."""
    await asyncio.sleep(0.1)
    call.say("21.5 degrees")
    return True


async def localise(call: Call) -> None:
    """Tells where the robot is until it is stopped."""
    call.say(f"localises {call.alternative}")
    await asyncio.Event().wait()


if __name__ == "__main__":  # the lidar's driver: a program that runs until SIGTERM
    print(*sys.argv[1:], "turns", flush=True)
    signal.pause()
