"""The controller as rules: its size is a sum over what events do, not over states.

The state of a section is a set of *bits*; each stands for a place of its local net, or for the opposite of
one. An event is handled by one of its *rules* that fits: it asks some bits to be set and others not. The
rule's *effect* says which bits change, which actions are ordered, and with which outcome the section is left,
if it is. Rules of one event that fit one state have the same effect.

Rules are the big steps of the local net (:mod:`mcpn.spaces.stable.big_steps`), each proved to be the one
outcome of its event in all stable states that it fits; every such state fits one. A section is entered from
its idle marking, in which the bits of hardware out of service, and of handlers that have happened, are
changed, by the rules of its start. So nothing is listed for each state of hardware.

The actions of a rule are computed in one state that it fits; where actions depend on a place that the rule
does not ask for, the rule is split by this place. Then literals are dropped that are not needed to tell rules
of an event apart, and bits that no literal asks for (:mod:`mcpn.controller.reduce`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

from mcpn.controller.hierarchy import PlacedMachine, TableController
from mcpn.controller.machine import PlannedAction
from mcpn.events import Event
from mcpn.notebook import Drawn

Literals = tuple[int, ...]
"""A conjunction of literals: 2 i asks that bit i is not set, 2 i + 1 that it is.

Bits from the number of bits on are those of the state that the parts before have made so far.
"""


@dataclass(frozen=True, slots=True)
class Effect:
    """What a rule does; several rules may have one effect.

    Args:
        changes: The bits that change.
        actions: In order.
        to: The outcome with which the section is left; ``None`` where it goes on.
        then: Numbers of the parts that come then, in order.
    """

    changes: tuple[int, ...]
    actions: tuple[PlannedAction, ...]
    to: str | None = None
    then: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Rule:
    """When an event has an effect.

    Args:
        event: Number of the event; -1 for the entry; behind events the parts are numbered.
        literals: What it asks of bits, the literals that exclude most other rules first.
        effect: Number of the effect.
    """

    event: int
    literals: Literals
    effect: int


@dataclass(frozen=True, slots=True)
class StatusBits:
    """The bits of an element whose status sections hand on: hardware, a handler, a flag of a fact.

    Args:
        changes: The bits that change before the entry where the hardware is out of service, the handler has
            happened or the flag is true.
        literal: True inside the section exactly where this is so.
    """

    changes: tuple[int, ...]
    literal: int


@dataclass(frozen=True, slots=True)
class Shown:
    """What is said of an element where a literal is true.

    Args:
        kind: A field of :class:`mcpn.answers.verdicts.modes.Situation`.
        name: The element; for modes and what waits, ``activity.alternative``.
        literal: When.
    """

    kind: str
    name: str
    literal: int


@dataclass(frozen=True)
class Rules:
    """The rules of one type of sections, with the names of the section that stands for it.

    Args:
        hardware: The section's hardware that can fail.
        once: Its handlers that happen once.
        facts: What may be true of its facts.
        events: By number.
        bits: How many bits a state has.
        idle: The bits that are set before the entry, with all hardware in service.
        status: By element, of the hardware, then of the handlers, then of what may be true of facts.
        shown: What states say, in the mission's order.
        entries: The rules of the entry.
        rules: The rules inside, sorted by event.
        parts: By number, rules of which the first that fits is taken, if one does.
        effects: By number.
    """

    hardware: tuple[str, ...]
    once: tuple[str, ...]
    facts: tuple[str, ...]
    events: tuple[Event, ...]
    bits: int
    idle: tuple[int, ...]
    status: tuple[StatusBits, ...]
    shown: tuple[Shown, ...]
    entries: tuple[Rule, ...]
    rules: tuple[Rule, ...]
    parts: tuple[tuple[Rule, ...], ...]
    effects: tuple[Effect, ...]

    @property
    def every(self) -> Iterator[Rule]:
        """All rules."""
        return chain(self.entries, self.rules, *self.parts)

    @property
    def literals(self) -> int:
        """Literals of all rules."""
        return sum(len(rule.literals) for rule in self.every)

    @cached_property
    def by_event(self) -> Mapping[int, tuple[Rule, ...]]:
        """Rules by event; those of part i by the number of events and i."""
        found: dict[int, list[Rule]] = {}
        for rule in self.every:
            found.setdefault(rule.event, []).append(rule)
        return {event: tuple(rules) for event, rules in found.items()}

    @property
    def most(self) -> tuple[int, int]:
        """The most rules, and the most literals, that are looked at for one event, or for an entry."""
        found, events = [(0, 0)], len(self.events)
        for event in range(-1, events):
            rules = self.by_event.get(event, ())
            own, effects = _looked_at(rules), {rule.effect for rule in rules}
            then = [
                [_looked_at(self.by_event[events + part]) for part in self.effects[effect].then]
                for effect in effects
            ]
            found.append(
                (
                    own[0] + max((sum(rules for rules, _ in parts) for parts in then), default=0),
                    own[1] + max((sum(literals for _, literals in parts) for parts in then), default=0),
                )
            )
        return max(rules for rules, _ in found), max(literals for _, literals in found)


def _looked_at(rules: Sequence[Rule]) -> tuple[int, int]:
    """How many rules these are, and how many literals."""
    return len(rules), sum(len(rule.literals) for rule in rules)


@dataclass(frozen=True)
class ModularController(Drawn):
    """A mission controller of rules.

    Args:
        mission: The mission's name.
        hardware: Hardware that can fail, in the mission's order.
        initial: The section entered at the mission's start.
        sections: In document order.
        types: The rules of their types.
    """

    mission: str
    hardware: tuple[str, ...]
    initial: str
    sections: tuple[PlacedMachine, ...]
    types: tuple[Rules, ...]
    form = "modular"
    minimised = False

    def __repr__(self) -> str:
        return f"<modular controller of the mission {self.mission}: {self.size}>"

    @property
    def rules(self) -> int:
        """Rules of all types, those of entries and parts included."""
        return sum(sum(1 for _ in type_.every) for type_ in self.types)

    @property
    def literals(self) -> int:
        """What they ask of bits, together."""
        return sum(type_.literals for type_ in self.types)

    @property
    def bits(self) -> int:
        """Bits of a state, of the type that has most."""
        return max(type_.bits for type_ in self.types)

    @property
    def most(self) -> tuple[int, int]:
        """Rules and literals that are looked at when an event leads from one section to the next, at most."""
        rules, literals = (max(column) for column in zip(*(type_.most for type_ in self.types), strict=True))
        return 2 * rules, 2 * literals

    @property
    def size(self) -> str:
        """In words, with the bound of an event's time."""
        rules, literals = self.most
        return (
            f"{len(self.sections)} sections of {len(self.types)} types, {self.rules} rules of "
            f"{self.literals} literals on {self.bits} bits; an event looks at {rules} rules, "
            f"{literals} literals, at most"
        )


AnyController = TableController | ModularController
"""A controller of whatever form."""
