"""A controller as numbers: what targets with constant tables print.

Every element of the mission has a number, events in the order of their texts' bytes, so that a name is found
by halving. A section's machine speaks of its own elements by position; each section says, by slices of one
pool, which elements of the mission these are. Equal slices and equal lists of actions are kept once.

The highest numbers are no elements: ``none``, then the outcomes with which a section is left, downwards. The
first two of these are success and failure, of a section as of the mission; the third is that the mission is
aborted, and of a section whichever comes next.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Generic, TypeAlias, TypeVar

from mcpn.events import START, Event, What
from mcpn.robot.runtime.actions import ParameterValue
from mcpn.robot.runtime.controller_tables import Laws

VERBS = ("stop", "release", "select", "start", "disarm", "arm")
"""By number."""

Item = TypeVar("Item", bound=Hashable)
Own = Mapping[str, Mapping[str, int]]
"""Positions of the elements of a type, by kind and name."""


class Pool(Generic[Item]):
    """Sequences one after the other, equal ones once."""

    def __init__(self) -> None:
        self.items: list[Item] = []
        self._known: dict[tuple[Item, ...], int] = {}

    def add(self, sequence: Iterable[Item]) -> int:
        """Where a sequence begins."""
        key = tuple(sequence)
        if key not in self._known:
            self._known[key] = len(self.items)
            self.items.extend(key)
        return self._known[key]


Row: TypeAlias = Mapping[str, Any]
"""A JSON object of the document."""
Type: TypeAlias = Row
"""A machine, or rules."""

KINDS = ("hardware", "objectives", "activities", "alternatives")
"""Kinds of elements that machines speak of in their actions."""


@dataclass
class Numbers:
    """What tables of a controller speak of; ``none`` stands for no element.

    Args:
        document: The controller's document.
    """

    document: Mapping[str, Any]
    none: int = field(init=False)

    def __post_init__(self) -> None:
        document = self.document
        self.hardware: list[str] = document["all_hardware"]
        self.faulty: list[str] = document["hardware"]
        self.out = [number for number, name in enumerate(self.faulty) if name in document["out_of_service"]]
        """Of what can fail, what is out of service at the start."""
        self.lasting = frozenset[str](document["unrepairable"])
        """What is never repaired."""
        self.crashing = [number for number, name in enumerate(self.faulty) if name in document["crashing"]]
        """Of what can fail, what stands for a crash and fails only where a section says so: the last ones."""
        self.activities: list[str] = document["started"]
        ways = {name: document["activities"][name]["alternatives"] for name in self.activities}
        self.alternatives = [f"{name}.{way}" for name, own in ways.items() for way in own]
        self.blocks: list[str] = list(document.get("blocks", ()))
        """Blocks with a time of their own, which are numbered after objectives."""
        self.objectives = [*document["objectives"], *self.blocks]
        self.timeouts = Laws(document).timeouts
        """By objective or block that has one, in seconds."""
        self.timers: int = document["timers"]
        """How many run at a time, at most."""
        self.types: list[Type] = document["types"]
        self.sections = [section["name"] for section in document["sections"]]
        self.handlers = sorted({_own(section, "once", h) for section, h in self._handlers()})
        facts = document["facts"].values()
        of_facts = {flag for values in facts for true in values.values() for flag in true}
        self.flags = [*sorted(of_facts), *document["late"].values()]
        """What may be true of facts, where it was not at the start, and of hardware detected late."""
        self.once = [*self.handlers, *self.flags]
        """Handlers that happen once, and what may be true."""
        late = document["late"].items()
        self.known = {self.faulty.index(name): self.once.index(text) for name, text in late}
        """Of what can fail and is detected late, the number of what says that its loss is known."""
        self.known_out = [self.known[number] for number in self.out if number in self.known]
        """Those of them that are true at the start."""
        texts = {text for section in document["sections"] for text in section["events"]} | {str(START)}
        texts |= document["changing"].keys()
        for name in self.faulty:
            texts.add(str(Event(What.OUT_OF_SERVICE, name)))
            if name not in self.lasting:
                texts.add(str(Event(What.REPAIRED, name)))
        self.events = sorted(texts, key=lambda text: text.encode("utf-8", "surrogatepass"))
        self._event = {text: number for number, text in enumerate(self.events)}
        self.start = self._event[str(START)]
        self._number = {
            kind: {name: number for number, name in enumerate(names)}
            for kind, names in (
                ("hardware", self.hardware),
                ("objectives", self.objectives),
                ("activities", self.activities),
                ("alternatives", self.alternatives),
            )
        }
        self._tables()
        self._parameters()

    def _handlers(self) -> Iterator[tuple[Row, str]]:
        """Each section with each of its handlers that happen once, by the name in its type."""
        for section in self.document["sections"]:
            for handler in self.types[section["type"]]["once"]:
                yield section, handler

    def _mine(self, section: Row) -> Iterator[int]:
        """The numbers of what a section's type says has happened, or is true of facts."""
        type_ = self.types[section["type"]]
        yield from (self.handlers.index(_own(section, "once", h)) for h in type_["once"])
        first = len(self.handlers)
        yield from (first + self.flags.index(_own(section, "facts", f)) for f in type_["facts"])

    @property
    def changing(self) -> dict[int, tuple[list[int], list[int]]]:
        """By event that changes facts whatever runs, what it makes true and what it makes false."""
        number = {flag: len(self.handlers) + i for i, flag in enumerate(self.flags)}
        return {
            self._event[text]: (
                sorted(map(number.__getitem__, changes["true"])),
                sorted(map(number.__getitem__, changes["false"])),
            )
            for text, changes in self.document["changing"].items()
        }

    @property
    def late(self) -> list[int]:
        """By objective, the number of its timeout event; the number of all events where it has none."""
        texts = (str(Event(What.TIMEOUT, name)) for name in self.objectives)
        return [self._event.get(text, len(self.events)) for text in texts]

    @property
    def failures(self) -> list[int]:
        """The event of each faulty hardware resource's failure."""
        return [self._event[str(Event(What.OUT_OF_SERVICE, name))] for name in self.faulty]

    @property
    def repairs(self) -> list[int | None]:
        """The event of its repair, of what is repaired."""
        return [self._event.get(str(Event(What.REPAIRED, name))) for name in self.faulty]

    def _tables(self) -> None:
        sections = self.document["sections"]
        self.initial = self.sections.index(self.document["initial"])
        self.list_start: list[int] = []
        self.action_rows: list[tuple[int, int, int, int]] = []  # verb, subject, alternative, objective
        self.type_hardware = [len(type_["hardware"]) for type_ in self.types]
        self._lists: dict[tuple[tuple[int, int, int, int], ...], int] = {}
        # Sections of one type are left with the same outcomes, in the same order.
        outcomes = {section["type"]: tuple(section["routes"]) for section in sections}
        assert all(reasons[:2] == ("success", "failure") for reasons in outcomes.values())
        aborts = any("abort" in section["routes"].values() for section in sections)
        ends = 3 if aborts else 2
        largest = max(
            *(len(names) for names in self._number.values()),
            *map(self._size, self.types),
            len(self.sections),
        ) + max(ends, *map(len, outcomes.values()))
        self.none = next(number for number in (0xFF, 0xFFFF, 0xFFFFFFFF) if largest < number)
        self.success, self.failure = self.none - 1, self.none - 2
        self.abort = self.none - 3 if aborts else None
        self.first_outcome = self.none - max(map(len, outcomes.values()))
        self._own = [_positions(*self._said(type_)) for type_ in self.types]
        for kind, (type_, own) in enumerate(zip(self.types, self._own, strict=True)):
            left = {outcome: self.none - 1 - i for i, outcome in enumerate(outcomes[kind])}
            self._type(type_, own, left)
        self._ended()
        self.list_start.append(len(self.action_rows))
        self._place_sections()

    def _size(self, type_: Type) -> int:
        """The largest count in a type of what is numbered in the same columns as elements, such as states."""
        raise NotImplementedError

    def _said(self, type_: Type) -> tuple[Iterable[Sequence[Row]], Iterable[tuple[str, str]]]:
        """Lists of actions of a type, and the activities with the alternatives in which they may run."""
        raise NotImplementedError

    def _type(self, type_: Type, own: Own, left: Mapping[str, int]) -> None:
        """Writes the tables of a type, with the numbers of its elements and of its outcomes."""
        raise NotImplementedError

    def _ended(self) -> None:
        """Ends the tables of types."""

    def _list(self, actions: Sequence[Row], own: Own) -> int:
        rows = tuple(
            (
                VERBS.index(action["do"]),
                next(own[kind][name] for kind, name in _subjects(action) if name is not None),
                own["alternatives"][f"{action['activity']}.{action['alternative']}"]
                if "alternative" in action
                else self.none,
                own["objectives"][action["objective"]] if "objective" in action else self.none,
            )
            for action in actions
        )
        if rows not in self._lists:
            self._lists[rows] = len(self.list_start)
            self.list_start.append(len(self.action_rows))
            self.action_rows.extend(rows)
        return self._lists[rows]

    def _place_sections(self) -> None:
        """Routes of sections, and which elements of the mission their types' elements are."""
        sections = self.document["sections"]
        pool: Pool[int] = Pool()
        self.section_type = [section["type"] for section in sections]
        ends = {"succeed": self.success, "fail": self.failure}
        if self.abort is not None:
            ends["abort"] = self.abort
        number = {name: i for i, name in enumerate(self.sections)}
        self.routes = [
            [ends[route] if route in ends else number[route] for route in section["routes"].values()]
            for section in sections
        ]
        routes: Pool[int] = Pool()
        self.section_routes = [routes.add(row) for row in self.routes]
        self.route = routes.items
        self.slices: dict[str, list[int]] = {kind: [] for kind in (*KINDS, "faulty", "once")}
        events: Pool[tuple[int, int]] = Pool()
        self.event_start, self.event_count = list[int](), list[int]()
        faulty = {name: i for i, name in enumerate(self.faulty)}
        for section in sections:
            own = self._own[section["type"]]
            for kind in KINDS:
                mine = [self._number[kind].get(_own(section, kind, old), self.none) for old in own[kind]]
                self.slices[kind].append(pool.add(mine))
            type_ = self.types[section["type"]]
            mine = [faulty[_own(section, "hardware", h)] for h in type_["hardware"]]
            self.slices["faulty"].append(pool.add(mine))
            self.slices["once"].append(pool.add(self._mine(section)))
            pairs = sorted((self._event[text], i) for i, text in enumerate(section["events"]))
            self.event_start.append(events.add(pairs))
            self.event_count.append(len(pairs))
        self.pool, self.section_events = pool.items, events.items

    @property
    def longest(self) -> int:
        """The most actions of one event: of what it may order, each verb once for each subject."""

        @cache
        def length(lists: tuple[int, ...]) -> int:
            rows = (
                row
                for number in lists
                for row in self.action_rows[self.list_start[number] : self.list_start[number + 1]]
            )
            return len({row[:2] for row in rows})

        entries = [
            max((length(tuple(entry)) for entry in self.entry_lists(section["type"])), default=0)
            for section in self.document["sections"]
        ]
        best = entries[self.initial]
        for section, routes in zip(self.document["sections"], self.routes, strict=True):
            for target, actions in self.moved(section["type"]):
                follows = 0
                if self.first_outcome <= target < self.none:
                    route = routes[self.none - 1 - target]
                    follows = 0 if route in (self.success, self.failure, self.abort) else entries[route]
                best = max(best, length(tuple(actions)) + follows)
        return best

    def entry_lists(self, kind: int) -> Iterable[Sequence[int]]:
        """By entry of a type, the lists of actions that it may give."""
        raise NotImplementedError

    def moved(self, kind: int) -> Iterable[tuple[int, Sequence[int]]]:
        """Where the events of a type may lead, each with the lists of actions that it may give."""
        raise NotImplementedError

    def _parameters(self) -> None:
        """Parameters of objectives, activities and alternatives: the first and how many, by number."""
        self.parameters: list[ParameterValue] = []
        self.law: dict[str, list[tuple[int, int]]] = {}
        objectives, activities = self.document["objectives"], self.document["activities"]
        ways = {f"{a}.{w}": way for a, own in activities.items() for w, way in own["alternatives"].items()}
        for kind, names, rows in (
            ("objectives", self.objectives, objectives | {name: {"parameters": {}} for name in self.blocks}),
            ("activities", self.activities, activities),
            ("alternatives", self.alternatives, ways),
        ):
            self.law[kind] = []
            for name in names:
                parameters = rows[name]["parameters"].items()
                self.law[kind].append((len(self.parameters), len(parameters)))
                self.parameters += (ParameterValue(key, p["value"], p["unit"]) for key, p in parameters)


