"""Events from several threads, and from coroutines: both hand them to the controller one by one."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable
from typing import Literal

from mcpn.robot.runtime.actions import Action, Refused
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.hooks import HookErrors, OnError, settle


class QueueFull(Exception):
    """An event was put in a queue that is full; it has not been taken, its sender decides what to do."""


class QueueClosed(Exception):
    """An event was put in a queue that has been closed; it has not been taken."""


def element_of(event: str) -> str:
    """The element that an event belongs to: ``GPS`` for ``GPS_EV_OOS`` and ``GPS_EV_RD``."""
    return event.rpartition("_EV_")[0] or event


class EventQueue:
    """Events that any thread puts and one thread handles.

    Events of one element (a hardware resource, an objective) are handled in the order in which they came,
    and so are all that are equally urgent. A more urgent event comes before others that wait, and with it
    those of its element that wait before it: no event is dropped, and a resource that failed last is out of
    service last. The mission is verified for events in every order, so also for this one.

    Args:
        controller: Who handles them.
        size: How many may wait.
        on_error: What becomes of hooks that fail: ``log`` them and go on, ``stop``, or call a function with
            each :class:`mcpn.robot.runtime.HookError`.
        urgency: Says of an event how urgent it is, the larger the more; all alike by default.
    """

    def __init__(
        self,
        controller: Controller,
        size: int = 1024,
        *,
        on_error: OnError = "log",
        urgency: Callable[[str], float] | None = None,
    ) -> None:
        if size < 1:
            raise ValueError(f"a queue of size {size} found, at least 1 expected")
        self.controller = controller
        self.size = size
        self._on_error = on_error
        self._urgency = urgency
        self._changed = threading.Condition()
        self._closed = False
        self._waiting = 0
        self._came = 0
        # By element, its events with the number in which they came and how urgent they are.
        self._by_element: dict[str, deque[tuple[int, float, str]]] = {}

    def put(self, event: str, timeout: float = 0.0) -> None:
        """Puts an event.

        Args:
            event: Its text.
            timeout: How many seconds to wait for a free place.

        Raises:
            QueueFull: None became free.
            QueueClosed: The queue has been closed.
        """
        urgency = 0.0 if self._urgency is None else self._urgency(event)
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._waiting < self.size, timeout or 0.0)
            if self._closed:
                raise QueueClosed(f"{event!r}: the queue has been closed")
            if self._waiting >= self.size:
                raise QueueFull(f"{event!r}: {self.size} events wait already")
            element = "" if self._urgency is None else element_of(str(event))
            self._by_element.setdefault(element, deque()).append((self._came, urgency, event))
            self._came += 1
            self._waiting += 1
            self._changed.notify_all()

    def close(self) -> None:
        """Lets :meth:`run` return after the events that wait now; later ones are refused."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def waiting(self) -> int:
        """How many events wait."""
        with self._changed:
            return self._waiting

    def run(self) -> None:
        """Handles events until the queue is closed; a refused event is logged and the next one handled.

        It takes the events of timers that are over, too.

        Raises:
            HookErrors: Hooks have failed and ``on_error`` is ``stop``. The events that wait still do: called
                again, it goes on with them.
        """
        while (event := self._next()) is not None:
            try:
                self.controller.handle(event)
            except Refused:
                continue  # logged and counted by the controller
            except HookErrors as failed:
                settle(failed, self._on_error)

    def _next(self) -> str | None:
        """The next event, that of a timer that is over before others; ``None`` in a closed, empty queue."""
        while True:
            # The controller is asked before the queue is locked: a hook may put an event while it is locked.
            if (over := self.controller.overdue) is not None:
                return over
            left = min(self.controller.timers.values(), default=None)
            with self._changed:
                if self._changed.wait_for(lambda: self._closed or self._waiting, left):
                    return self._first() if self._waiting else None

    def _first(self) -> str:
        """Takes out what is handled next."""

        def rank(element: str) -> tuple[float, int]:
            waiting = self._by_element[element]
            return -max(urgency for _, urgency, _ in waiting), waiting[0][0]

        element = (
            min(self._by_element, key=rank) if len(self._by_element) > 1 else next(iter(self._by_element))
        )
        _, _, event = self._by_element[element].popleft()
        if not self._by_element[element]:
            del self._by_element[element]
        self._waiting -= 1
        self._changed.notify_all()
        return event


class AsyncController:
    """A controller for coroutines: hooks that are coroutines are awaited, one after the other.

    It keeps the timers while :meth:`reactions` is awaited.

    Args:
        controller: The controller.
        size: How many events may wait.
        on_error: What becomes, in :meth:`reactions`, of hooks that fail; as for :class:`EventQueue`.
    """

    def __init__(self, controller: Controller, size: int = 1024, *, on_error: OnError = "log") -> None:
        if size < 1:
            raise ValueError(f"a queue of size {size} found, at least 1 expected")
        self.controller = controller
        self._on_error = on_error
        self._turn = asyncio.Lock()
        self._handled = asyncio.Event()
        self._queue: asyncio.Queue[str | None] = asyncio.Queue(size)

    async def handle(self, event: str) -> tuple[Action, ...]:
        """Handles one event, as :meth:`mcpn.robot.runtime.Controller.handle`, when those before it are done.

        Raises:
            Refused: It cannot be taken now.
            HookErrors: Hooks have failed; the event has been taken all the same.
        """
        async with self._turn:
            actions, failed = self.controller.react(event)
            self._handled.set()  # it may have armed or disarmed a timer
            await self.controller.hooks.await_each(event, actions, failed)
            return actions

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

        Raises:
            HookErrors: Hooks have failed and ``on_error`` is ``stop``.
        """
        getting: asyncio.Future[str | None] | None = None
        handled: asyncio.Future[Literal[True]] | None = None
        try:
            while True:
                event = self.controller.overdue
                if event is None:
                    getting = getting or asyncio.ensure_future(self._queue.get())
                    handled = handled or asyncio.ensure_future(self._handled.wait())
                    left = min(self.controller.timers.values(), default=None)
                    both = (getting, handled)
                    await asyncio.wait(both, timeout=left, return_when=asyncio.FIRST_COMPLETED)
                    if handled.done():
                        self._handled.clear()
                        handled = None
                    if not getting.done():
                        continue
                    event, getting = getting.result(), None
                    if event is None:
                        return
                try:
                    actions = await self.handle(event)
                except Refused:
                    continue  # logged and counted by the controller
                except HookErrors as failed:
                    settle(failed, self._on_error)
                    actions = self.controller.log[-1].actions
                yield event, actions
        finally:
            for waiting in (getting, handled):
                if waiting is not None:
                    waiting.cancel()
