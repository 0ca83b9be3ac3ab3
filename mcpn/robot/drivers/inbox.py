"""What a driver tells, in its order; the loop takes it in batches, between which others have their turn."""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress

BATCH = 100
"""Lines of one driver that are taken before others have their turn, and timers and signals theirs."""
MOST = 1000
"""Lines that may wait; whoever writes more of them has to wait."""
PAUSE = 0.01
"""Seconds between two looks whether lines can be taken again."""
LONGEST = 1 << 16
"""Bytes of a line at most."""


class Inbox:
    """Lines that wait to be taken; made on the loop's thread, filled from any.

    Args:
        take: Called with each line on the loop's thread.
        ready: Whether lines can be taken now.
    """

    def __init__(self, take: Callable[[str], None], ready: Callable[[], bool]) -> None:
        self._take, self._ready = take, ready
        self._loop = asyncio.get_running_loop()
        self._thread = threading.get_ident()
        self._changed = threading.Condition()
        self._waiting: deque[str | Callable[[], None]] = deque()
        self._due = False
        self._closed = False

    @property
    def full(self) -> bool:
        """Whether who tells lines is to wait."""
        return len(self._waiting) >= MOST

    def put(self, told: str | Callable[[], None]) -> None:
        """Puts a line, or what is to be called after the lines before it.

        A thread other than the loop's waits while too many lines do.
        """
        with self._changed:
            if threading.get_ident() != self._thread:
                self._changed.wait_for(lambda: self._closed or not self.full)
            if self._closed and isinstance(told, str):
                return
            self._waiting.append(told)
            if self._due:
                return
            self._due = True
        with suppress(RuntimeError):  # the loop is closed: nobody takes anything any more
            self._loop.call_soon_threadsafe(self._hand_on)

    def close(self) -> None:
        """Forgets the lines that wait, and those to come; what is to be called still is."""
        with self._changed:
            self._closed = True
            calls = [told for told in self._waiting if not isinstance(told, str)]
            self._waiting = deque(calls)
            self._changed.notify_all()

    def _hand_on(self) -> None:
        for _ in range(BATCH):
            if not self._closed and not self._ready():
                self._loop.call_later(PAUSE, self._hand_on)
                return
            with self._changed:
                if not self._waiting:
                    self._due = False
                    return
                told = self._waiting.popleft()
                self._changed.notify_all()
            if isinstance(told, str):
                self._take(told)
            else:
                told()
        self._loop.call_soon(self._hand_on)


class Splitter:
    """Makes lines of pieces of bytes; a line that is too long is left out as a whole.

    Args:
        longest: Bytes of a line at most.
        too_long: Called once for each line that is left out.
    """

    def __init__(self, longest: int, too_long: Callable[[], None]) -> None:
        self._longest, self._too_long = longest, too_long
        self._rest = b""
        self._skipping = False

    def lines(self, data: bytes) -> list[str]:
        """The lines that end in a piece; the piece ``b""`` ends the last line."""
        *ended, rest = (self._rest + data).split(b"\n") if data else (self._rest, b"")
        found = []
        for line in ended:
            if len(line) > self._longest and not self._skipping:
                self._too_long()
            elif not self._skipping and (line or data):
                found.append(line.decode(errors="replace").rstrip("\r"))
            self._skipping = False
        self._rest = rest
        if len(rest) > self._longest:
            if not self._skipping:
                self._too_long()
            self._skipping = True
        if self._skipping:
            self._rest = b""
        return found
