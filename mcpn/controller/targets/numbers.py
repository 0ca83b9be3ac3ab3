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
from typing import Generic, TypeVar

from mcpn.controller.hierarchy import KINDS, PlacedMachine, SectionMachine
from mcpn.controller.machine import PlannedAction, Verb
from mcpn.controller.modular import AnyController, Rules
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.status import told_as_facts
from mcpn.mission.graph import ElementarySection, ObjectivesGraph
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.robot import Parameter
from mcpn.nets.events import START, Event, What

VERBS: tuple[Verb, ...] = ("stop", "release", "select", "start", "disarm", "arm")
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


Type = TypeVar("Type", SectionMachine, Rules)


@dataclass
class Numbers(Generic[Type]):
    """What tables of a controller speak of; ``none`` stands for no element.

    Args:
        controller: The controller.
        mission_net: The mission's net, for the parameters.
    """

    controller: AnyController
    mission_net: MissionNet
    none: int = field(init=False)

    def __post_init__(self) -> None:
        controller, mission = self.controller, self.mission_net.mission
        self.hardware = [h.name for h in mission.hardware]
        self.faulty = list(controller.hardware)
        out = {h.name for h in mission.hardware if h.initial == "oos"}
        self.out = [number for number, name in enumerate(self.faulty) if name in out]
        """Of what can fail, what is out of service at the start."""
        self.lasting = {h.name for h in mission.hardware if not h.repairable}
        """What is never repaired."""
        crashes = {crash.name for crash in mission.crashes}
        self.crashing = [number for number, name in enumerate(self.faulty) if name in crashes]
        """Of what can fail, what stands for a crash and fails only where a section says so: the last ones."""
        self.activities = [a.name for a in mission.activities if a.name in self.mission_net.usage.started]
        running = [a for a in mission.activities if a.name in set(self.activities)]
        self.alternatives = [f"{a.name}.{way.name}" for a in running for way in a.alternatives]
        graph: ObjectivesGraph = self.mission_net.graph
        self.blocks: list[str] = [block.name for block in graph.timed_blocks()]
        """Blocks with a time of their own, which are numbered after objectives."""
        self.objectives = [*(section.name for section in graph.walk()), *self.blocks]
        self.timeouts = {s.name: s.timeout for s in graph.timed if s.timeout is not None}
        """By objective or block that has one, in seconds."""
        self.timers = _timers(graph)
        """How many run at a time, at most."""
        self.handlers = sorted({section.names["once"].get(h, h) for section, h in self._handlers()})
        world = self.mission_net.usage.world
        told = told_as_facts(self.mission_net.statuses)
        self.flags = sorted(flag.text for flag in told if flag.kind == "fact")
        self.flags += [flag.text for flag in told if flag.kind != "fact"]
        """What may be true of facts, where it was not at the start, and of hardware detected late."""
        self.once = [*self.handlers, *self.flags]
        """Handlers that happen once, and what may be true."""
        late = {flag.name: flag.text for flag in told if flag.kind == "known"}
        self.known = {self.faulty.index(name): self.once.index(text) for name, text in late.items()}
        """Of what can fail and is detected late, the number of what says that its loss is known."""
        self.known_out = [self.known[number] for number in self.out if number in self.known]
        """Those of them that are true at the start."""
        self.sections = [section.name for section in controller.sections]
        texts = {str(e) for section in controller.sections for e in section.events} | {str(START)}
        texts |= {str(Event(What.DECLARED, name)) for name in world.changing}
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

    @property
    def types(self) -> Sequence[Type]:
        """The machines, or the rules."""
        raise NotImplementedError

    def _handlers(self) -> Iterator[tuple[PlacedMachine, str]]:
        """Each section with each of its handlers that happen once, by the name in its type."""
        for section in self.controller.sections:
            for handler in self.types[section.type].once:
                yield section, handler

    def _mine(self, section: PlacedMachine) -> Iterator[int]:
        """The numbers of what a section's type says has happened, or is true of facts."""
        type_, names = self.types[section.type], section.names
        yield from (self.handlers.index(names["once"].get(h, h)) for h in type_.once)
        first = len(self.handlers)
        yield from (first + self.flags.index(names["facts"].get(f, f)) for f in type_.facts)

    @property
    def changing(self) -> dict[int, tuple[list[int], list[int]]]:
        """By event that changes facts whatever runs, what it makes true and what it makes false."""
        number = {flag: len(self.handlers) + i for i, flag in enumerate(self.flags)}
        return {
            self._event[str(Event(What.DECLARED, name))]: (
                sorted(map(number.__getitem__, true)),
                sorted(map(number.__getitem__, false)),
            )
            for name, (true, false) in self.mission_net.usage.world.turning.items()
        }

    # --- events of hardware, and of timers ---

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

    # --- tables ---

    def _tables(self) -> None:
        controller = self.controller
        self.initial = self.sections.index(controller.initial)
        self.list_start: list[int] = []
        self.action_rows: list[tuple[int, int, int, int]] = []  # verb, subject, alternative, objective
        self.type_hardware = [len(type_.hardware) for type_ in self.types]
        self._lists: dict[tuple[tuple[int, int, int, int], ...], int] = {}
        # Sections of one type are left with the same outcomes, in the same order.
        outcomes = {section.type: tuple(section.routes) for section in controller.sections}
        assert all(reasons[:2] == ("success", "failure") for reasons in outcomes.values())
        aborts = any(ABORT in section.routes.values() for section in controller.sections)
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

    def _said(self, type_: Type) -> tuple[Iterable[Sequence[PlannedAction]], Iterable[tuple[str, str]]]:
        """Lists of actions of a type, and the activities with the alternatives in which they may run."""
        raise NotImplementedError

    def _type(self, type_: Type, own: Own, left: Mapping[str, int]) -> None:
        """Writes the tables of a type, with the numbers of its elements and of its outcomes."""
        raise NotImplementedError

    def _ended(self) -> None:
        """Ends the tables of types."""

    def _list(self, actions: tuple[PlannedAction, ...], own: Own) -> int:
        rows = tuple(
            (
                VERBS.index(action.verb),
                next(own[kind][name] for kind, name in _subjects(action) if name is not None),
                own["alternatives"][f"{action.activity}.{action.alternative}"]
                if action.alternative
                else self.none,
                own["objectives"][action.objective] if action.objective else self.none,
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
        controller = self.controller
        pool: Pool[int] = Pool()
        self.section_type = [section.type for section in controller.sections]
        ends = {SUCCEED: self.success, FAIL: self.failure}
        if self.abort is not None:
            ends[ABORT] = self.abort
        number = {name: i for i, name in enumerate(self.sections)}
        self.routes = [
            [ends[route] if route in ends else number[route] for route in section.routes.values()]
            for section in controller.sections
        ]
        routes: Pool[int] = Pool()
        self.section_routes = [routes.add(row) for row in self.routes]
        self.route = routes.items
        self.slices: dict[str, list[int]] = {kind: [] for kind in (*KINDS, "faulty", "once")}
        events: Pool[tuple[int, int]] = Pool()
        self.event_start, self.event_count = list[int](), list[int]()
        faulty = {name: i for i, name in enumerate(self.faulty)}
        for section in controller.sections:
            own = self._own[section.type]
            for kind in KINDS:
                names = section.names[kind]
                mine = [self._number[kind].get(names.get(old, old), self.none) for old in own[kind]]
                self.slices[kind].append(pool.add(mine))
            machine = self.types[section.type]
            names = section.names["hardware"]
            self.slices["faulty"].append(pool.add(faulty[names.get(h, h)] for h in machine.hardware))
            self.slices["once"].append(pool.add(self._mine(section)))
            pairs = sorted((self._event[str(e)], i) for i, e in enumerate(section.events))
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
            max((length(tuple(entry)) for entry in self.entry_lists(section.type)), default=0)
            for section in self.controller.sections
        ]
        best = entries[self.initial]
        for section, routes in zip(self.controller.sections, self.routes, strict=True):
            for target, actions in self.moved(section.type):
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

    # --- parameters ---

    def _parameters(self) -> None:
        """Parameters of objectives, activities and alternatives: the first and how many, by number."""
        self.parameters: list[Parameter] = []
        self.law: dict[str, list[tuple[int, int]]] = {}
        objectives = {section.name: section.parameters for section in self.mission_net.graph.walk()}
        objectives |= dict.fromkeys(self.blocks, ())
        running = {a.name: a for a in self.mission_net.mission.activities}
        ways = {f"{a.name}.{w.name}": w.parameters for a in running.values() for w in a.alternatives}
        for kind, rows in (
            ("objectives", [objectives[name] for name in self.objectives]),
            ("activities", [running[name].parameters for name in self.activities]),
            ("alternatives", [ways[name] for name in self.alternatives]),
        ):
            self.law[kind] = []
            for parameters in rows:
                self.law[kind].append((len(self.parameters), len(parameters)))
                self.parameters.extend(parameters)


def _timers(graph: ObjectivesGraph) -> int:
    """How many objectives and blocks of a graph that have a timeout run at a time, at most."""
    most = 0
    for section in graph.sections:
        own = int(section.timeout is not None)
        if isinstance(section, ElementarySection):
            most = max(most, own)
        else:
            most = max(most, own + sum(_timers(branch.graph) for branch in section.branches))
            most = max(most, *(_timers(pause_graph.graph) for pause_graph in section.pause_graphs), 0)
    return most


def _subjects(action: PlannedAction) -> Iterator[tuple[str, str | None]]:
    """Kinds and names that an action may have; the first name that is there is its subject."""
    yield from (("activities", action.activity), ("hardware", action.hardware))
    yield "objectives", action.objective


def _positions(
    lists: Iterable[Sequence[PlannedAction]], modes: Iterable[tuple[str, str]]
) -> dict[str, dict[str, int]]:
    """By kind and name the position of each element that a type names, in the order of first mention."""
    found: dict[str, dict[str, None]] = {kind: {} for kind in KINDS}
    for actions in lists:
        for action in actions:
            for kind, name in (
                ("hardware", action.hardware),
                ("objectives", action.objective),
                ("activities", action.activity),
                ("alternatives", f"{action.activity}.{action.alternative}" if action.alternative else None),
            ):
                if name is not None:
                    found[kind][name] = None
    for activity, alternative in modes:
        found["activities"][activity] = None
        found["alternatives"][f"{activity}.{alternative}"] = None
    return {kind: {name: i for i, name in enumerate(names)} for kind, names in found.items()}
