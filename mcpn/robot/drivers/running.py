"""Runs a controller with a robot's drivers: when each starts, and in which order they stop at the end."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from mcpn.events import Event
from mcpn.robot.drivers.mapping import FAILURE, DriverSpec, Plan, ended, ending, starts_by_itself, tells
from mcpn.robot.drivers.processes import Warden
from mcpn.robot.drivers.starts import Started
from mcpn.robot.drivers.topics import StopMessage, buses_of, tell_to_stop
from mcpn.robot.drivers.turns import Turns
from mcpn.robot.runtime.actions import START, Action, Refused
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables

_log = logging.getLogger("mcpn.robot.drivers")

MOST_EVENTS = 1000
"""Events that may wait; while there are more, drivers are not read."""
HURRY = 0.5
"""Seconds that the release of hardware has when somebody asks a second time for the end."""


@dataclass(frozen=True)
class Waiting:
    """An event that is to be handled, and who told it: nobody, if the runner itself."""

    event: str
    by: Started | None = None


class RobotRun:
    """A controller among its drivers.

    Events are handled one after the other, also while drivers are being stopped. An action waits for those
    before it that have to do with the same activity, hardware or software: hardware is released when what
    had it has ended, and who needs it then is started after that. What a driver tells counts until it is to
    be stopped. That an objective has ended, told while the controller cannot take it, is kept until it can,
    as long as the driver runs. An objective that has an activity in error can only fail: the runner tells so.

    Args:
        controller: The controller; it raises at what it refuses.
        tables: Its tables.
        plan: The drivers, which have been held against them.
        told: Called with each line of a driver that tells no event.
        after: Called after each event that is taken, before its actions are carried out; where it calls
            :meth:`end`, they are not.
        begins: Called when something is about to begin that may outlive this process.
        starts: How many drivers were started before, in the run that is gone on with.
        untold: What that run has begun by a message, and has not ordered to stop.
    """

    def __init__(
        self,
        controller: Controller,
        tables: Tables,
        plan: Plan,
        *,
        told: Callable[[str, str], None] = lambda name, line: None,
        after: Callable[[], None] = lambda: None,
        begins: Callable[[], None] = lambda: None,
        starts: int = 0,
        untold: Sequence[StopMessage] = (),
    ) -> None:
        self.controller, self._tables, self._plan = controller, tables, plan
        self._told, self._after = told, after
        self.running: dict[str, Started] = {}
        """By activity, its driver, in the order of the starts; one may have to wait before it begins."""
        self._sources: list[Started] = []
        self._chosen: dict[str, Action] = {}
        self.starts = starts
        """How many drivers were started; ``{run}`` is the number of each."""
        self._untold = dict(enumerate(untold, -len(untold)))
        self._fresh = False
        self._begins = begins
        self._handling = True
        self._events: deque[Waiting] = deque()
        self._held: list[Waiting] = []
        self._came = asyncio.Event()
        self._ending = False
        self._hurried = asyncio.Event()
        self._stopping: set[Started] = set()
        self._turns = Turns()
        self.warden = Warden(begins)
        """Knows the processes that run."""

    @property
    def busy(self) -> bool:
        """Whether an event is being handled, or actions are not done: what runs is between two modes."""
        return self._handling or self._turns.busy

    @property
    def untold(self) -> list[StopMessage]:
        """What is to be told to stop by messages, should this run end without having done so."""
        return list(self._untold.values())

    def end(self, again: bool = False) -> None:
        """Ends :meth:`run` after the event that is handled now.

        Args:
            again: Somebody asks a second time: drivers get no time to end, releases of hardware little.
                Without it a further call changes nothing, for two records may fail in one event.
        """
        if again and self._ending:
            self._hurried.set()
            for started in (*self.running.values(), *self._sources, *self._stopping):
                started.kill()
        self._ending = True
        self._came.set()

    async def run(self, resumed: Sequence[Action] | None = None) -> None:
        """Runs until the mission ends, or :meth:`end` is called; then nothing of it is left running.

        Args:
            resumed: What brings the robot to where the controller is, of a run that is gone on with.

        Raises:
            InputError: A connection cannot be made.
            LimitError: What it needs is not installed.
        """
        self._buses = await asyncio.to_thread(buses_of, self._plan)
        try:
            for number, message in [*self._untold.items()]:
                await asyncio.to_thread(tell_to_stop, self._buses, message)
                del self._untold[number]
            for name, spec in self._plan.sources.items():
                source = self._made(spec, name)
                self._sources.append(source)
                self._note()
                await source.start(self._plan.file.parent, self._buses)
            if resumed is not None:
                self._carry_out(resumed)
            # Also of a run that is resumed: it may have ended before the mission began.
            if START in self.controller.possible and starts_by_itself(self._plan):
                self._put(Waiting(START))
            await self._handle()
        finally:
            await self._stop_all()

    def _made(
        self,
        spec: DriverSpec,
        name: str,
        alternative: str | None = None,
        objective: str | None = None,
        parameters: Mapping[str, str] = MappingProxyType({}),
    ) -> Started:
        self.starts += 1
        made = Started(
            spec=spec,
            name=name,
            alternative=alternative,
            objective=objective,
            parameters=parameters,
            number=self.starts,
            told=self._said,
            ready=lambda: len(self._events) < MOST_EVENTS,
            keeper=self.warden,
        )
        if made.topics is not None:
            self._fresh = True  # also without a stop: its number is not given again
            if (message := made.to_stop) is not None:
                self._untold[made.number] = message
        return made

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
                    if waiting not in self._held:
                        self._held.append(waiting)
                    continue
            try:
                actions, failed = self.controller.react(waiting.event)
            except Refused:
                continue  # logged and counted by the controller
            for each in failed:
                _log.error("an observer has failed %s", each, exc_info=each.error)
            self._after()
            if self._ending:
                return
            self._carry_out(actions)
            self._events.extendleft(reversed(self._held))
            self._held.clear()

    def _is_own_end(self, waiting: Waiting) -> bool:
        """Whether a driver tells that the objective has ended that it runs for."""
        objective = None if waiting.by is None else waiting.by.objective
        event = Event.parse(waiting.event)
        return objective is not None and event.element == objective and ended(event) is not None

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
            self._handling = False
            self._came.clear()
            left = min(self.controller.timers.values(), default=None)
            try:
                await asyncio.wait_for(self._came.wait(), left)
            except TimeoutError:
                return None
            finally:
                self._handling = True
        return self._events.popleft() if self._events else None

    def _carry_out(self, actions: Sequence[Action]) -> None:
        """Begins some actions; none is waited for here."""
        for action in actions:
            name = action.activity
            if action.verb == "stop" and name is not None:
                self._stop(name)
            elif action.verb == "release" and action.hardware is not None:
                self._release(action.hardware)
            elif action.verb == "select" and name is not None:
                self._chosen[name] = action
                if name in self.running:  # not stopped before: it goes on with another alternative
                    self._stop(name)
                    self._start(name)
            elif action.verb == "start" and name is not None:
                self._start(name)
        self._note()

    def _note(self) -> None:
        """Has it written, before they are sent, which messages begin something that is to be told to stop."""
        if self._fresh:
            self._fresh = False
            self._begins()

    def _turn(self, what: str, work: Callable[[], Awaitable[None]], started: Started) -> asyncio.Task[None]:
        """Begins an action of an activity after those before it that have to do with the same things."""
        row = self._tables.laws.activities[started.name]
        assert started.alternative is not None
        software = self._tables.laws.producers.keys()
        consumed = set(row["alternatives"][started.alternative]["consumes"])

        def waits(names: list[str]) -> None:
            self._told(str(started), f"{what} waits for {', '.join(names)}")
            waiting.append(what)

        async def done() -> None:
            await work()
            if waiting:
                self._told(str(started), f"{what} is done")

        waiting: list[str] = []
        changes = dict.fromkeys((started.name, *row["produces"], *sorted(consumed - software)))
        return self._turns.begin(done, changes, sorted(consumed & software), waits)

    def _start(self, name: str) -> None:
        chosen = self._chosen[name]
        assert chosen.alternative is not None
        spec = self._plan.driver(name, chosen.alternative)
        assert spec is not None, "the plan has been held against the controller"
        parameters = {value.name: value.value for value in chosen.parameters}
        started = self._made(spec, name, chosen.alternative, chosen.objective, parameters)
        self.running[name] = started

        async def start() -> None:
            if not started.over:  # it was stopped before its turn came
                await started.start(self._plan.file.parent, self._buses)

        self._turn("start", start, started)

    def _stop(self, name: str) -> asyncio.Task[None] | None:
        if (started := self.running.pop(name, None)) is None:
            return None
        started.leave()

        async def stop() -> None:
            self._stopping.add(started)
            await self._end(started)
            self._stopping.discard(started)

        return self._turn("stop", stop, started)

    def _release(self, hardware: str) -> asyncio.Task[None] | None:
        spec = self._plan.releases.get(hardware)
        if spec is None:
            return None
        releasing = self._made(spec, hardware)

        async def release() -> None:
            await releasing.start(self._plan.file.parent, self._buses)
            if not await self._in_time(releasing.ended(), spec.grace):
                grace = min(spec.grace, HURRY) if self._hurried.is_set() else spec.grace
                _log.warning("the release of %s has not ended within %g seconds", hardware, grace)
            await self._end(releasing)

        return self._turns.begin(release, (hardware,))

    async def _in_time(self, what: Coroutine[Any, Any, None], grace: float) -> bool:
        """Waits for something; not for long from when somebody has asked a second time for the end."""
        tasks = waited, hurried = asyncio.create_task(what), asyncio.create_task(self._hurried.wait())
        await asyncio.wait(tasks, timeout=grace, return_when=asyncio.FIRST_COMPLETED)
        if not waited.done() and hurried.done():
            await asyncio.wait((waited,), timeout=min(grace, HURRY))
        for task in tasks:
            task.cancel()
        return waited.done() and not waited.cancelled()

    async def _end(self, started: Started) -> None:
        """Stops a driver, which needs not be told so again."""
        await started.stop(self._hurried.is_set())
        self._untold.pop(started.number, None)

    async def _stop_all(self) -> None:
        """Stops each activity, what was started last first, releases its hardware, stops the sources."""
        had = dict[str, None]()
        for started in self.running.values():
            started.leave()
        for name, started in reversed(list(self.running.items())):
            row = self._tables.laws.activities[name]["alternatives"]
            had |= dict.fromkeys(row[started.alternative]["consumes"])
            if (stopping := self._stop(name)) is not None:
                await asyncio.wait((stopping,))
        for hardware in had:
            if (releasing := self._release(hardware)) is not None:
                await asyncio.wait((releasing,))
        await self._turns.over()
        for source in reversed(self._sources):
            await self._end(source)
        for bus in self._buses.values():
            await asyncio.to_thread(bus.close)
        self.warden.close()
