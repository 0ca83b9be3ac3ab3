"""A run that ends stops its drivers in turn, what was started last first, then its sources likewise."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from mcpn.robot.drivers.mapping import Plan
from mcpn.robot.drivers.running import RobotRun


def test_what_was_started_last_is_stopped_first() -> None:
    stopped = list[str]()

    class Fake:
        """A driver that notes when it is stopped."""

        alternative = "one"

        def __init__(self, name: str, number: int) -> None:
            self.name, self.number = name, number

        def leave(self) -> None:
            """It is told nothing more."""

        async def stop(self, hurried: bool) -> None:
            await asyncio.sleep(0)
            stopped.append(self.name)

    names = ("arm", "wheels", "camera")
    rows: dict[str, Any] = {
        name: {"alternatives": {"one": {"consumes": [], "produces": []}}} for name in names
    }
    tables = SimpleNamespace(laws=SimpleNamespace(activities=rows))

    async def ended() -> None:
        plan = Plan(Path(__file__), {}, {}, {}, {}, ("*",), {}, {})
        runner = RobotRun(cast("Any", None), cast("Any", tables), plan)
        vars(runner)["_turn"] = lambda verb, work, of: runner._turns.begin(work, (of.name,))
        runner._buses = {}
        runner.running = {name: cast("Any", Fake(name, number)) for number, name in enumerate(names)}
        runner._sources = [cast("Any", Fake("first source", 3)), cast("Any", Fake("second source", 4))]
        await asyncio.wait_for(runner._stop_all(), 60)

    asyncio.run(ended())
    assert stopped == [*reversed(names), "second source", "first source"]
