"""A log for programs, one JSON object a line: it observes a controller's steps."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from time import time
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
