"""The controller in C99, for the embedded computer: one header, one source, an example.

Constant tables, no allocation, no recursion, no pointers to functions. The time of an event is bounded: two
searches by halving, one pass over the events of a state, and at most as many actions as the header says. Of
rules it is one pass over those of the event and of each part that follows, and the same of the entry where a
section is left: the header says how many literals these have at most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mcpn.robot.runtime.documents import FORMS
from mcpn.robot.targets.identifiers import C_PREFIX_RESERVED, C_SIGNIFICANT, c_string, comment, identifiers
from mcpn.robot.targets.render import render, rows
from mcpn.robot.targets.type_numbers import MachineNumbers, RuleNumbers

LONGEST_PREFIX = 20
LARGEST_TABLE = 32_767
"""Bytes of the largest table that avr-gcc takes."""
NEAR_FLASH = 64_000
"""Bytes of tables that lie within the 64 KiB that ``__flash`` of an AVR reaches: other things come before."""
FRAMES = 512
"""Bytes of the frames of all calls inside one, without what holds a controller: measured, rounded up."""


@dataclass(frozen=True)
class Array:
    """A constant table.

    Args:
        name: Its name, without the mission's.
        values: Numbers that are not negative.
        meaning: What it says, for the comment.
    """

    name: str
    values: list[int]
    meaning: str

    @property
    def bytes_each(self) -> int:
        """Bytes of one number."""
        most = max(self.values, default=0)
        return 1 if most <= 0xFF else 2 if most <= 0xFFFF else 4

    @property
    def type(self) -> str:
        """Its type in C."""
        return f"uint{8 * self.bytes_each}_t"

    @property
    def bytes(self) -> int:
        """Bytes of the whole."""
        return self.bytes_each * self.length

    @property
    def length(self) -> int:
        """How many numbers there are; C has no empty tables."""
        return max(1, len(self.values))

    @property
    def text(self) -> str:
        """The numbers, each unsigned."""
        return rows([f"{value}U" for value in self.values or [0]])


def write_c(document: Mapping[str, Any]) -> dict[str, str]:
    """The files by name: header, source, example.

    Args:
        document: The controller's.
    """
    _, texts, main = written(document)
    return texts | main


@dataclass(frozen=True)
class InC:
    """A controller as its files in C speak of it.

    Args:
        numbers: It as numbers.
        prefix: What stands before the names of the interface, in lower case.
        enums: By kind of element its identifiers: the name in C, the number, the name in the mission.
    """

    numbers: RuleNumbers | MachineNumbers
    prefix: str
    enums: Mapping[str, Sequence[tuple[str, int, str]]]


def written(document: Mapping[str, Any]) -> tuple[InC, dict[str, str], dict[str, str]]:
    """What the files speak of, header and source by name, and the example by name.

    Args:
        document: The controller's.
    """
    numbers: RuleNumbers | MachineNumbers
    if document["form"] == FORMS[-1]:
        numbers = RuleNumbers(document)
        arrays, source = _of_rules(numbers), "rules.c.jinja"
    else:
        numbers = MachineNumbers(document)
        arrays, source = _of_machines(numbers), "controller.c.jinja"
    mission = document["mission"]
    prefix = identifiers([mission], keywords=C_PREFIX_RESERVED, longest=LONGEST_PREFIX)[mission]
    lower, upper = prefix.lower(), prefix.upper()
    kinds = {
        "event": numbers.events,
        "activity": numbers.activities,
        "alternative": numbers.alternatives,
        "objective": numbers.objectives,
        "hardware": numbers.hardware,
        "section": numbers.sections,
    }
    enums = {
        kind: [
            (identifier, number, comment(name))
            for number, (name, identifier) in enumerate(
                identifiers(names, prefix=f"{upper}_{kind.upper()}_", longest=C_SIGNIFICANT).items()
            )
        ]
        for kind, names in kinds.items()
    }
    values = {
        "p": lower,
        "P": upper,
        "mission": comment(mission),
        "controller": document,
        "numbers": numbers,
        "enums": enums,
        "strings": {kind: [c_string(name) for name in names] for kind, names in kinds.items()},
        "arrays": arrays,
        "memory": Footprint.of(numbers, arrays),
        "largest_table": LARGEST_TABLE,
        "near_flash": NEAR_FLASH,
        "table_bytes": sum(array.bytes for array in arrays),
        "name_bytes": sum(len(name.encode()) + 1 for names in kinds.values() for name in names),
        "oos_bytes": _bytes_of_bits(len(numbers.faulty)) or 1,
        "once_names": comment(", ".join(numbers.once)),
        "once_bytes": _bytes_of_bits(len(numbers.once)),
        "state_bytes": _state_bytes(numbers),
        "longest_name": max(len(name.encode()) for name in numbers.events),
        "number": f"uint{8 * _bytes_of_number(numbers)}_t",
        "event_type": "uint16_t" if len(numbers.events) < 0xFFFF else "uint32_t",
        "c_string": c_string,
    }
    texts = {
        f"{lower}.h": render("controller.h.jinja", **values),
        f"{lower}.c": render(source, **values),
    }
    return InC(numbers, lower, enums), texts, {f"{lower}_main.c": render("main.c.jinja", **values)}


def _bytes_of_bits(count: int) -> int:
    return (count + 7) // 8


def _bytes_of_number(numbers: RuleNumbers | MachineNumbers) -> int:
    return 1 if numbers.none == 0xFF else 2 if numbers.none == 0xFFFF else 4


def _state_bytes(numbers: RuleNumbers | MachineNumbers) -> int:
    """Bytes of the bits of a state; a machine's state is a number."""
    return _bytes_of_bits(numbers.bits) if isinstance(numbers, RuleNumbers) else 0


