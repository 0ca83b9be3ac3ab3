"""A log for programs (one JSON object a line) and a watchdog: both are observers of a controller's steps."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterable, Iterator
from time import monotonic, time
from typing import Any, TextIO

from mcpn.runtime.controller import Step, Where


class Journal:
    """Writes each step as a line of JSON; give it to :meth:`mcpn.runtime.Controller.observe`.

    A line has ``time`` (seconds since 1970), ``event``, ``from`` and ``to`` (``phase``,
    ``section``, ``state``, ``objectives``, ``mode``), ``actions`` (texts, in order) and ``refused``. Each
    line is flushed before any hook is called, so that what a crash leaves says what had been ordered.
    ``mcpn simulate --events`` replays it, and so does the page of ``mcpn report``.

    Args:
        stream: Where to write.
        clock: Tells the time.
    """

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time) -> None:
        self._stream, self._clock = stream, clock

    def __call__(self, step: Step) -> None:
        """Writes a step."""
        self._stream.write(json.dumps({"time": self._clock(), **step_object(step)}) + "\n")
        self._stream.flush()


def step_object(step: Step) -> dict[str, Any]:
    """A step as a JSON object, but for the time."""
    return {
        "event": step.event,
        "from": _place(step.before),
        "to": _place(step.after),
        "actions": [str(action) for action in step.actions],
        "refused": not step.taken,
    }


def _place(where: Where) -> dict[str, Any]:
    return {
        "phase": where.phase,
        "section": where.section,
        "state": where.state,
        "objectives": list(where.inside.objectives),
        "mode": dict(where.inside.mode),
    }


def events_of(lines: Iterable[str]) -> Iterator[tuple[int, str, bool]]:
    """Reads a journal.

    Args:
        lines: Its lines.

    Yields:
        The number of a line, its event, and whether the controller refused it.

    Raises:
        ValueError: A line is none of a journal; its number is the second argument.
    """
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            said = json.loads(line)
            event, refused = said["event"], said["refused"]
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"no line of a journal: {error!r}", number) from error
        if type(event) is not str or type(refused) is not bool:
            raise ValueError("expected an event, a text, and whether it was refused", number)
        yield number, event, refused


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
