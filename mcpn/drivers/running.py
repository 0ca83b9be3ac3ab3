"""Runs a mission's controller with the drivers of a robot."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mcpn.drivers.mapping import ending, starts_by_itself, tells
from mcpn.drivers.plan import FAILURE, SUCCESS, Plan
from mcpn.drivers.starts import Started
from mcpn.drivers.topics import buses_of
from mcpn.runtime.controller import Controller
from mcpn.runtime.tables import START, Action, Refused, Tables

_log = logging.getLogger("mcpn.drivers")


@dataclass(frozen=True)
class Waiting:
    """An event that is to be handled, and who told it: nobody, if the runner itself."""

    event: str
    by: Started | None = None


class RobotRun:
    """A controller among its drivers.

    Events are handled one after the other; an action is carried out before the next one, so that hardware is
    released when what had it has ended. What a driver tells counts until it is stopped. That an objective has
    ended, told while the controller cannot take it, is kept until it can, as long as the driver runs. An
    objective that has an activity in error can only fail: the runner tells so.

    Args:
        controller: The controller; it raises at what it refuses.
        tables: Its tables.
        plan: The drivers, which have been held against them.
        told: Called with each line of a driver that tells no event.
        after: Called after each event that is taken, before its actions are carried out.
    """

    def __init__(
        self,
        controller: Controller,
        tables: Tables,
        plan: Plan,
        *,
        told: Callable[[str, str], None] = lambda name, line: None,
        after: Callable[[], None] = lambda: None,
    ) -> None:
        self.controller, self._tables, self._plan = controller, tables, plan
        self._told, self._after = told, after
        self.running: dict[str, Started] = {}
        """By activity, its driver, in the order of the starts."""
        self._sources: list[Started] = []
        self._chosen: dict[str, Action] = {}
        self._count = 0
        self.busy = True
        """Whether an event is being handled, so that what runs is between two modes."""
        self._events: deque[Waiting] = deque()
        self._held: list[Waiting] = []
        self._came = asyncio.Event()
        self._ending = False
        self._hurry = False
        self._stopping: list[Started] = []

    def end(self) -> None:
        """Ends :meth:`run` after the event that is handled now; called again, drivers get no time to end."""
        if self._ending:
            self._hurry = True
            for started in (*self.running.values(), *self._sources, *self._stopping):
                started.kill()
        self._ending = True
        self._came.set()

    async def run(self, resumed: Sequence[Action] | None = None) -> None:
        """Runs until the mission ends, or :meth:`end` is called; then nothing of it is left running.

        Args:
            resumed: What brings the robot to where the controller is, instead of the mission's start.

        Raises:
            InputError: A connection cannot be made.
            LimitError: What it needs is not installed.
        """
        self._buses = await asyncio.to_thread(buses_of, self._plan)
        try:
            for name, spec in self._plan.sources.items():
                source = Started(spec, name, None, None, {}, self._count, self._said)
                self._sources.append(source)
                await source.start(self._plan.file.parent, self._buses)
            if resumed is not None:
                await self._carry_out(resumed)
            elif starts_by_itself(self._plan):
                self._put(Waiting(START))
            await self._handle()
        finally:
            await self._stop_all()

    # --- events ---

    def _put(self, waiting: Waiting) -> None:
        self._events.append(waiting)
        self._came.set()

    def _said(self, by: Started, event: str | None, line: str) -> None:
        """Takes what a driver tells."""
        text = None if event is None else tells(by.spec, event, by.objective, self._tables)
        if text is None:
            self._told(str(by), line)
        else:
            self._put(Waiting(text, by))

    async def _handle(self) -> None:
        while self.controller.outcome is None and not self._ending:
            waiting = await self._next()
            if waiting is None:
                continue
            if self._is_own_end(waiting):
                if waiting.by is None or waiting.by.over:
                    continue  # what it tells of an objective that was left since
                if waiting.event not in self.controller.possible:
                    self._held.append(waiting)
                    continue
            try:
                actions, failed = self.controller.react(waiting.event)
            except Refused:
                continue  # logged and counted by the controller
            for each in failed:
                _log.error("an observer has failed %s", each, exc_info=each.error)
            self._after()
            await self._carry_out(actions)
            self._events.extendleft(reversed(self._held))
            self._held.clear()

    def _is_own_end(self, waiting: Waiting) -> bool:
        """Whether a driver tells that the objective has ended that it runs for."""
        of = None if waiting.by is None else waiting.by.objective
        return of is not None and waiting.event in (ending(of, SUCCESS), ending(of, FAILURE))

    def _failure(self) -> str | None:
        """The failure of an objective that has an activity in error: nothing else may come of it."""
        state = self.controller.state
        for objective in state.objectives if state.refused else ():
            activities = self._tables.laws.objectives[objective]["activities"]
            event = ending(objective, FAILURE)
            if not set(activities).isdisjoint(state.refused) and event in self.controller.possible:
                return event
        return None

    async def _next(self) -> Waiting | None:
        """The next event; that of a timer that is over, and of an activity in error, before others."""
        if (first := self.controller.overdue or self._failure()) is not None:
            return Waiting(first)
        if not self._events:
            self.busy = False
            self._came.clear()
            left = min(self.controller.timers.values(), default=None)
            try:
                await asyncio.wait_for(self._came.wait(), left)
            except TimeoutError:
                return None
            finally:
                self.busy = True
        return self._events.popleft() if self._events else None

    # --- actions ---

    async def _carry_out(self, actions: Sequence[Action]) -> None:
        for number, action in enumerate(actions):
            name = action.activity
            if action.verb == "stop" and name is not None:
                await self._stop(name)
            elif action.verb == "release" and action.hardware is not None:
                await self._release(action.hardware)
            elif action.verb == "select" and name is not None:
                self._chosen[name] = action
                starts = any(of.verb == "start" and of.activity == name for of in actions[number:])
                if name in self.running and not starts:  # it goes on with another alternative
                    await self._stop(name)
                    await self._start(name)
            elif action.verb == "start" and name is not None:
                await self._start(name)

    async def _start(self, name: str) -> None:
        chosen = self._chosen[name]
        assert chosen.alternative is not None
        spec = self._plan.driver(name, chosen.alternative)
        assert spec is not None, "the plan has been held against the controller"
        parameters = {value.name: value.value for value in chosen.parameters}
        self._count += 1
        started = Started(
            spec, name, chosen.alternative, chosen.objective, parameters, self._count, self._said
        )
        self.running[name] = started
        await started.start(self._plan.file.parent, self._buses)

    async def _stop(self, name: str) -> None:
        if (started := self.running.pop(name, None)) is not None:
            self._stopping = [started]
            await started.stop(self._hurry)
            self._stopping = []

    async def _release(self, hardware: str) -> None:
        spec = self._plan.releases.get(hardware)
        if spec is None:
            return
        self._count += 1
        releasing = Started(spec, hardware, None, None, {}, self._count, self._said)
        await releasing.start(self._plan.file.parent, self._buses)
        try:
            await asyncio.wait_for(releasing.ended(), spec.grace)
        except TimeoutError:
            _log.warning("the release of %s has not ended within %g seconds", hardware, spec.grace)
        await releasing.stop(self._hurry)

    async def _stop_all(self) -> None:
        """Stops each activity, what was started last first, releases its hardware, stops the sources."""
        had = dict[str, None]()
        for name, started in reversed(list(self.running.items())):
            row = self._tables.laws.activities[name]["alternatives"]
            had |= dict.fromkeys(row[started.alternative]["consumes"])
            await self._stop(name)
        for hardware in had:
            await self._release(hardware)
        for source in reversed(self._sources):
            await source.stop(self._hurry)
        for bus in self._buses.values():
            await asyncio.to_thread(bus.close)