@dataclass(frozen=True)
class Footprint:
    """What a controller takes beside its tables, in bytes, where each number is aligned by its size.

    Args:
        state: One controller.
        actions: A buffer for the actions of an event.
        stack: What a call takes of the stack at most.
        largest: The largest table.
    """

    state: int
    actions: int
    stack: int
    largest: Array

    @classmethod
    def of(cls, numbers: RuleNumbers | MachineNumbers, arrays: Sequence[Array]) -> Footprint:
        """What a controller takes."""
        number, bits = _bytes_of_number(numbers), _state_bytes(numbers)
        out, once = _bytes_of_bits(len(numbers.faulty)) or 1, _bytes_of_bits(len(numbers.once))
        inside = (1, bits) if bits else (number, 1)
        timers = numbers.timers
        state = _laid((number, 1), inside, (1, out), (1, once), (number, timers), (4, 2 * timers))
        action = _laid((4, 1), (number, 3))
        # One more controller that an event makes, of rules a second one at an entry; and the frames.
        stack = (2 if bits else 1) * state + FRAMES
        largest = max(arrays, key=lambda array: array.bytes)
        return cls(state, max(numbers.longest, 1) * action, stack, largest)


def _laid(*members: tuple[int, int]) -> int:
    """Bytes of a structure: of each member its size and how many there are of it, each aligned so."""
    at, widest = 0, 1
    for size, count in members:
        if count:
            at = -(-at // size) * size + size * count
            widest = max(widest, size)
    return -(-at // widest) * widest


def _of_machines(n: MachineNumbers) -> list[Array]:
    """All tables of machines."""
    none = n.none
    arrays = _of_sections(n)
    arrays += [
        Array("type_states", n.type_states, "first of the type's states in move_start"),
        Array("type_state_count", [len(m["states"]) for m in n.types], "how many they are"),
        Array("type_entries", n.type_entries, "first of its entries"),
        Array("type_hardware", n.type_hardware, "bits of the number of an entry"),
        Array("entry_target", n.entry_target, f"first state inside, {none} where the mission cannot come"),
        Array("entry_list", n.entry_list, "list of actions"),
        Array("move_start", n.move_start, "first move of a state; the next row ends it"),
        Array("move_event", n.move_event, "event of the type"),
        Array("move_target", n.move_target, f"state, or {none - 1} - i for the section's outcome i"),
        Array("move_list", n.move_list, "list of actions"),
        Array("mode_start", n.mode_start, "first pair of a state's mode"),
        Array("mode_length", n.mode_length, "how many pairs"),
        Array("mode_activity", [pair[0] for pair in n.modes], "activity of the type that runs"),
        Array("mode_alternative", [pair[1] for pair in n.modes], "in which alternative"),
    ]
    if n.once:
        guards = list(n.guards)
        starts = [sum(map(len, guards[:g])) for g in range(len(guards) + 1)]
        told = "; of facts: + 2: is true then; + 3: is no longer true" if n.flags else ""
        arrays += [
            Array("move_guard", n.move_guard, "guard of a move"),
            Array("guard_start", starts, "first of a guard; the next row ends it"),
            Array(
                "guard_once",
                [g for guard in guards for g in guard],
                f"4 i: handler i happens; + 1: has{told}",
            ),
        ]
    if n.flags:
        arrays += [
            Array("entry_guard", n.entry_guard, "what an entry changes of facts, as a guard"),
            Array("type_once", [len(m["once"]) for m in n.types], "handlers of a type, before its facts"),
            Array(
                "type_entering", [m["entering"] for m in n.types], "bits of facts in the number of an entry"
            ),
        ]
    return arrays


def _of_rules(n: RuleNumbers) -> list[Array]:
    """All tables of rules."""
    none = n.none
    literal = "2 i: bit i is not set; 2 i + 1: it is"
    asked = f"{literal}; from the type's bits on: bit i - bits after the parts before" if n.parts else literal
    once, facts = [len(rules["once"]) for rules in n.types], [len(rules["facts"]) for rules in n.types]
    return [
        *_of_sections(n),
        Array("type_bits", [rules["bits"] for rules in n.types], "bits of a state"),
        Array("type_hardware", n.type_hardware, "how much hardware of a type can fail"),
        *([Array("type_once", once, "how many handlers of it happen once")] if n.once else []),
        *([Array("type_facts", facts, "how much may be true of its facts")] if n.flags else []),
        Array("type_rows", n.type_rows, "its row in rule_start of the entry; those of events follow"),
        Array("rule_start", n.rule_start, "first rule; the next row ends it"),
        Array("rule_literals", n.rule_literals, "first literal of a rule; the next row ends it"),
        Array("rule_effect", n.rule_effect, "effect of a rule"),
        Array("literals", n.literals, asked),
        Array("effect_start", n.effect_start, "first bit that an effect changes; the next row ends it"),
        Array("effect_bits", n.effect_bits, "a bit"),
        Array("effect_list", n.effect_list, "list of actions"),
        Array("effect_target", n.effect_target, f"{none - 1} - i for the section's outcome i, or {none}"),
        *(
            [
                Array("then_start", n.then_start, "first part that follows an effect; the next row ends it"),
                Array("then_row", n.then_row, "its row in rule_start"),
            ]
            if n.parts
            else []
        ),
        Array("type_status", n.status_first, "first of its rows in status_start: hardware, then handlers"),
        Array("status_start", n.status_start, "first bit that it changes at the entry; the next row ends it"),
        Array("status_bits", n.status_bits, "a bit"),
        Array("status_literal", n.status_literal, f"what says that it is so: {literal}"),
        Array("idle_start", n.idle_start, "first bit that is set before the entry; the next row ends it"),
        Array("idle_bits", n.idle_bits, "a bit"),
        Array("mode_start", n.mode_start, "first of a type's modes; the next row ends it"),
        Array("mode_literal", [row[0] for row in n.modes], f"what says that it runs: {literal}"),
        Array("mode_activity", [row[1] for row in n.modes], "activity of the type"),
        Array("mode_alternative", [row[2] for row in n.modes], "alternative of the type"),
    ]


def _of_sections(n: MachineNumbers | RuleNumbers) -> list[Array]:
    """Tables of sections, actions and parameters, whatever their types are."""
    none = n.none
    change: dict[int | None, int] = {e: 2 * i for i, e in enumerate(n.failures)}
    change |= {e: 2 * i + 1 for i, e in enumerate(n.repairs)}
    nothing = 2 * len(n.faulty)
    events = [change.get(e, nothing) for e in range(len(n.events))]
    columns = list(zip(*n.action_rows, strict=True)) or [(), (), (), ()]
    meaning = f"2 i: hardware i fails; 2 i + 1: it is ready again; {nothing}: neither"
    timed = (", 4 disarm, 5 arm", "; objective of a timer") if n.timers else ("", "")
    arrays = [
        *([Array("event_change", events, meaning)] if n.faulty else []),
        Array("section_type", n.section_type, "type of each section"),
        Array("section_routes", n.section_routes, "first of the section's routes, by outcome"),
        Array("route", n.route, "section entered next, or the mission's outcome"),
        Array("section_events", n.event_start, "first of the section's events in event_mission"),
        Array("section_event_count", n.event_count, "how many they are"),
        Array("event_mission", [pair[0] for pair in n.section_events], "event of the mission, ascending"),
        Array("event_local", [pair[1] for pair in n.section_events], "its number in the type"),
        Array("section_faulty", n.slices["faulty"], "the section's hardware that can fail, in pool"),
        Array("section_hardware", n.slices["hardware"], "the type's hardware, in pool"),
        Array("section_objectives", n.slices["objectives"], "its objectives"),
        Array("section_activities", n.slices["activities"], "its activities"),
        Array("section_alternatives", n.slices["alternatives"], "its alternatives"),
        Array("pool", n.pool, "numbers of elements of the mission"),
        Array("list_start", n.list_start, "first action of a list; the next row ends it"),
        Array("action_verb", list(columns[0]), f"0 stop, 1 release, 2 select, 3 start{timed[0]}"),
        Array("action_subject", list(columns[1]), f"activity of the type; hardware to release{timed[1]}"),
        Array("action_alternative", list(columns[2]), f"alternative of the type, or {none}"),
        Array("action_objective", list(columns[3]), f"objective of the type, or {none}"),
    ]
    if n.once:
        arrays.append(
            Array("section_once", n.slices["once"], "the section's handlers that happen once, in pool")
        )
    if n.changing:
        codes = [(*(2 * i for i in t), *(2 * i + 1 for i in f)) for t, f in n.changing.values()]
        row_of_event = dict(zip(n.changing, codes, strict=True))
        changes = [row_of_event.get(event, ()) for event in range(len(n.events))]
        starts = [sum(map(len, changes[:event])) for event in range(len(changes) + 1)]
        arrays += [
            Array("changing_start", starts, "first of what an event changes of facts; the next row ends it"),
            Array(
                "changing_once",
                [i for row in changes for i in row],
                "2 i: is true then; 2 i + 1: is false then",
            ),
        ]
    if n.known:
        flags = [n.known.get(i, len(n.once)) for i in range(len(n.faulty))]
        meaning = f"what says that its loss is known, or {len(n.once)} where it is known at once"
        arrays.append(Array("hardware_known", flags, meaning))
    if n.timers:
        times = [round(1000 * n.timeouts.get(name, 0.0)) for name in n.objectives]
        arrays.append(Array("objective_milliseconds", times, "how long an objective may run; 0: any time"))
        none_late = f"the event that its time is over, {len(n.events)} for none"
        arrays.append(Array("objective_late", n.late, none_late))
    for kind, law in n.law.items():
        arrays.append(Array(f"{kind}_law", [first for first, _ in law], f"first parameter of {kind}"))
        arrays.append(Array(f"{kind}_law_count", [count for _, count in law], "how many"))
    return arrays
