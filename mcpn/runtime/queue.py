"""Events from several threads, and from coroutines: both hand them to the controller one by one."""

from __future__ import annotations

import asyncio
import queue
from collections.abc import AsyncIterator
from typing import Final, Literal

from mcpn.runtime.controller import Controller
from mcpn.runtime.tables import Action, Refused


class QueueFull(Exception):
    """An event was put in a queue that is full; it has not been taken, its sender decides what to do."""


class EventQueue:
    """Events that any thread puts and one thread handles, in the order in which they came.

    Args:
        controller: Who handles them.
        size: How many may wait.
    """

    _CLOSED: Final = object()

    def __init__(self, controller: Controller, size: int = 1024) -> None:
        if size < 1:
            raise ValueError(f"a queue of size {size} found, at least 1 expected")
        self.controller = controller
        self._queue: queue.Queue[object] = queue.Queue(size)

    def put(self, event: str, timeout: float = 0.0) -> None:
        """Puts an event.

        Args:
            event: Its text.
            timeout: How many seconds to wait for a free place.

        Raises:
            QueueFull: None became free.
        """
        try:
            self._queue.put(event, timeout > 0, timeout or None)
        except queue.Full:
            raise QueueFull(f"{event!r}: {self._queue.maxsize} events wait already") from None

    def close(self) -> None:
        """Lets :meth:`run` return after the events that wait now."""
        self._queue.put(self._CLOSED)

    def run(self) -> None:
        """Handles events until the queue is closed; a refused event is logged and the next one handled.

        It takes the events of timers that are over, too.
        """
        while (event := self._next()) is not self._CLOSED:
            try:
                self.controller.handle(event)  # type: ignore[arg-type]
            except Refused:
                continue  # logged and counted by the controller

    def _next(self) -> object:
        while True:
            self.controller.tick()
            try:
                return self._queue.get(timeout=min(self.controller.timers.values(), default=None))
            except queue.Empty:
                continue  # a timer is over


class AsyncController:
    """A controller for coroutines; it keeps the timers while :meth:`reactions` is awaited.

    Args:
        controller: The controller.
        size: How many events may wait.
    """

    def __init__(self, controller: Controller, size: int = 1024) -> None:
        if size < 1:
            raise ValueError(f"a queue of size {size} found, at least 1 expected")
        self.controller = controller
        self._queue: asyncio.Queue[str | None] = asyncio.Queue(size)
        self._handled = asyncio.Event()

    async def handle(self, event: str) -> tuple[Action, ...]:
        """Handles one event at once, as :meth:`mcpn.runtime.Controller.handle`."""
        self._handled.set()  # it may arm or disarm a timer
        return self.controller.handle(event)

    async def put(self, event: str) -> None:
        """Puts an event, waiting for a free place."""
        await self._queue.put(event)

    def put_nowait(self, event: str) -> None:
        """Puts an event, or raises :class:`QueueFull`."""
        try:
            self._queue.put_nowait(event)
        except asyncio.QueueFull:
            raise QueueFull(f"{event!r}: {self._queue.maxsize} events wait already") from None

    async def close(self) -> None:
        """Ends :meth:`reactions` after the events that wait now."""
        await self._queue.put(None)

    async def reactions(self) -> AsyncIterator[tuple[str, tuple[Action, ...]]]:
        """Each event with its actions, as it is handled, those of timers that are over among them.

        Refused events are logged and passed over.
        """
        getting: asyncio.Future[str | None] | None = None
        handled: asyncio.Future[Literal[True]] | None = None
        try:
            while True:
                for reaction in self.controller.tick():
                    yield reaction
                getting = getting or asyncio.ensure_future(self._queue.get())
                handled = handled or asyncio.ensure_future(self._handled.wait())
                left = min(self.controller.timers.values(), default=None)
                await asyncio.wait((getting, handled), timeout=left, return_when=asyncio.FIRST_COMPLETED)
                if handled.done():
                    self._handled.clear()
                    handled = None
                if not getting.done():
                    continue
                event, getting = getting.result(), None
                if event is None:
                    return
                try:
                    actions = self.controller.handle(event)
                except Refused:
                    continue  # logged and counted by the controller
                yield event, actions
        finally:
            for waiting in (getting, handled):
                if waiting is not None:
                    waiting.cancel()
