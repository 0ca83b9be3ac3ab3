"""Drivers in Python: functions, each on a thread of its own, and coroutines."""

from __future__ import annotations

import asyncio
import importlib
import inspect
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

RAISED = "raised"
"""How a function ends that raises."""


@dataclass(frozen=True)
class Call:
    """What a driver in Python is called with.

    Args:
        activity: The activity, or the name of the source or of the hardware to be released.
        alternative: The alternative that runs.
        objective: The objective that the activity is started for, where one names it.
        parameters: Their texts, by name.
        say: Tells a line; which event that is the file of drivers says.
        stopping: Is set when the driver is to end; a coroutine is cancelled besides.
    """

    activity: str
    alternative: str | None
    objective: str | None
    parameters: Mapping[str, str]
    say: Callable[[str], None]
    stopping: threading.Event = field(default_factory=threading.Event)


def function_of(text: str, folder: Path) -> Callable[[Call], Any]:
    """The function ``module:name``; modules beside the file of drivers are found.

    Raises:
        Exception: What importing raises; ``TypeError`` where the name is of nothing to be called.
    """
    module, _, name = text.partition(":")
    beside = str(folder.resolve())
    if beside not in sys.path:
        sys.path.insert(0, beside)
    function: Callable[[Call], Any] = getattr(importlib.import_module(module), name)
    if not callable(function):
        raise TypeError(f"{name} cannot be called")
    return function


class FunctionDriver:
    """One call of a function.

    Args:
        function: The function, or the coroutine function.
        call: What it is called with.
        ended: Told how it ended: by the text of what it returned, in small letters, or ``raised``.
    """

    def __init__(
        self, function: Callable[[Call], Any], call: Call, ended: Callable[[str, Exception | None], None]
    ) -> None:
        self._function, self._call, self._ended = function, call, ended
        self._task: asyncio.Task[None] | None = None
        self._over = asyncio.Event()
        self._left = False

    async def start(self) -> None:
        """Calls it."""
        if inspect.iscoroutinefunction(self._function):
            self._task = asyncio.create_task(self._awaited())
            self._task.add_done_callback(lambda _: self._over.set())  # also of one that never began
        else:
            loop = asyncio.get_running_loop()
            name = f"driver of {self._call.activity}"
            threading.Thread(target=self._called, args=(loop,), name=name, daemon=True).start()

    async def _awaited(self) -> None:
        try:
            how, error = _text(await self._function(self._call)), None
        except Exception as raised:
            how, error = RAISED, raised
        self._ended(how, error)

    def _called(self, loop: asyncio.AbstractEventLoop) -> None:
        error: Exception | None = None
        try:
            how = _text(self._function(self._call))
        except Exception as raised:
            how, error = RAISED, raised

        def over() -> None:
            self._over.set()
            self._ended(how, error)

        if not loop.is_closed():
            loop.call_soon_threadsafe(over)

    def kill(self) -> None:
        """Ends the wait for its end: nothing can end a function."""
        self._left = True
        self._over.set()

    async def stop(self, grace: float) -> bool:
        """Asks it to end, and waits.

        Returns:
            Whether it has ended in time; a function that does not end cannot be made to.
        """
        self._call.stopping.set()
        if self._task is not None:
            self._task.cancel()
        try:
            await asyncio.wait_for(self._over.wait(), grace)
        except TimeoutError:
            return False
        return not self._left


def _text(value: object) -> str:
    return str(value).lower()
