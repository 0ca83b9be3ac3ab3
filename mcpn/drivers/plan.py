"""What a file of drivers says: what each activity is, and what it tells."""

from __future__ import annotations

import re
import signal
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

Kind = Literal["process", "python", "mqtt", "zenoh", "nothing"]
KINDS: tuple[Kind, ...] = ("process", "python", "mqtt", "zenoh", "nothing")

SUCCESS, FAILURE = "success", "failure"
"""Of the objective that an activity is started for."""
OTHER = "other"
"""However a driver ends that has no line of its own."""

Repeat = Literal["fail", "safe", "ask"]
REPEATS: tuple[Repeat, ...] = ("fail", "safe", "ask")
"""What becomes of an objective whose activity had begun when a run was interrupted: it fails, the activity is
begun again, or a person is asked."""

Place = tuple[str, ...]
"""Keys that lead to a value in a file of drivers."""

_HOLE = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class Topics:
    """Where a driver that is reached by messages listens and speaks.

    Args:
        start: Where to publish that it starts; nowhere if ``None``.
        stop: Where to publish that it stops.
        says: What to subscribe to while it runs.
    """

    start: str | None = None
    stop: str | None = None
    says: str | None = None

    @property
    def texts(self) -> tuple[str, ...]:
        """All of them that there are."""
        return tuple(text for text in (self.start, self.stop, self.says) if text is not None)


@dataclass(frozen=True)
class DriverSpec:
    """What one activity (or one alternative, a source of events, a release) is.

    Args:
        place: Where it stands in the file.
        kind: Which sort.
        command: Of a process: its arguments, with holes such as ``{objective}``.
        function: Of Python: ``module:name``.
        topics: Of messages.
        lines: By regular expression that a whole line or message is to match, the event that it tells.
        ends: By exit status or returned value, the event that it tells.
        stop: The signal that asks a process to end.
        grace: Seconds that it may take to end.
        repeat: Whether it may be begun again when a run goes on in which it had begun for an objective.
    """

    place: Place
    kind: Kind
    command: tuple[str, ...] = ()
    function: str = ""
    topics: Topics = field(default_factory=Topics)
    lines: Mapping[str, str] = field(default_factory=dict)
    ends: Mapping[str, str] = field(default_factory=dict)
    stop: signal.Signals = signal.SIGTERM
    grace: float = 5.0
    repeat: Repeat = "fail"

    @property
    def tells(self) -> set[str]:
        """All that it may tell."""
        return {*self.lines.values(), *self.ends.values()}

    @property
    def holes(self) -> set[str]:
        """Names that its texts leave to be filled in."""
        return {name for text in (*self.command, *self.topics.texts) for name in _HOLE.findall(text)}

    def of_line(self, line: str) -> str | None:
        """What a line tells: that of the first expression that matches all of it."""
        return next((event for text, event in self.lines.items() if re.fullmatch(text, line)), None)

    def of_end(self, how: str) -> str | None:
        """What an end tells."""
        return self.ends.get(how, self.ends.get(OTHER))


def filled(text: str, values: Mapping[str, str]) -> str:
    """A text with its holes filled."""
    return _HOLE.sub(lambda hole: values.get(hole[1], hole[0]), text)


@dataclass(frozen=True)
class Plan:
    """A file of drivers.

    Args:
        file: Its path.
        lines: By place of a value, its line.
        activities: By activity and alternative, the driver; the alternative is ``None`` for all others.
        sources: What runs all the time and tells events, by name.
        releases: By hardware, what releases it.
        never: Events that nothing on this robot tells; ``*`` stands for any text.
        mqtt: Options of the connection.
        zenoh: Options of the session.
    """

    file: Path
    lines: Mapping[Place, int]
    activities: Mapping[tuple[str, str | None], DriverSpec]
    sources: Mapping[str, DriverSpec]
    releases: Mapping[str, DriverSpec]
    never: tuple[str, ...]
    mqtt: Mapping[str, str | int]
    zenoh: Mapping[str, str | tuple[str, ...]]

    @property
    def specs(self) -> tuple[DriverSpec, ...]:
        """All drivers."""
        return (*self.activities.values(), *self.sources.values(), *self.releases.values())

    def line(self, place: Place) -> int | None:
        """The line of a place, or of the nearest table around it."""
        while place and place not in self.lines:
            place = place[:-1]
        return self.lines.get(place)

    def driver(self, activity: str, alternative: str) -> DriverSpec | None:
        """What runs an alternative of an activity."""
        return self.activities.get((activity, alternative)) or self.activities.get((activity, None))
