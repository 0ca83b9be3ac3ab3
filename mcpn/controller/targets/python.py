"""The controller in Python: one file that needs nothing else.

Its tables are those of the C target and its code is not that of :mod:`mcpn.runtime`, so that each is a second
opinion on the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mcpn.controller.hierarchy import SectionMachine
from mcpn.controller.modular import AnyController, ModularController, Rule, Rules
from mcpn.controller.targets.names import PYTHON_KEYWORDS, comment, identifiers
from mcpn.controller.targets.render import render
from mcpn.controller.targets.tables import MachineNumbers, RuleNumbers, changes_of, guard_of
from mcpn.net.compose import MissionNet


def write_python(controller: AnyController, mission_net: MissionNet) -> dict[str, str]:
    """The file by name.

    Args:
        controller: The controller.
        mission_net: The mission's net, for the parameters.
    """
    numbers: MachineNumbers | RuleNumbers
    if isinstance(controller, ModularController):
        numbers = RuleNumbers(controller, mission_net)
        types = [_of_rules(numbers, kind) for kind in range(len(controller.types))]
    else:
        numbers = MachineNumbers(controller, mission_net)
        types = [_of_machine(numbers, kind) for kind in range(len(controller.types))]
    name = identifiers([controller.mission], keywords=PYTHON_KEYWORDS)[controller.mission].lower()
    lists = [
        [
            (
                verb,
                subject,
                None if alternative == numbers.none else alternative,
                None if objective == numbers.none else objective,
            )
            for verb, subject, alternative, objective in numbers.action_rows[a:b]
        ]
        for a, b in zip(numbers.list_start, numbers.list_start[1:], strict=False)
    ]
    sections = [_section(numbers, i) for i in range(len(numbers.sections))]
    text = render(
        "controller.py.jinja",
        mission=comment(controller.mission),
        controller=controller,
        rules=isinstance(controller, ModularController),
        n=numbers,
        types=types,
        lists=lists,
        sections=sections,
        literal=literal,
        laws={
            kind: [
                {p.name: (p.value, p.unit) for p in numbers.parameters[first : first + count]}
                for first, count in law
            ]
            for kind, law in numbers.law.items()
        },
    )
    return {f"{name}_controller.py": text}


def _of_machine(n: MachineNumbers, kind: int) -> dict[str, object]:
    """The tables of a machine."""
    machine = n.types[kind]
    first, entry = n.type_states[kind], n.type_entries[kind]
    moves: list[list[tuple[int | str, ...]]] = [[] for _ in machine.states]
    for row, move in enumerate(machine.moves, n.move_start[first]):
        moves[move.source].append((move.event, move.target, n.move_list[row], *guard_of(machine, move)))
    modes = [
        n.modes[n.mode_start[state] : n.mode_start[state] + n.mode_length[state]]
        for state in range(first, first + len(machine.states))
    ]
    entries: list[tuple[int | None, ...]] = [
        (None if e is None else e.target, n.entry_list[row], *(changes_of(machine, e) if e else ()))
        for row, e in enumerate(machine.entries, entry)
    ]
    return {"moves": moves, "modes": modes, "entries": entries}


def _of_rules(n: RuleNumbers, kind: int) -> dict[str, object]:
    """The tables of rules; sets of bits are numbers."""
    rules: Rules = n.types[kind]
    first = sum(len(earlier.effects) for earlier in n.types[:kind])

    def asked(rule: Rule) -> tuple[int, int, int]:
        marked = (literal >> 1 for literal in rule.literals if literal & 1)
        return _mask(literal >> 1 for literal in rule.literals), _mask(marked), rule.effect

    return {
        "idle": _mask(rules.idle),
        "status": [(_mask(s.changes), s.literal >> 1, s.literal & 1) for s in rules.status],
        "modes": [
            (literal >> 1, literal & 1, *pair)
            for literal, *pair in n.modes[n.mode_start[kind] : n.mode_start[kind + 1]]
        ],
        "effects": [
            (_mask(effect.changes), n.effect_list[row], effect.to)
            for row, effect in enumerate(rules.effects, first)
        ],
        "entries": [asked(rule) for rule in rules.entries],
        "rules": [[asked(rule) for rule in rules.of.get(e, ())] for e in range(len(rules.events))],
    }


def _mask(bits: Iterable[int]) -> int:
    return sum(1 << bit for bit in bits)


def _section(n: MachineNumbers | RuleNumbers, i: int) -> dict[str, object]:
    kind = n.section_type[i]
    own = n.lengths(kind)

    def slice_of(name: str, length: int) -> list[int]:
        first = n.slices[name][i]
        return n.pool[first : first + length]

    type_ = n.types[kind]
    mine = slice_of("once", len(type_.once) + len(type_.facts))
    before = len(type_.once) + (type_.entering if isinstance(type_, SectionMachine) else 0)
    entering = mine[len(type_.once) : before]
    ends = {n.success: Name("SUCCESS"), n.failure: Name("FAILURE")}
    if n.abort is not None:
        ends[n.abort] = Name("ABORT")
    outcomes = n.controller.sections[i].routes
    first, count = n.event_start[i], n.event_count[i]
    return {
        "name": n.sections[i],
        "type": kind,
        "routes": {outcome: ends.get(to, to) for outcome, to in zip(outcomes, n.routes[i], strict=True)},
        "events": dict(n.section_events[first : first + count]),
        "faulty": slice_of("faulty", n.type_hardware[kind]),
        **({"once": mine} if n.once else {}),
        **({"facts": mine[len(type_.once) :]} if n.flags else {}),
        **({"entering": entering} if n.flags and isinstance(type_, SectionMachine) else {}),
        "hardware": [n.hardware[k] for k in slice_of("hardware", own["hardware"])],
        "objectives": slice_of("objectives", own["objectives"]),
        "activities": slice_of("activities", own["activities"]),
        "alternatives": slice_of("alternatives", own["alternatives"]),
    }


class Name(str):
    """A name that the generated file gives a meaning; other strings are texts."""

    __slots__ = ()


def literal(value: object) -> str:
    """A value in Python's own words: tuples for lists."""
    if isinstance(value, str):
        return str(value) if isinstance(value, Name) else quoted(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    if isinstance(value, Sequence):
        parts = [literal(v) for v in value]
        return f"({parts[0]},)" if len(parts) == 1 else f"({', '.join(parts)})"
    return repr(value)


def quoted(text: str) -> str:
    """A text between double quotes, ASCII alone."""
    found = []
    for character in text:
        if character in '"\\':
            found.append(f"\\{character}")
        elif " " <= character <= "~":
            found.append(character)
        else:
            code = ord(character)
            found.append(f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}")
    return f'"{"".join(found)}"'
