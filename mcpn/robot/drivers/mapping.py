"""What a file of drivers says of each activity: how it is run, told and stopped, and what by default."""

from __future__ import annotations

import re
import signal
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Literal

from mcpn.did_you_mean import did_you_mean
from mcpn.errors import InputError, Problem, Source
from mcpn.events import Event, What
from mcpn.robot.drivers.functions import function_of
from mcpn.robot.drivers.processes import program_of
from mcpn.robot.runtime.actions import START, spelled
from mcpn.robot.runtime.controller_tables import Tables

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
    zenoh: Mapping[str, bool | str | tuple[str, ...]]

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


# Holds a file of drivers against a mission's controller: what runs each activity, what tells each event.

HOLES = ("activity", "alternative", "objective", "run", "python")
"""Holes that are no parameters: ``run`` is the number of the start, ``python`` the interpreter of mcpn."""
WILDCARDS = "+#*$?\0"
"""What means more than itself in a topic of MQTT or a key of zenoh."""
ENDINGS = {SUCCESS: What.SUCCESS, FAILURE: What.FAILURE}
"""By word, what happens."""


def ending(objective: str, word: str) -> str:
    """The event of an objective that ``success`` or ``failure`` stands for, or ``failure REASON``."""
    how, _, reason = word.partition(" ")
    return str(Event(ENDINGS[how], objective, reason))


def is_ending(word: str) -> bool:
    """Whether a word stands for an end of the objective that an activity is started for."""
    return word in ENDINGS or word.startswith(f"{FAILURE} ")


def endings(known: Iterable[str]) -> dict[str, dict[str, str]]:
    """By objective the events with which it ends that its activities may tell, each with its word.

    Args:
        known: All events of the controller.
    """
    found: dict[str, dict[str, str]] = {}
    for text in known:
        event = Event.parse(text)
        if (word := ended(event)) is not None:
            found.setdefault(event.element, {})[text] = word
    return found


def ended(event: Event) -> str | None:
    """What a driver says for an end of an objective; ``None`` for other events."""
    how = next((word for word, what in ENDINGS.items() if what is event.what), None)
    return how and f"{how} {event.reason}".rstrip()


def event_of(text: str, known: Collection[str]) -> str | None:
    """The event that a file of drivers names: by its text, or one that the mission declares by its name."""
    event = next((each for each in (text, str(Event(What.DECLARED, text))) if each in known), text)
    return event if (event := spelled(event, known)) in known else None


def check_plan(plan: Plan, tables: Tables) -> None:
    """Holds a file of drivers against a mission's controller.

    Raises:
        InputError: An activity has no driver, an event is told by none, or a driver names what is not there.
    """
    check = _Check(plan, tables)
    problems = [*check.names(), *check.drivers(), *check.events(), *check.whole()]
    if problems:
        raise InputError(
            Problem(Source(str(plan.file), line), message)
            for line, message in sorted(problems, key=lambda told: (told[0] is None, told[0] or 0, told[1]))
        )


Found = Iterator[tuple[int | None, str]]


