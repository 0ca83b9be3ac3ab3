"""The controller's file as tables that are quick to run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from mcpn.robot.runtime.actions import START, Action, ParameterValue
from mcpn.robot.runtime.documents import BEFORE, ENDS, FORMS, RUNNING
from mcpn.robot.runtime.file_schema import ControllerFileError, check_digest, check_shape, parsed
from mcpn.robot.runtime.machines import MachineProtocol, RuleTables, TypeTables


@dataclass(frozen=True, slots=True)
class Inside:
    """A state of a section, in the section's own names."""

    objectives: tuple[str, ...] = ()
    pending: tuple[str, ...] = ()
    done: tuple[str, ...] = ()
    mode: Mapping[str, str] = field(default_factory=dict)
    waiting: Mapping[str, str] = field(default_factory=dict)
    refused: tuple[str, ...] = ()


class TableSection:
    """A section with the tables of its type; actions and states in its own names are made at first use.

    Args:
        row: The section, as the file says it.
        machine: The tables of its type.
        laws: Parameters of objectives, activities and alternatives.
    """

    def __init__(self, row: Mapping[str, Any], machine: MachineProtocol, laws: Laws) -> None:
        self.name: str = row["name"]
        self.type: int = row["type"]
        self.routes: dict[str, str] = row["routes"]
        self.names: dict[str, dict[str, str]] = row["names"]
        self.machine = machine
        self.laws = laws
        self.events: list[str] = row["events"]
        self.number = {text: number for number, text in enumerate(self.events)}
        own = self.names.get("hardware", {})
        self.hardware = [own.get(h, h) for h in machine.hardware]
        renamed = {**self.names.get("once", {}), **self.names.get("facts", {})}
        self.flags = [renamed.get(name, name) for name in machine.flags]  # handlers, then flags of facts
        self._actions: dict[int, tuple[Action, ...]] = {}
        self._states: dict[int, Inside] = {}

    def entry(
        self, out_of_service: Set[str], true: Set[str]
    ) -> tuple[int, tuple[Action, ...], Set[str], Set[str]]:
        """The first state inside, the actions, the flags of facts that become true, and those that end."""
        step = self.machine.entry(_numbers(self.hardware, out_of_service), _numbers(self.flags, true))
        if step is None:
            gone = sorted(out_of_service)
            raise ControllerFileError(f"section {self.name} has no entry with {gone} out of service")
        return step[0], self.actions(step[1]), self._named(step[2]), self._named(step[3])

    def move(
        self, state: int, event: str, true: Set[str] = frozenset()
    ) -> tuple[int | str, tuple[Action, ...], Set[str], Set[str]] | None:
        """Where an event leads, the actions, handlers and flags that become true, flags that become false.

        ``None`` where the event cannot be taken.

        Args:
            state: The state inside.
            event: Its text.
            true: Handlers that happen once and have happened, and what is true of facts.
        """
        number = self.number.get(event)
        if number is None:
            return None
        step = self.machine.move(state, number, _numbers(self.flags, true))
        if step is None:
            return None
        target, actions, happening, ended = step
        return target, self.actions(actions), self._named(happening), self._named(ended)

    def _named(self, numbers: Set[int]) -> Set[str]:
        return {self.flags[i] for i in numbers} if numbers else _NO_NAMES

    def possible(self, state: int, true: Set[str] = frozenset()) -> list[str]:
        """Events of the section that are possible in a state, while some flags are true."""
        return [self.events[i] for i in self.machine.possible(state, _numbers(self.flags, true))]

    def whole(self, state: int, out_of_service: Set[str], true: Set[str]) -> bool:
        """Whether a number may be a state inside, with some hardware out of service."""
        return self.machine.whole(state, _numbers(self.hardware, out_of_service), _numbers(self.flags, true))

    def actions(self, numbers: Sequence[int]) -> tuple[Action, ...]:
        """Lists of actions of the type, one after the other, in the section's own names."""
        found: tuple[Action, ...] = ()
        for number in numbers:
            if number not in self._actions:
                self._actions[number] = tuple(self._own(action) for action in self.machine.lists[number])
            found += self._actions[number]
        return found

    def state(self, number: int) -> Inside:
        """What a state is, in the section's own names."""
        if number not in self._states:
            self._states[number] = self._inside(self.machine.shown(number))
        return self._states[number]

    def _own(self, row: Mapping[str, str]) -> Action:
        names = self.names
        activity, alternative = row.get("activity"), row.get("alternative")
        objective, hardware = row.get("objective"), row.get("hardware")
        if alternative is not None:
            whole = f"{activity}.{alternative}"
            alternative = names.get("alternatives", {}).get(whole, whole).split(".", 1)[1]
        activity = _in(names, "activities", activity)
        objective = _in(names, "objectives", objective)
        hardware = _in(names, "hardware", hardware)
        parameters = self.laws.of(activity, alternative, objective) if alternative is not None else ()
        seconds = self.laws.timeouts.get(objective or "") if row["do"] == "arm" else None
        return Action(row["do"], activity, alternative, hardware, objective, parameters, seconds)

    def _inside(self, row: Mapping[str, Any]) -> Inside:
        names = self.names

        def mode(said: Mapping[str, str]) -> dict[str, str]:
            pairs = (f"{a}.{way}" for a, way in said.items())
            return dict(names.get("alternatives", {}).get(pair, pair).split(".", 1) for pair in pairs)

        def those(said: Iterable[str], kind: str) -> tuple[str, ...]:
            return tuple(names.get(kind, {}).get(name, name) for name in said)

        return Inside(
            those(row["objectives"], "objectives"),
            those(row["pending"], "objectives"),
            those(row["done"], "objectives"),
            mode(row["mode"]),
            mode(row["waiting"]),
            those(row["refused"], "activities"),
        )


