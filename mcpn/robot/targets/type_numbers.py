"""Types of sections as numbers, for targets with constant tables: machines (states and edges), and rules.

A *guard* is a list of numbers: first 4 i for each handler of the section that must not have happened yet, and
happens then, and 4 i + 1 for each that must have happened; then 4 i + 2 for what becomes true of facts, which
are numbered behind handlers, and 4 i + 3 for what is no longer true. The empty one is the first.

Of rules, a row of ``rule_start`` is the entry of a type, the next ones are its events. A literal is 2 i where
bit i is not set, and 2 i + 1 where it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from mcpn.robot.targets.numbers import Numbers, Own, Pool, Row


class MachineNumbers(Numbers):
    """Tables of machines: states, entries, moves and modes."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.type_states: list[int] = []  # the first row of a type in move_start and mode_start
        self.type_entries: list[int] = []
        self.entry_target: list[int] = []
        self.entry_list: list[int] = []
        self.entry_guard: list[int] = []
        self.move_start: list[int] = []
        self.move_event: list[int] = []
        self.move_target: list[int] = []
        self.move_list: list[int] = []
        self.move_guard: list[int] = []
        self.guards: dict[tuple[int, ...], int] = {(): 0}
        self.mode_start: list[int] = []
        self.mode_length: list[int] = []
        self._modes: Pool[tuple[int, int]] = Pool()
        super().__init__(document)

    @property
    def modes(self) -> list[tuple[int, int]]:
        """Pairs of an activity and an alternative of a type."""
        return self._modes.items

    def _size(self, type_: Row) -> int:
        return len(type_["states"])

    def _said(self, type_: Row) -> tuple[Iterable[Sequence[Row]], Iterable[tuple[str, str]]]:
        lists = [step["actions"] for step in (*filter(None, type_["entries"]), *type_["edges"])]
        return lists, (pair for state in type_["states"] for pair in state["mode"].items())

    def _type(self, type_: Row, own: Own, left: Mapping[str, int]) -> None:
        self.type_states.append(len(self.move_start))
        self.type_entries.append(len(self.entry_target))
        for entry in type_["entries"]:
            self.entry_target.append(self.none if entry is None else entry["to"])
            self.entry_list.append(0 if entry is None else self._list(entry["actions"], own))
            changes = () if entry is None else changes_of(type_, entry)
            self.entry_guard.append(self.guards.setdefault(changes, len(self.guards)))
        moves = iter(type_["edges"])
        move = next(moves, None)
        for number, state in enumerate(type_["states"]):
            self.move_start.append(len(self.move_event))
            while move is not None and move["from"] == number:
                target = move["to"]
                self.move_event.append(move["event"])
                self.move_target.append(target if isinstance(target, int) else left[target])
                self.move_list.append(self._list(move["actions"], own))
                guard = guard_of(type_, move)
                self.move_guard.append(self.guards.setdefault(guard, len(self.guards)))
                move = next(moves, None)
            mode = state["mode"].items()
            pairs = [(own["activities"][a], own["alternatives"][f"{a}.{w}"]) for a, w in mode]
            self.mode_start.append(self._modes.add(pairs))
            self.mode_length.append(len(pairs))
        # One row more, so that the moves of the last state end where the next row begins.
        self.move_start.append(len(self.move_event))
        self.mode_start.append(0)
        self.mode_length.append(0)

    @property
    def most_moves(self) -> int:
        """The most events that are possible in one state."""
        return max(b - a for a, b in zip(self.move_start, self.move_start[1:], strict=False))

    def entry_lists(self, kind: int) -> Iterable[Sequence[int]]:
        """By entry of a type, its list of actions."""
        first = self.type_entries[kind]
        return [[number] for number in self.entry_list[first : first + len(self.types[kind]["entries"])]]

    def moved(self, kind: int) -> Iterator[tuple[int, Sequence[int]]]:
        """Where the events of a type lead, each with its list of actions."""
        row = self.type_states[kind]
        first, last = self.move_start[row], self.move_start[row + len(self.types[kind]["states"])]
        return zip(
            self.move_target[first:last], ([number] for number in self.move_list[first:last]), strict=True
        )


def guard_of(machine: Row, move: Row) -> tuple[int, ...]:
    """The guard of a move as numbers, with what it changes of facts."""
    number = machine["once"].index
    asked = (*(4 * number(h) for h in move["open"]), *(4 * number(h) + 1 for h in move["happened"]))
    return (*asked, *changes_of(machine, move))


def changes_of(machine: Row, step: Row) -> tuple[int, ...]:
    """What a move or an entry changes of facts, as numbers."""
    first = len(machine["once"])
    number = {flag: first + i for i, flag in enumerate(machine["facts"])}
    gained, lost = (4 * number[f] + 2 for f in step["gained"]), (4 * number[f] + 3 for f in step["lost"])
    return (*gained, *lost)


