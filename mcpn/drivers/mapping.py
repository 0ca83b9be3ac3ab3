"""Holds a file of drivers against a mission's controller: what runs each activity, what tells each event."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase

from mcpn.drivers.functions import function_of
from mcpn.drivers.plan import FAILURE, SUCCESS, DriverSpec, Place, Plan, filled
from mcpn.drivers.processes import program_of
from mcpn.errors import InputError, Problem, Source
from mcpn.mission.near import did_you_mean
from mcpn.runtime.tables import START, Tables

HOLES = ("activity", "alternative", "objective", "run", "python")
"""Holes that are no parameters: ``run`` is the number of the start, ``python`` the interpreter of mcpn."""
WILDCARDS = "+#*$?\0"
"""What means more than itself in a topic of MQTT or a key of zenoh."""
ENDINGS = {SUCCESS: "OK", FAILURE: "FAIL"}
"""By word, the end of the event's text."""


def ending(objective: str, word: str) -> str:
    """The event of an objective that ``success`` or ``failure`` stands for."""
    return f"OBJ_{objective}_EV_{ENDINGS[word]}"


def event_of(text: str, known: Iterable[str]) -> str | None:
    """The event that a file of drivers names: by its text, or one that the mission declares by its name."""
    return next((event for event in (text, f"{text}_EV") if event in known), None)


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
            for line, message in sorted(problems, key=lambda of: (of[0] or 0, of[1]))
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
            for way, of in row["alternatives"].items():
                yield name, way, of

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
                    of = activity if objective is None else f"{activity}, for objective {objective},"
                    message = f"{{{hole}}}: {of} has no such parameter{did_you_mean(hole, given)}"
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
                yield self._at(spec.place, f"{{{hole}}}: {'.'.join(spec.place)} is of no activity")

    def _values(self, spec: DriverSpec, activity: str, way: str, objective: str | None) -> Found:
        """Values of the mission that would be more than values in a command or a topic."""
        values = {value.name: value.value for value in self.laws.of(activity, way, objective)}
        of = activity if objective is None else f"{activity}, for objective {objective}"
        for text in spec.command:
            found = filled(text, values)
            if found.startswith("-") and not text.startswith("-"):
                yield self._at(spec.place, f"{text}: {of}: {found!r} would be an option of the program")
        for text in spec.topics.texts:
            found = filled(text, values)
            if found != text and any(found.count(sign) > text.count(sign) for sign in WILDCARDS):
                yield self._at(spec.place, f"{text}: {of}: {found!r} would have a wildcard that is none here")

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
                    if event in ENDINGS:
                        if not (spec.place[0] == "activities" and spec.place[1] in may_end):
                            yield self._at(place, f"{event}: {'.'.join(spec.place)} is of no objective")
                    elif (found := event_of(event, known)) is None:
                        hint = did_you_mean(event, known)
                        yield self._at(place, f"{event!r} is no event of the mission's controller{hint}")
                    elif found.endswith("_EV_TIMEOUT"):
                        yield self._at(place, f"{event}: the controller's own timers tell this")
                    else:
                        told.add(found)
        for word in ENDINGS:
            told |= {
                ending(name, word) for name, row in self.laws.objectives.items() if self._ends(row, word)
            }
        for text in self.plan.never:
            named = event_of(text, known) or text
            if not any(fnmatchcase(event, named) for event in known):
                yield self._at(("never",), f"never: {text!r} is no event of the mission's controller")
            told |= {event for event in known if fnmatchcase(event, named)}
        for event in sorted(known - told - {START}):
            if not event.endswith("_EV_TIMEOUT"):
                yield None, f"no driver tells the event {event}: name it in one, or in never"

    def _ends(self, row: dict[str, list[str]], word: str) -> bool:
        """Whether some activity of an objective tells how it ends, whichever alternative runs."""
        return any(
            all(
                (spec := self.plan.driver(activity, way)) is not None and word in spec.tells
                for way in self.laws.activities[activity]["alternatives"]
            )
            for activity in row["activities"]
        )


def starts_by_itself(plan: Plan) -> bool:
    """Whether no driver tells when the mission starts, so that it does at once."""
    return not any(START in spec.tells for spec in plan.specs)


def tells(spec: DriverSpec, said: str, objective: str | None, tables: Tables) -> str | None:
    """The text of an event that a driver's file calls so."""
    if said in ENDINGS:
        return None if objective is None else ending(objective, said)
    return event_of(said, tables.known)
