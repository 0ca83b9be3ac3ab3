"""A watchdog: it observes a controller's steps, and calls an alarm where none comes for a time."""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic

from mcpn.robot.runtime.controller import Step


class Watchdog:
    """Calls an alarm when a controller has taken no event for a time; give it to ``Controller.observe``.

    Args:
        seconds: How long may pass without an event that is taken.
        alarm: Called, on a thread of its own, once for each silence, with its length in seconds.
    """

    def __init__(self, seconds: float, alarm: Callable[[float], object]) -> None:
        if not seconds > 0:
            raise ValueError(f"a watchdog of {seconds} seconds found, more than 0 expected")
        self._seconds, self._alarm = seconds, alarm
        self._changed = threading.Condition()
        self._last: float | None = monotonic()
        self._closed = False
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def __call__(self, step: Step) -> None:
        """Begins to wait again, unless the event was refused."""
        if step.taken:
            with self._changed:
                self._last = monotonic()
                self._changed.notify()

    def close(self) -> None:
        """Ends the watch and its thread."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _watch(self) -> None:
        while True:
            with self._changed:
                if self._closed:
                    return
                if self._last is None:  # the alarm was called: the next event begins another silence
                    self._changed.wait()
                    continue
                silence = monotonic() - self._last
                if silence < self._seconds:
                    self._changed.wait(self._seconds - silence)
                    continue
                self._last = None
            self._alarm(silence)