class RuleNumbers(Numbers):
    """Tables of rules: literals, effects, what hardware and handlers change, modes."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.type_rows: list[int] = []  # the first row of a type in rule_start
        self.rule_start: list[int] = []
        self.rule_literals: list[int] = []
        self.rule_effect: list[int] = []
        self.literals: list[int] = []
        self.effect_start: list[int] = []
        self.effect_bits: list[int] = []
        self.effect_list: list[int] = []
        self.effect_target: list[int] = []
        self.then_start: list[int] = []
        self.then_row: list[int] = []  # in rule_start
        self.status_first: list[int] = []  # the first row of a type in status_start: hardware, then handlers
        self.status_start: list[int] = []
        self.status_bits: list[int] = []
        self.status_literal: list[int] = []
        self.idle_start: list[int] = []
        self.idle_bits: list[int] = []
        self.mode_start: list[int] = []
        self.modes: list[tuple[int, int, int]] = []  # a literal, an activity, its alternative
        super().__init__(document)

    def _size(self, type_: Row) -> int:
        return 0

    def _said(self, type_: Row) -> tuple[Iterable[Sequence[Row]], Iterable[tuple[str, str]]]:
        return (effect["actions"] for effect in type_["effects"]), (pair for pair, _ in _modes(type_))

    def _type(self, type_: Row, own: Own, left: Mapping[str, int]) -> None:
        first = len(self.effect_start)
        for effect in type_["effects"]:
            self.effect_start.append(len(self.effect_bits))
            self.effect_bits += effect["changes"]
            self.effect_list.append(self._list(effect["actions"], own))
            self.effect_target.append(self.none if effect["to"] is None else left[effect["to"]])
            self.then_start.append(len(self.then_row))
            behind = len(self.rule_start) + 1 + len(type_["events"])
            self.then_row += [behind + part for part in effect["then"]]
        self.type_rows.append(len(self.rule_start))
        by_event: list[list[Row]] = [[] for _ in type_["events"]]
        for rule in type_["rules"]:
            by_event[rule["event"]].append(rule)
        for rules in (type_["entries"], *by_event, *type_["parts"]):
            self.rule_start.append(len(self.rule_effect))
            for rule in rules:
                self.rule_literals.append(len(self.literals))
                self.literals += rule["if"]
                self.rule_effect.append(first + rule["do"])
        self.status_first.append(len(self.status_start))
        for status in type_["status"]:
            self.status_start.append(len(self.status_bits))
            self.status_bits += status["changes"]
            self.status_literal.append(status["when"])
        self.idle_start.append(len(self.idle_bits))
        self.idle_bits += type_["idle"]
        self.mode_start.append(len(self.modes))
        for (activity, alternative), literal in _modes(type_):
            names = own["activities"][activity], own["alternatives"][f"{activity}.{alternative}"]
            self.modes.append((literal, *names))

    def _ended(self) -> None:
        for starts, rows in (
            (self.rule_start, self.rule_effect),
            (self.rule_literals, self.literals),
            (self.effect_start, self.effect_bits),
            (self.then_start, self.then_row),
            (self.status_start, self.status_bits),
            (self.idle_start, self.idle_bits),
            (self.mode_start, self.modes),
        ):
            starts.append(len(rows))  # one row more, where the last one ends

    @property
    def bits(self) -> int:
        """Bits of a state, whatever section it is in."""
        return max(int(type_["bits"]) for type_ in self.types)

    @property
    def parts(self) -> bool:
        """Whether some event goes on with parts."""
        return bool(self.then_row)

    def entry_lists(self, kind: int) -> Iterable[Sequence[int]]:
        """By rule of a type's entry, the lists of actions that it may give."""
        row = self.type_rows[kind]
        return [[self.effect_list[e] for e in effects] for effects in self._effects(row, row + 1)]

    def moved(self, kind: int) -> Iterator[tuple[int, Sequence[int]]]:
        """Where the rules of a type's events may lead, each with the lists of actions that it may give."""
        row = self.type_rows[kind] + 1
        for effects in self._effects(row, row + len(self.types[kind]["events"])):
            lists = [self.effect_list[e] for e in effects]
            yield from ((target, lists) for target in {self.effect_target[e] for e in effects})

    def _effects(self, first: int, end: int) -> Iterator[list[int]]:
        """By rule of some rows, its effect and those of the parts that may follow."""
        for effect in self.rule_effect[self.rule_start[first] : self.rule_start[end]]:
            found = [effect]
            for row in self.then_row[self.then_start[effect] : self.then_start[effect + 1]]:
                found += self.rule_effect[self.rule_start[row] : self.rule_start[row + 1]]
            yield found


def _modes(type_: Row) -> Iterator[tuple[tuple[str, str], int]]:
    """Activities with alternatives in which they may run, each with the literal that says so."""
    for shown in type_["shown"]:
        if shown["kind"] == "mode":
            activity, alternative = shown["name"].split(".", 1)
            yield (activity, alternative), shown["when"]