class _Check:
    def __init__(self, plan: Plan, tables: Tables) -> None:
        self.plan, self.tables = plan, tables
        self.laws = tables.laws
        self.objectives: dict[str, list[str]] = {}
        for name, row in self.laws.objectives.items():
            for activity in row["activities"]:
                self.objectives.setdefault(activity, []).append(name)
        self.endings = endings(tables.known)
        rows = self.laws.activities.items()
        self.unused = {name for name, row in rows if not row["produces"] and name not in self.objectives}
        """Activities of the robot that this mission has no use for."""

    def _at(self, place: Place, message: str) -> tuple[int | None, str]:
        return self.plan.line(place), message

    def names(self) -> Found:
        """Activities, alternatives and hardware that are not there."""
        for activity, way in self.plan.activities:
            place: Place = ("activities", activity)
            if activity not in self.laws.activities:
                yield self._at(place, self._unknown("activity", activity, self.laws.activities))
            elif way is not None and way not in (ways := self.laws.activities[activity]["alternatives"]):
                found = self._unknown(f"alternative of {activity}", way, ways)
                yield self._at((*place, "alternatives", way), found)
        every = {what for ways in self._alternatives() for what in ways[2]["consumes"]}
        for hardware in self.plan.releases:
            if hardware not in every:
                yield self._at(("release", hardware), self._unknown("hardware", hardware, every))

    def _unknown(self, kind: str, name: str, known: Iterable[str]) -> str:
        return f"the mission's controller has no {kind} {name!r}{did_you_mean(name, known)}"

    def _alternatives(self) -> Iterator[tuple[str, str, dict[str, list[str]]]]:
        for name, row in self.laws.activities.items():
            for way, spec in row["alternatives"].items():
                yield name, way, spec

    def drivers(self) -> Found:
        """Alternatives without a driver, holes without a value, commands and functions that are not there."""
        missing = dict[str, list[str]]()
        for activity, way, _ in self._alternatives():
            spec = self.plan.driver(activity, way)
            if spec is None:
                missing.setdefault(activity, []).append(way)
                continue
            if activity in self.unused:
                continue
            for objective in self.objectives.get(activity, [None]):
                given = {value.name for value in self.laws.of(activity, way, objective)} | {*HOLES}
                given -= {"objective"} if objective is None else set()
                for hole in sorted(spec.holes - given):
                    who = activity if objective is None else f"{activity}, for objective {objective},"
                    message = f"{{{hole}}}: {who} has no such parameter{did_you_mean(hole, given)}"
                    yield self._at(spec.place, message)
                yield from self._values(spec, activity, way, objective)
        for activity, ways in missing.items():
            place = "activities", activity
            if (activity, None) in self.plan.activities or place in self.plan.lines:
                yield self._at(
                    place, f"no driver for the alternatives {', '.join(ways)} of activity {activity}"
                )
            else:
                yield None, f"no driver for activity {activity}: expected a table [activities.{activity}]"
        for spec in (*self.plan.sources.values(), *self.plan.releases.values()):
            for hole in sorted(spec.holes - {"run", "python"}):
                yield self._at(spec.place, f"{{{hole}}}: {'.'.join(spec.place)} belongs to no activity")

    def _values(self, spec: DriverSpec, activity: str, way: str, objective: str | None) -> Found:
        """Values of the mission that would be more than values in a command or a topic."""
        values = {value.name: value.value for value in self.laws.of(activity, way, objective)}
        who = activity if objective is None else f"{activity}, for objective {objective}"
        for text in spec.command:
            found = filled(text, values)
            if found.startswith("-") and not text.startswith("-"):
                yield self._at(spec.place, f"{text}: {who}: {found!r} would be an option of the program")
        for text, what in _run_as_code(spec.command):
            if filled(text, values) != text:
                yield self._at(
                    spec.place,
                    f"{text[:80]!r}: {who}: a value of the mission would be part of {what}: "
                    "give it as an argument of its own",
                )
        for text in spec.topics.texts:
            found = filled(text, values)
            if found != text and any(found.count(sign) > text.count(sign) for sign in WILDCARDS):
                yield self._at(spec.place, f"{text}: {who}: {found!r} would add a wildcard to the topic")

    def whole(self) -> Found:
        """What is not on this machine."""
        told = set[Place]()
        for spec in self.plan.specs:
            if spec.kind == "python":
                try:
                    function_of(spec.function, self.plan.file.parent)
                except Exception as error:  # whatever a module raises that is imported
                    yield self._at(spec.place, f"{spec.function}: {type(error).__name__}: {error}")
            elif spec.kind == "process" and "{" not in (command := spec.command[0]):
                found = program_of(self.plan.file.parent, command)
                if found is None and spec.place not in told:
                    told.add(spec.place)
                    yield self._at(spec.place, f"process: no program {command!r} is found")

    def events(self) -> Found:
        """Events that a driver names and that are not there, and those that nobody tells."""
        known, may_end = self.tables.known, self.objectives.keys() | self.unused
        told = set[str]()
        for spec in self.plan.specs:
            for key, rows in (("lines", spec.lines), ("ends", spec.ends)):
                for text, event in rows.items():
                    place = (*spec.place, key, text)
                    if is_ending(event):
                        if not (spec.place[0] == "activities" and spec.place[1] in may_end):
                            yield self._at(place, f"{event}: {'.'.join(spec.place)} belongs to no objective")
                        elif event not in ENDINGS:
                            yield from self._reason(place, event, spec.place[1])
                    elif (found := event_of(event, known)) is None:
                        hint = did_you_mean(event, [*ENDINGS, *known])
                        yield self._at(place, f"{event!r} is no event of the mission's controller{hint}")
                    elif found.endswith("_EV_TIMEOUT"):
                        yield self._at(place, f"{event}: the controller's own timers report this")
                    else:
                        told.add(found)
        for name, row in self.laws.objectives.items():
            told |= {event for event, word in self.endings.get(name, {}).items() if self._ends(row, word)}
        for text in self.plan.never:
            named = event_of(text, known) or text
            if not any(fnmatchcase(event, named) for event in known):
                yield self._at(("never",), f"never: {text!r} is no event of the mission's controller")
            told |= {event for event in known if fnmatchcase(event, named)}
        for event in sorted(known - told - {START}):
            if not event.endswith("_EV_TIMEOUT"):
                yield None, f"no driver reports the event {event}: name it in one, or in never"

    def _reason(self, place: Place, word: str, activity: str) -> Found:
        """A reason for which no objective fails that the activity is started for."""
        objectives = self.objectives.get(activity, [])
        known = {each for name in objectives for each in self.endings.get(name, {}).values()}
        if word not in known:
            message = f"no objective that runs {activity} fails for this reason{did_you_mean(word, known)}"
            yield self._at(place, f"{word}: {message}")

    def _ends(self, row: dict[str, list[str]], word: str) -> bool:
        """Whether some activity of an objective tells how it ends, whichever alternative runs."""
        return any(
            all(
                (spec := self.plan.driver(activity, way)) is not None and word in spec.tells
                for way in self.laws.activities[activity]["alternatives"]
            )
            for activity in row["activities"]
        )


