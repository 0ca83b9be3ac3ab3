"""Actions that take turns: those that need the same thing one after the other, all others side by side."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection

SOON = 0.2
"""Seconds that something may have to wait before that is worth saying."""


class Turns:
    """Tasks in the order in which they were asked for, as far as they need the same things."""

    def __init__(self) -> None:
        self._changes: dict[str, asyncio.Task[None]] = {}
        self._uses: dict[str, list[asyncio.Task[None]]] = {}
        self._all: set[asyncio.Task[None]] = set()

    @property
    def busy(self) -> bool:
        """Whether something is under way."""
        return bool(self._all)

    def begin(
        self,
        work: Callable[[], Awaitable[None]],
        changes: Collection[str],
        uses: Collection[str] = (),
        waits: Callable[[list[str]], None] = lambda names: None,
    ) -> asyncio.Task[None]:
        """Begins a task when those before it that it depends on are done.

        Args:
            work: What is to be done.
            changes: What it alone may have meanwhile; what is waited for is told by the first that names it.
            uses: What others may use at the same time, and nobody may change.
            waits: Called with what it has to wait for, if that takes long.
        """
        before: dict[asyncio.Task[None], str] = {}
        for name in (*changes, *uses):
            if (task := self._changes.get(name)) is not None and not task.done():
                before.setdefault(task, name)
        for name in changes:
            for task in self._uses.pop(name, ()):
                if not task.done():
                    before.setdefault(task, name)

        async def turn() -> None:
            if before:
                _, still = await asyncio.wait(before, timeout=SOON)
                if still:
                    waits(sorted({before[task] for task in still}))
                    await asyncio.wait(still)
            await work()

        task = asyncio.create_task(turn())
        self._changes |= dict.fromkeys(changes, task)
        for name in uses:
            using = [other for other in self._uses.get(name, ()) if not other.done()]
            self._uses[name] = [*using, task]
        self._all.add(task)
        task.add_done_callback(self._all.discard)
        return task

    async def over(self) -> None:
        """Waits until nothing is under way."""
        while self._all:
            await asyncio.wait(self._all)
