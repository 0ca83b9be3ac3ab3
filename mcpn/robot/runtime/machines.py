"""The behaviour of one type of sections: a table of states and edges, or rules on bits.

Both have one interface. States are numbers; handlers that happen once, hardware and events go by their
numbers in the type; actions are numbers of lists. Flags of facts are numbered after the handlers and are
members of the same sets: both are called flags, of which some are true.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from mcpn.robot.runtime.documents import LISTS, MODES

Moved = tuple[int | str, tuple[int, ...], Set[int], Set[int]]
"""The state after an event, or the outcome with which the section is left; the numbers of lists of actions;
handlers that have happened and flags that became true; flags that became false."""

Entered = tuple[int, tuple[int, ...], Set[int], Set[int]]
"""The state after an entry; the numbers of lists of actions; handlers that have happened and flags that
became true; flags that became false."""


class MachineProtocol(Protocol):
    """What sections of one type do."""

    hardware: list[str]
    flags: list[str]
    lists: list[list[dict[str, str]]]

    def entry(self, gone: Set[int], true: Set[int]) -> Entered | None:
        """The first state and the actions, with some hardware out of service, if it may be entered so."""

    def move(self, state: int, event: int, true: Set[int]) -> Moved | None:
        """What an event does; ``None`` where it cannot be taken."""

    def possible(self, state: int, true: Set[int]) -> Iterator[int]:
        """The events that can be taken."""

    def shown(self, state: int) -> Mapping[str, Any]:
        """What a state is: fields of :class:`Inside`, and ``out_of_service``."""

    def whole(self, state: int, gone: Set[int], true: Set[int]) -> bool:
        """Whether a number may be a state, with some hardware out of service."""


class _Lists:
    """Lists of actions, equal ones once."""

    def __init__(self) -> None:
        self.lists: list[list[dict[str, str]]] = []
        self._known: dict[str, int] = {}

    def number(self, actions: list[dict[str, str]]) -> int:
        """The number of a list."""
        key = json.dumps(actions)
        if key not in self._known:
            self._known[key] = len(self.lists)
            self.lists.append(actions)
        return self._known[key]


@dataclass(frozen=True, slots=True)
class TableMove:
    """An edge of a machine.

    Args:
        target: The state that it leads to, or the outcome with which the section is left.
        actions: The number of its list of actions, alone.
        open: Handlers that must not have happened yet, and happen with it, by their numbers.
        happened: Those that must have happened before.
        gained: Flags of facts that become true, by their numbers.
        lost: Flags that become false.
    """

    target: int | str
    actions: tuple[int]
    open: frozenset[int]
    happened: frozenset[int]
    gained: frozenset[int]
    lost: frozenset[int]

    def allowed(self, true: Set[int]) -> bool:
        """Whether it can be taken while some flags are true."""
        return self.open.isdisjoint(true) and self.happened <= true


_NOTHING: frozenset[int] = frozenset()
"""One for all edges without guards, of which there may be very many."""


class TypeTables:
    """The machine of a type, its edges by state and event."""

    def __init__(self, row: Mapping[str, Any]) -> None:
        self.hardware: list[str] = row["hardware"]
        self.facts: list[str] = row["facts"]
        self.flags: list[str] = row["once"] + self.facts
        self.entering = range(len(row["once"]), len(row["once"]) + row["entering"])
        self.states: list[Mapping[str, Any]] = row["states"]
        lists = _Lists()
        self.lists = lists.lists
        self.moves: list[dict[int, list[TableMove]]] = [{} for _ in self.states]
        bit = {handler: number for number, handler in enumerate(self.flags)}

        def numbers(item: Mapping[str, Any], key: str) -> frozenset[int]:
            return frozenset(bit[name] for name in item[key]) if key in item else _NOTHING

        self.entries: list[Entered | None] = [
            e and (e["to"], (lists.number(e["actions"]),), numbers(e, "gained"), numbers(e, "lost"))
            for e in row["entries"]
        ]
        for edge in row["edges"]:
            sets = (numbers(edge, key) for key in ("open", "happened", "gained", "lost"))
            move = TableMove(edge["to"], (lists.number(edge["actions"]),), *sets)
            self.moves[edge["from"]].setdefault(edge["event"], []).append(move)

    def entry(self, gone: Set[int], true: Set[int]) -> Entered | None:
        """The first state and the actions, with some hardware out of service, if it may be entered so."""
        first = len(self.hardware) - self.entering.start
        bits = [*gone, *(first + i for i in true if i in self.entering)]
        return self.entries[sum(1 << bit for bit in bits)]

    def move(self, state: int, event: int, true: Set[int]) -> Moved | None:
        """What an event does; ``None`` where it cannot be taken."""
        for move in self.moves[state].get(event, ()):
            if move.allowed(true):
                return move.target, move.actions, move.open | move.gained, move.lost
        return None

    def possible(self, state: int, true: Set[int]) -> Iterator[int]:
        """The events that can be taken."""
        for event, moves in self.moves[state].items():
            if any(move.allowed(true) for move in moves):
                yield event

    def shown(self, state: int) -> Mapping[str, Any]:
        """What a state is."""
        return self.states[state]

    def whole(self, state: int, gone: Set[int], true: Set[int]) -> bool:
        """Whether a number is a state, with some hardware out of service."""
        if not 0 <= state < len(self.states):
            return False
        said: list[str] = self.states[state]["out_of_service"]
        return set(said) == {self.hardware[i] for i in gone}


@dataclass(frozen=True, slots=True)
class Bits:
    """A condition on a state: of the bits in ``mask`` exactly those in ``value`` are set."""

    mask: int
    value: int

    @classmethod
    def of(cls, literals: Collection[int]) -> Bits:
        """The condition that all literals hold: 2 i, that bit i is not set; 2 i + 1, that it is."""
        value = _mask(literal >> 1 for literal in literals if literal & 1)
        return cls(_mask(literal >> 1 for literal in literals), value)

    def hold(self, state: int) -> bool:
        """Whether the condition holds in a state."""
        return state & self.mask == self.value


@dataclass(frozen=True, slots=True)
class RuleEffect:
    """What a rule does.

    Args:
        changes: The bits that change.
        actions: The number of its list of actions; none where the list is empty.
        to: The outcome with which the section is left.
        then: The rules of the parts with which the event goes on.
    """

    changes: int
    actions: tuple[int, ...]
    to: str | None
    then: tuple[RuleList, ...] = ()


RuleList: TypeAlias = tuple[tuple[Bits, RuleEffect], ...]
"""Rules of which the first that fits is taken."""


class RuleTables:
    """The rules of a type."""

    def __init__(self, row: Mapping[str, Any]) -> None:
        self.hardware: list[str] = row["hardware"]
        self.facts: list[str] = row["facts"]
        self.flags: list[str] = row["once"] + self.facts
        self.bits: int = row["bits"]
        lists = _Lists()
        self.lists = lists.lists
        self.idle = _mask(row["idle"])
        status = [(_mask(s["changes"]), Bits.of([s["when"]])) for s in row["status"]]
        self.of_hardware, self.of_flags = status[: len(self.hardware)], status[len(self.hardware) :]
        self.show = [(s["kind"], s["name"], Bits.of([s["when"]])) for s in row["shown"]]
        does = [
            (_mask(e["changes"]), (lists.number(e["actions"]),) if e["actions"] else (), e["to"])
            for e in row["effects"]
        ]
        parts: list[RuleList] = [
            tuple((Bits.of(rule["if"]), RuleEffect(*does[rule["do"]])) for rule in part)
            for part in row["parts"]
        ]
        effects = [
            RuleEffect(*fields, tuple(parts[part] for part in e["then"]))
            for fields, e in zip(does, row["effects"], strict=True)
        ]
        self.entries = [(Bits.of(rule["if"]), effects[rule["do"]]) for rule in row["entries"]]
        self.rules: list[list[tuple[Bits, RuleEffect]]] = [[] for _ in row["events"]]
        for rule in row["rules"]:
            self.rules[rule["event"]].append((Bits.of(rule["if"]), effects[rule["do"]]))

    def entry(self, gone: Set[int], true: Set[int]) -> Entered | None:
        """The first state and the actions, with some hardware out of service, if it may be entered so."""
        state = self.idle
        for status, so in ((self.of_hardware, gone), (self.of_flags, true)):
            for i in so:
                state ^= status[i][0]
        taken = self._taken(self.entries, state)
        return taken and (taken[0], taken[1], *self._true(taken[0]))

    def move(self, state: int, event: int, true: Set[int]) -> Moved | None:
        """What an event does; ``None`` where it cannot be taken."""
        if (taken := self._taken(self.rules[event], state)) is None:
            return None
        after, actions, to = taken
        return after if to is None else to, actions, *self._true(after)

    def _taken(
        self, rules: Sequence[tuple[Bits, RuleEffect]], state: int
    ) -> tuple[int, tuple[int, ...], str | None] | None:
        """What the first rule that fits does, with the parts that it goes on with."""
        effect = next((effect for bits, effect in rules if bits.hold(state)), None)
        if effect is None:
            return None
        after, actions, to = state ^ effect.changes, effect.actions, effect.to
        for part in effect.then:
            both = state | after << self.bits
            for bits, more in part:
                if bits.hold(both):
                    after ^= more.changes
                    actions += more.actions
                    to = more.to if to is None else to
                    break
        return after, actions, to

    def _true(self, state: int) -> tuple[Set[int], Set[int]]:
        """Handlers that have happened and flags that are true in a state; and the flags that are false."""
        now = {i for i, (_, when) in enumerate(self.of_flags) if when.hold(state)}
        return now, {*range(len(self.flags) - len(self.facts), len(self.flags))} - now

    def possible(self, state: int, true: Set[int]) -> Iterator[int]:
        """The events that can be taken."""
        for event, rules in enumerate(self.rules):
            if any(bits.hold(state) for bits, _ in rules):
                yield event

    def shown(self, state: int) -> Mapping[str, Any]:
        """What a state is."""
        lists: dict[str, list[str]] = {kind: [] for kind in LISTS}
        modes: dict[str, dict[str, str]] = {kind: {} for kind in MODES}
        for kind, name, when in self.show:
            if when.hold(state):
                if kind in modes:
                    activity, alternative = name.split(".", 1)
                    modes[kind][activity] = alternative
                else:
                    lists[kind].append(name)
        return {**lists, **modes}

    def whole(self, state: int, gone: Set[int], true: Set[int]) -> bool:
        """Whether a number may be a state: its bits agree with the hardware, handlers and flags given."""
        return (
            state >= 0
            and state.bit_length() <= self.bits
            and all(
                when.hold(state) == (i in so)
                for status, so in ((self.of_hardware, gone), (self.of_flags, true))
                for i, (_, when) in enumerate(status)
            )
        )


def _mask(numbers: Iterable[int]) -> int:
    return sum(1 << number for number in set(numbers))