_READS_CODE = re.compile(
    r"(?:ba|da|z|k|mk|a|c|tc|fi)?sh|(?:python|perl|ruby|node|lua|php)[\d.]*|\{python\}|eval"
)
"""Programs, by their name without folders, that run a text among their arguments."""
_CODE_FOLLOWS = re.compile(r"-\w*[ceErR]|--(?:eval|command|exec)")
"""Options of theirs that stand before that text."""


def _run_as_code(command: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """The texts of a command that are run as they are, and what each is: the program, or a program's text."""
    options = False  # whether what stands before are such a program and options of it
    for place, text in enumerate(command):
        if place == 0:
            yield text, "the program that is run"
        elif options and _CODE_FOLLOWS.fullmatch(command[place - 1]):
            yield text, "a program's text"
        reads = _READS_CODE.fullmatch(text.rpartition("/")[2]) is not None
        options = reads or (options and text.startswith("-"))


def starts_by_itself(plan: Plan) -> bool:
    """Whether no driver tells when the mission starts, so that it does at once."""
    return not any(START in spec.tells for spec in plan.specs)


def tells(spec: DriverSpec, said: str, objective: str | None, tables: Tables) -> str | None:
    """The text of an event that a driver's file calls so."""
    if is_ending(said):
        if objective is None:
            return None
        # For an objective that does not fail for the reason it is a failure like any other.
        event = ending(objective, said)
        return event if event in tables.known else ending(objective, FAILURE)
    return event_of(said, tables.known)
