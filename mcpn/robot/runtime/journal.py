"""A log for programs (one JSON object a line) and a watchdog: both are observers of a controller's steps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from time import monotonic, time
from typing import Any, Protocol

from mcpn.robot.runtime.controller import Step, Where
from mcpn.robot.runtime.documents import RESUMED, STEP
from mcpn.robot.runtime.file_schema import DamagedFile, fits, parsed, signed_line


class Written(Protocol):
    """What a journal is written to: a text file, for one."""

    def write(self, text: str, /) -> object:
        """Takes a line."""

    def flush(self) -> None:
        """Has it written."""


class Journal:
    """Writes each step as a line of JSON; give it to :meth:`mcpn.robot.runtime.Controller.observe`.

    A line has ``time`` (seconds since 1970), ``number`` (of the event, from 1), ``event``, ``from`` and
    ``to`` (``phase``, ``section``, ``state``, ``objectives``, ``mode``), ``actions`` (texts, in order),
    ``refused`` and the ``digest`` of all this. Each line is flushed before any hook is called, so that what a
    crash leaves says what had been ordered.
    ``mcpn simulate --events`` replays it, and so does the page of ``mcpn report``.

    Args:
        stream: Where to write.
        clock: Tells the time.
    """

    def __init__(self, stream: Written, clock: Callable[[], float] = time) -> None:
        self._stream, self._clock = stream, clock

    def __call__(self, step: Step) -> None:
        """Writes a step."""
        self._write({"number": step.number, **step_object(step)})

    def resumed(self, number: int) -> None:
        """Writes that a run goes on behind an event."""
        self._write({"resumed": number})

    def _write(self, said: Mapping[str, Any]) -> None:
        self._stream.write(signed_line({"time": self._clock(), **said}) + "\n")
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


@dataclass(frozen=True, slots=True)
class JournalLine:
    """An event in a journal.

    Args:
        line: The number of its line, from 1.
        event: Its text.
        refused: Whether the controller refused it.
        number: The number of the event, where the journal says it.
    """

    line: int
    event: str
    refused: bool
    number: int | None


class JournalError(DamagedFile):
    """A line is none of a journal.

    Attributes:
        line: Its number.
    """

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


def read_journal(lines: Iterable[str]) -> Iterator[JournalLine]:
    """The events of a journal; lines that say that a run was resumed are passed over.

    Args:
        lines: Its lines.

    Raises:
        JournalError: A line is none of a journal, or has been changed since it was written.
    """
    for line, text in enumerate(lines, 1):
        if not text.strip():
            continue
        try:
            said = parsed(text)
            resumed = "resumed" in said
            fits(said, RESUMED if resumed else STEP)
        except DamagedFile as error:
            raise JournalError(f"no line of a journal: {error}", line) from error
        if "digest" in said and text.strip() != signed_line(said):
            raise JournalError("the line has been changed since it was written: its digest is another", line)
        if not resumed:
            yield JournalLine(line, said["event"], said["refused"], said.get("number"))


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