def _own(section: Row, kind: str, name: str) -> str:
    """A section's own name of what its type calls so."""
    own: str = section["names"].get(kind, {}).get(name, name)
    return own


def _subjects(action: Row) -> Iterator[tuple[str, str | None]]:
    """Kinds and names that an action may have; the first name that is there is its subject."""
    yield from (("activities", action.get("activity")), ("hardware", action.get("hardware")))
    yield "objectives", action.get("objective")


def _positions(lists: Iterable[Sequence[Row]], modes: Iterable[tuple[str, str]]) -> dict[str, dict[str, int]]:
    """By kind and name the position of each element that a type names, in the order of first mention."""
    found: dict[str, dict[str, None]] = {kind: {} for kind in KINDS}
    for actions in lists:
        for action in actions:
            for kind, name in (
                ("hardware", action.get("hardware")),
                ("objectives", action.get("objective")),
                ("activities", action.get("activity")),
                ("alternatives", ".".join(_pair(action)) or None),
            ):
                if name is not None:
                    found[kind][name] = None
    for activity, alternative in modes:
        found["activities"][activity] = None
        found["alternatives"][f"{activity}.{alternative}"] = None
    return {kind: {name: i for i, name in enumerate(names)} for kind, names in found.items()}


def _pair(action: Row) -> tuple[str, ...]:
    """The activity and the alternative that an action selects; nothing for other actions."""
    return (action["activity"], action["alternative"]) if "alternative" in action else ()
