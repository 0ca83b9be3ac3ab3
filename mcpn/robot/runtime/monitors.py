"""Monitors: take the events of a mission one at a time, and decide which requirements are violated."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcpn.robot.runtime.documents import MONITOR, MONITORS, MONITORS_VERSION
from mcpn.robot.runtime.file_schema import ControllerFileError, check_digest, fits, parsed
from mcpn.robot.runtime.journal import JournalError, read_journal

VALUES = ("violated", "satisfied", "open")
VIOLATED = VALUES[0]

_log = logging.getLogger("mcpn.robot.runtime")


@dataclass(frozen=True, slots=True)
class Decision:
    """An event after which a requirement is violated or satisfied, whatever events follow.

    Args:
        requirement: Its name.
        words: What it says.
        value: ``violated`` or ``satisfied``.
        number: The number of the event, from 1; 0 where it is known before the first.
        event: The event.
    """

    requirement: str
    words: str
    value: str
    number: int
    event: str

    def __str__(self) -> str:
        where = f"event {self.number}, {self.event}" if self.number else "before the first event"
        return f"{self.value} by {where}: {self.requirement}: {self.words}"


class Monitors:
    """The monitors of a mission.

    Args:
        document: The JSON object of a file of monitors.
        on_found: Called with each finding.

    Raises:
        ControllerFileError: The document is not one of monitors.

    Attributes:
        findings: What has been found, in the order of the events.
        unknown: Events that are none of the mission, with their numbers.
    """

    def __init__(
        self, document: Mapping[str, Any], *, on_found: Callable[[Decision], object] | None = None
    ) -> None:
        if (document.get("format"), document.get("version")) != (MONITORS, MONITORS_VERSION):
            found = f"{document.get('format')} of version {document.get('version')}"
            raise ControllerFileError(f"expected {MONITORS} of version {MONITORS_VERSION}, found {found}")
        fits(document, MONITOR.shape)
        self.digest = check_digest(document)
        self.mission: str = document["mission"]
        self._events = {event: number for number, event in enumerate(document["events"])}
        self._monitors = [_Machine(each, len(self._events)) for each in document["monitors"]]
        self._on_found = on_found
        self.restart()

    @classmethod
    def load(cls, path: str | Path, **options: Any) -> Monitors:
        """Reads monitors from their JSON file.

        Args:
            path: The file.
            **options: As for the class.

        Raises:
            ControllerFileError: The file is none of monitors.
        """
        try:
            return cls(parsed(Path(path).read_bytes()), **options)
        except (OSError, ControllerFileError) as error:
            raise ControllerFileError(f"{path}: {error}") from error

    def restart(self) -> None:
        """Begins again, before the first event."""
        self.count = 0
        self.findings: list[Decision] = []
        self.unknown: list[tuple[int, str]] = []
        for machine in self._monitors:
            machine.state = 0
            if machine.value != VALUES[2]:
                self._found(machine, "")

    @property
    def values(self) -> Mapping[str, str]:
        """By requirement ``violated``, ``satisfied`` or ``open``."""
        return {machine.name: machine.value for machine in self._monitors}

    @property
    def violated(self) -> tuple[str, ...]:
        """The requirements that are violated."""
        return tuple(machine.name for machine in self._monitors if machine.value == VIOLATED)

    @property
    def state(self) -> dict[str, int]:
        """Where they are, to be given to :meth:`resume`: by requirement a number, and how many events."""
        return {"": self.count, **{machine.name: machine.state for machine in self._monitors}}

    def resume(self, state: Mapping[str, int]) -> None:
        """Goes on from where monitors of the same file were; findings of before are not made again.

        Raises:
            ValueError: The state is not of these monitors; nothing has changed.
        """
        most = {machine.name: machine.most for machine in self._monitors}
        if state.keys() != {"", *most} or any(type(n) is not int or n < 0 for n in state.values()):
            raise ValueError("the state is not of these monitors")
        if any(state[name] > last for name, last in most.items()):
            raise ValueError("the state is of no such monitor")
        self.count = state[""]
        for machine in self._monitors:
            machine.state = state[machine.name]

    def take(self, event: str) -> tuple[Decision, ...]:
        """Takes an event that has happened.

        Returns:
            What it decides. An event that is none of the mission changes nothing, and is noted.
        """
        self.count += 1
        number = self._events.get(event)
        if number is None:
            self.unknown.append((self.count, event))
            return ()
        before = len(self.findings)
        for machine in self._monitors:
            if machine.take(number):
                self._found(machine, event)
        return tuple(self.findings[before:])

    def _found(self, machine: _Machine, event: str) -> None:
        finding = Decision(machine.name, machine.words, machine.value, self.count, event)
        self.findings.append(finding)
        if finding.value == VIOLATED:
            _log.warning("%s", finding)
        if self._on_found is not None:
            self._on_found(finding)


class _Machine:
    """One monitor: a state, and where events lead."""

    def __init__(self, document: Mapping[str, Any], events: int) -> None:
        self.name, self.words = document["name"], document["words"]
        values, moves = document["values"], document["moves"]
        if not values or len(values) != len(moves):
            raise ControllerFileError(f"monitor {self.name} has {len(values)} values, {len(moves)} states")
        every = [move for moves_of_state in moves for move in moves_of_state]
        if any(len(move) != 2 or move[0] >= events for move in every):
            raise ControllerFileError(f"monitor {self.name} names an event that there is not")
        if any(to >= len(values) for _, to in every):
            raise ControllerFileError(f"monitor {self.name} leads to a state that there is not")
        self._values = [VALUES[value] for value in values]
        self._moves: list[dict[int, int]] = [dict(moves_of_state) for moves_of_state in moves]
        self.state = 0

    @property
    def value(self) -> str:
        """What is known."""
        return self._values[self.state]

    @property
    def most(self) -> int:
        """The last state."""
        return len(self._values) - 1

    def take(self, event: int) -> bool:
        """Takes an event; whether that decides."""
        before = self.value
        self.state = self._moves[self.state].get(event, self.state)
        return self.value != before


def watch(monitors: Monitors, lines: Iterable[str]) -> None:
    """Gives monitors the events of a log, from their start.

    A log is a journal, of which refused events count for nothing, or has an event in each line: what stands
    in brackets at its end, else its last word; ``#`` begins a comment.

    Raises:
        JournalError: A line has no event of the mission, or is none of a journal.
    """
    lines = [*lines]
    first = next((line for line in lines if line.strip()), "")
    for number, event in _in_journal(lines) if first.lstrip().startswith("{") else _in_lines(lines):
        monitors.take(event)
        if monitors.unknown:
            raise JournalError(f"{event!r} is no event of the mission", number)


def _in_journal(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    yield from ((told.line, told.event) for told in read_journal(lines) if not told.refused)


def _in_lines(lines: Iterable[str]) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if text and not text.startswith("#"):
            in_brackets = text.endswith("]") and "[" in text
            yield number, text[text.rindex("[") + 1 : -1] if in_brackets else text.split()[-1]


def told(monitors: Monitors) -> Iterator[str]:
    """What monitors have found, a line each: first what was decided, then what is open."""
    yield from map(str, monitors.findings)
    still = (name for name, value in monitors.values.items() if value == VALUES[2])
    yield from (f"open after {monitors.count} events: {name}" for name in still)
