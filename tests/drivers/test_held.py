"""Which of the ends that drivers tell are handled, and when: of what still runs, once the controller can."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence, Set
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from mcpn.robot.drivers.mapping import Plan
from mcpn.robot.drivers.running import RobotRun, Waiting
from mcpn.robot.drivers.starts import Started
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables

X, Y, ROOM = "OBJ_x_EV_OK", "OBJ_y_EV_OK", "room"


class Scripted:
    """A controller that can take some events at first, others after its first event, and so on."""

    def __init__(self, *possible: Set[str]) -> None:
        self._left = [*possible]
        self.taken: list[str] = []
        self.state = SimpleNamespace(objectives=("x", "y"), refused=())
        self.timers: dict[str, float] = {}
        self.overdue = None

    @property
    def outcome(self) -> str | None:
        return None if self._left else "success"

    @property
    def possible(self) -> Set[str]:
        return self._left[0]

    def react(self, event: str) -> tuple[Sequence[Any], Sequence[Any]]:
        assert event in self.possible
        self.taken.append(event)
        del self._left[0]
        return (), ()


def driver(objective: str, over: bool = False) -> Started:
    return cast("Started", SimpleNamespace(objective=objective, over=over))


def taken(controller: Scripted, *told: Waiting) -> list[str]:
    """The events that are taken, in their order, of those that are told."""
    plan = Plan(Path(__file__), {}, {}, {}, {}, ("*",), {}, {})
    tables = cast("Tables", SimpleNamespace(laws=None))

    async def handled() -> None:
        runner = RobotRun(cast("Controller", controller), tables, plan)
        for waiting in told:
            runner._put(waiting)
        await asyncio.wait_for(runner._handle(), 60)

    asyncio.run(handled())
    return controller.taken


def test_ends_that_cannot_be_taken_yet_are_taken_in_the_order_in_which_they_were_told() -> None:
    for first, second in ((X, Y), (Y, X)):
        told = [Waiting(event, driver(event[4])) for event in (first, second)]
        controller = Scripted({ROOM}, {X, Y}, {X, Y})
        assert taken(controller, *told, Waiting(ROOM)) == [ROOM, first, second]


def test_what_a_driver_told_whose_objective_was_left_does_not_count() -> None:
    """The objective may run again by then, with another driver, whose end would be another."""
    controller = Scripted({ROOM, X}, {ROOM, X})
    left, again = Waiting(X, driver("x", over=True)), Waiting(X, driver("x"))
    assert taken(controller, left, Waiting(ROOM), again) == [ROOM, X]


def test_what_a_driver_tells_twice_is_kept_once() -> None:
    told = Waiting(X, driver("x"))
    assert taken(Scripted({ROOM}, {X}, {ROOM}), told, told, Waiting(ROOM), Waiting(ROOM)) == [ROOM, X, ROOM]
