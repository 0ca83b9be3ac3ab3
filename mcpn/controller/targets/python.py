"""The controller in Python: one file that needs nothing else.

Its tables are those of the C target and its code is not that of :mod:`mcpn.runtime`, so that each is a second
opinion on the other.
"""

from __future__ import annotations

from collections.abc import Sequence

from mcpn.controller.hierarchy import Controller
from mcpn.controller.targets.names import PYTHON_KEYWORDS, comment, identifiers
from mcpn.controller.targets.numbers import Numbers, guard_of
from mcpn.controller.targets.render import render
from mcpn.net.compose import MissionNet


def write_python(controller: Controller, mission_net: MissionNet) -> dict[str, str]:
    """The file by name.

    Args:
        controller: The controller.
        mission_net: The mission's net, for the parameters.
    """
    numbers = Numbers(controller, mission_net)
    name = identifiers([controller.mission], keywords=PYTHON_KEYWORDS)[controller.mission].lower()
    types = []
    for kind, machine in enumerate(controller.types):
        first = numbers.type_states[kind]
        entry = numbers.type_entries[kind]
        moves: list[list[tuple[int | str, ...]]] = [[] for _ in machine.states]
        for row, move in enumerate(machine.moves, numbers.move_start[first]):
            guard = guard_of(machine, move)
            moves[move.source].append((move.event, move.target, numbers.move_list[row], *guard))
        modes = [
            numbers.modes[numbers.mode_start[state] : numbers.mode_start[state] + numbers.mode_length[state]]
            for state in range(first, first + len(machine.states))
        ]
        entries = [
            (None if e is None else e.target, numbers.entry_list[row])
            for row, e in enumerate(machine.entries, entry)
        ]
        types.append({"moves": moves, "modes": modes, "entries": entries, "hardware": len(machine.hardware)})
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


def _section(n: Numbers, i: int) -> dict[str, object]:
    kind = n.section_type[i]
    own = n.lengths(kind)

    def slice_of(name: str, length: int) -> list[int]:
        first = n.slices[name][i]
        return n.pool[first : first + length]

    ends = {n.success: Name("SUCCESS"), n.failure: Name("FAILURE")}
    outcomes = n.controller.sections[i].routes
    first, count = n.event_start[i], n.event_count[i]
    return {
        "name": n.sections[i],
        "type": kind,
        "routes": {outcome: ends.get(to, to) for outcome, to in zip(outcomes, n.routes[i], strict=True)},
        "events": dict(n.section_events[first : first + count]),
        "faulty": slice_of("faulty", n.type_hardware[kind]),
        **({"once": slice_of("once", len(n.controller.types[kind].once))} if n.once else {}),
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