class RuntimePosition(NamedTuple):
    """Where a controller is, its timers aside.

    Args:
        phase: ``before``, ``running``, or the outcome with which the mission has ended.
        section: The section that runs.
        state: The number of its state.
        gone: Hardware out of service.
        true: Handlers that happen once and have happened, and what is true of facts.
    """

    phase: str
    section: TableSection | None
    state: int
    gone: Set[str]
    true: Set[str]


def _numbers(names: Sequence[str], some: Set[str]) -> Set[int]:
    """The positions in ``names`` of those names that are in ``some``."""
    return {number for number, name in enumerate(names) if name in some} if names else _NONE


def _in(names: Mapping[str, Mapping[str, str]], kind: str, name: str | None) -> str | None:
    return None if name is None else names.get(kind, {}).get(name, name)


class Laws:
    """Parameters for the control laws."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.activities: Mapping[str, Any] = document["activities"]
        self.objectives: Mapping[str, Any] = document["objectives"]
        blocks = document.get("blocks", {})
        self.timeouts = {
            name: float(s)
            for name, row in (*self.objectives.items(), *blocks.items())
            if (s := row["timeout"])
        }
        self.held = {name: frozenset[str](row["objectives"]) for name, row in blocks.items()}
        self.producers: dict[str, list[str]] = {}
        for name, row in self.activities.items():
            for software in row["produces"]:
                self.producers.setdefault(software, []).append(name)
        self.idle: tuple[Action, ...] | None = None  # actions after which nothing runs, once they are known

    def timed(self, inside: Inside) -> set[str]:
        """The objectives and blocks whose timers run."""
        here = {*inside.objectives, *inside.pending}
        blocks = {name for name, held in self.held.items() if not here.isdisjoint(held)}
        return blocks | (self.timeouts.keys() & inside.objectives)

    def of(self, activity: str | None, alternative: str, objective: str | None) -> tuple[ParameterValue, ...]:
        """Parameters of an alternative: for each name the objective's, else its own, else the activity's."""
        values: dict[str, Any] = {}
        if activity is not None and activity in self.activities:
            said = self.activities[activity]
            values |= said["parameters"]
            values |= said["alternatives"].get(alternative, {"parameters": {}})["parameters"]
        if objective is not None and objective in self.objectives:
            values |= self.objectives[objective]["parameters"]
        return tuple(ParameterValue(name, p["value"], p["unit"]) for name, p in values.items())


class Tables:
    """A controller's file, checked and made quick to run.

    Args:
        document: The JSON object.

    Raises:
        ControllerFileError: It is no controller of a version that is known here, or not the one that was
            written.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        check_shape(document)
        self.digest = check_digest(document)
        make = RuleTables if document["form"] == FORMS[-1] else TypeTables
        self.mission: str = document["mission"]
        self.hardware: list[str] = document["hardware"]
        self.laws = Laws(document)
        types = [make(row) for row in document["types"]]
        sections = [TableSection(row, types[row["type"]], self.laws) for row in document["sections"]]
        self.sections = {section.name: section for section in sections}
        # By fact and value, the flags that are then true; by event, the flags that it makes true and false.
        self.facts: dict[str, dict[str, list[str]]] = document["facts"]
        self.changing: dict[str, dict[str, list[str]]] = document["changing"]
        # By hardware that is detected late, the flag that says that its loss is known.
        self.late: dict[str, str] = document["late"]
        self.of_facts = {flag for values in self.facts.values() for true in values.values() for flag in true}
        self.of_facts |= {*self.late.values()}
        self.flags = {flag for section in sections for flag in section.flags} | self.of_facts
        self.initial = self.sections[document["initial"]]
        # Failure and repair of all hardware that can fail, by event: they may happen outside sections, too.
        self.failures = {f"{name}_EV_OOS": name for name in self.hardware}
        lasting = set(document["unrepairable"])
        self.repairs = {f"{name}_EV_RD": name for name in self.hardware if name not in lasting}
        self.out_of_service = frozenset(document["out_of_service"])
        self.true_at_first = frozenset(self.late[name] for name in self.out_of_service if name in self.late)
        # What fails only where a section has an edge or a rule for it.
        self.crashing = frozenset(document["crashing"])
        beside = (*self.changing, *self.failures, *self.repairs)
        self.known = {START, *beside, *(e for s in sections for e in s.events)}

    def possible(self, at: RuntimePosition) -> set[str]:
        """The events that can be taken."""
        events = {*self.outside(at.section, at.gone, at.true)}
        if at.section:
            events.update(at.section.possible(at.state, at.true))
        elif at.phase == BEFORE:
            events.add(START)
        return events

    def after(self, at: RuntimePosition, event: str) -> tuple[RuntimePosition, tuple[Action, ...]] | None:
        """Where an event leads, and the actions; ``None`` where it cannot be taken."""
        section = at.section
        if section is not None and event in section.number:
            step = section.move(at.state, event, at.true)
            if step is None:
                return None
            target, actions, begun, ended = step
            true = (at.true | begun) - ended if begun or ended else at.true
            gone = self.out_after(event, at.gone)
            if not isinstance(target, str):
                return RuntimePosition(RUNNING, section, target, gone, true), actions
            inside, first = self._entered(section.routes[target], gone, true)
            return inside, actions + first
        if self.is_outside(event):
            if not self.may_happen(event, at.gone, at.true):
                return None
            true, gone = self.changed(event, at.true), self.out_after(event, at.gone)
            return RuntimePosition(at.phase, section, at.state, gone, true), ()
        if event == START and at.phase == BEFORE:
            return self._entered(self.initial.name, at.gone, at.true)
        return None

    def _entered(
        self, route: str, gone: Set[str], true: Set[str]
    ) -> tuple[RuntimePosition, tuple[Action, ...]]:
        """Where a route leads: into a section, or to the end of the mission."""
        if route in ENDS:
            return RuntimePosition(ENDS[route], None, 0, gone, true), ()
        section = self.sections[route]
        state, actions, begun, ended = section.entry(gone, true)
        return RuntimePosition(RUNNING, section, state, gone, (true | begun) - ended), actions

    def outside(self, section: TableSection | None, gone: Set[str], true: Set[str]) -> Iterator[str]:
        """Possible events that the section does not handle itself: of hardware, and changes of facts."""
        hardware, events = (section.hardware, section.number) if section else ((), ())
        for name in self.hardware:
            if name not in hardware:
                event = f"{name}_EV_RD" if name in gone else f"{name}_EV_OOS"
                if self.is_outside(event) and self.may_happen(event, gone, true):
                    yield event
        yield from (e for e in self.changing if e not in events and self.changes(e, true))

    def is_outside(self, event: str) -> bool:
        """Whether an event may happen whatever runs, unless the section handles it itself."""
        return event in self.failures or event in self.repairs or event in self.changing

    def may_happen(self, event: str, gone: Set[str], true: Set[str]) -> bool:
        """Whether an event that the section does not handle itself can be taken.

        Args:
            event: One of :meth:`is_outside`.
            gone: Hardware out of service.
            true: The flags that are true.
        """
        if event in self.failures:
            name = self.failures[event]
            return name not in gone and name not in self.crashing
        if event in self.repairs:
            name = self.repairs[event]
            return name in gone and (name not in self.late or self.late[name] in true)
        return self.changes(event, true)

    def out_after(self, event: str, gone: Set[str]) -> Set[str]:
        """Hardware that is out of service after an event."""
        if event in self.failures:
            return gone | {self.failures[event]}
        return gone - {self.repairs[event]} if event in self.repairs else gone

    def values(self, true: Set[str]) -> dict[str, str]:
        """The value of each fact, from the flags that are true."""
        values = {name: self.value(name, true) for name in self.facts}
        return {name: value for name, value in values.items() if value is not None}

    def value(self, fact: str, true: Set[str]) -> str | None:
        """The value of a fact, from the flags that are true; ``None`` where they are those of no value."""
        values = self.facts[fact]
        now = {flag for flags in values.values() for flag in flags if flag in true}
        return next((value for value, flags in values.items() if now == set(flags)), None)

    def changes(self, event: str, true: Set[str]) -> bool:
        """Whether an event that changes facts would change something."""
        return self.changed(event, true) != true

    def changed(self, event: str, true: Set[str]) -> Set[str]:
        """The flags that are true after an event that the section does not handle itself."""
        changes, known = self.changing.get(event, _NO_CHANGE), self.late.get(self.repairs.get(event, ""))
        return {*true, *changes["true"]}.difference(changes["false"], [known])


_NONE: frozenset[int] = frozenset()
_NO_NAMES: frozenset[str] = frozenset()
_NO_CHANGE: dict[str, list[str]] = {"true": [], "false": []}


def read(path: Path) -> Tables:
    """Reads a controller's file.

    Raises:
        ControllerFileError: It cannot be read or is no controller.
    """
    try:
        return Tables(parsed(path.read_bytes()))
    except (OSError, ControllerFileError) as error:
        raise ControllerFileError(f"{path}: {error}") from error
