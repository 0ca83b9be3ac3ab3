"""Formulas of CTL: what a user writes, and the small core that evaluation knows.

What is written names places, transitions and words of the mission (:class:`Compare`, :class:`Enabled`,
:class:`Word`) and has all operators. The core, which :mod:`mcpn.check.logic.resolve` makes, has indices for
names, and ``!``, ``&``, ``|``, ``EX``, ``EU`` and ``EG`` for all operators.

Paths are maximal: infinite, or ending in a state without successors. In such a state ``EX`` of anything is
false, ``AX`` of anything true, and ``EG f`` and ``AF f`` are what ``f`` is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, get_args

from mcpn.space.search.goal import AtMost

Relation: TypeAlias = Literal["<", "<=", "=", "!=", ">=", ">"]
RELATIONS: tuple[Relation, ...] = get_args(Relation)


@dataclass(frozen=True, slots=True)
class Const:
    """True or false everywhere."""

    value: bool


@dataclass(frozen=True, slots=True)
class Not:
    """Negation."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class And:
    """Conjunction; true without operands."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """Disjunction; false without operands."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class EX:
    """Some next state satisfies the operand."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class EG:
    """Some path satisfies the operand all along."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class EU:
    """Some path satisfies the left operand until it reaches the right one."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Derived:
    """An operator that the core does without; :data:`MEANING` has what it stands for."""

    operator: str
    operands: tuple[Formula, ...]


# --- atoms as they are written -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Sum:
    """A constant and the tokens of some places; a place that stands twice counts twice."""

    constant: int
    places: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Compare:
    """A comparison of two sums of tokens."""

    left: Sum
    relation: Relation
    right: Sum
    column: int | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Enabled:
    """Some of these transitions may fire now, priorities respected."""

    transitions: tuple[str, ...]
    column: int | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Deadlock:
    """Nothing may fire."""


@dataclass(frozen=True, slots=True)
class Stable:
    """No internal transition may fire; true everywhere in nets without priorities."""


@dataclass(frozen=True, slots=True)
class Word:
    """A word of the mission.

    Args:
        kind: One of :data:`WORDS`, or ``success`` or ``failure``, which have no argument.
        argument: The element's name.
        value: For ``alternative(activity)=value``.
        column: Where it stands, from 1.
    """

    kind: str
    argument: str | None = None
    value: str | None = None
    column: int | None = field(default=None, compare=False)


WORDS = {
    "objective": "the objective runs",
    "pending": "the objective is about to be entered",
    "activity": "an alternative of the activity runs",
    "alternative": "this alternative of the activity runs",
    "waiting": "the activity waits for a resource",
    "refused": "the activity has no possible alternative",
    "oos": "the hardware resource is out of service",
    "available": "the hardware is in service; the software's producer runs",
    "event": "the event may be the next to happen",
}

# --- atoms of the core ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Fires:
    """Some of these transitions, by index, may fire now."""

    transitions: tuple[int, ...]


Written: TypeAlias = Compare | Enabled | Word
Formula: TypeAlias = (
    Const | Not | And | Or | EX | EG | EU | Derived | Deadlock | Stable | Written | AtMost | Fires
)
Core: TypeAlias = Formula
"""A formula without :data:`Written` atoms and without :class:`Derived` operators."""

TRUE, FALSE = Const(True), Const(False)


@dataclass(frozen=True, slots=True)
class Justice:
    """A constraint on infinite paths: they meet it again and again, or do not count.

    Temporal operators in the constraint itself speak of all paths.

    Args:
        states: A path meets the constraint in these states,
        transitions: and wherever it fires one of these.
    """

    states: Core = Const(False)
    transitions: tuple[int, ...] = ()


def negation(formula: Formula) -> Formula:
    """The negation, without doubling one."""
    match formula:
        case Not(operand):
            return operand
        case Const(value):
            return Const(not value)
    return Not(formula)


def _both(a: Core, b: Core) -> Core:
    return And((a, b))


def _every_until(a: Core, b: Core) -> Core:
    stays = negation(b)
    return _both(negation(EU(stays, _both(negation(a), stays))), negation(EG(stays)))


MEANING: Mapping[str, Callable[..., Core]] = {
    "->": lambda a, b: Or((negation(a), b)),
    "<->": lambda a, b: Or((_both(a, b), _both(negation(a), negation(b)))),
    "AX": lambda a: negation(EX(negation(a))),
    "EF": lambda a: EU(TRUE, a),
    "AF": lambda a: negation(EG(negation(a))),
    "AG": lambda a: negation(EU(TRUE, negation(a))),
    "AU": _every_until,
}
"""What derived operators stand for in the core."""


def temporal(operator: str, *operands: Formula) -> Formula:
    """The formula of a temporal operator, given by its name: ``EX``, ``AU`` and so on."""
    basic: Mapping[str, Callable[..., Formula]] = {"EX": EX, "EG": EG, "EU": EU}
    return basic[operator](*operands) if operator in basic else Derived(str(operator), operands)


def operands(formula: Formula) -> tuple[Formula, ...]:
    """The formulas directly inside a formula."""
    match formula:
        case And(inside) | Or(inside) | Derived(_, inside):
            return inside
        case Not(a) | EX(a) | EG(a):
            return (a,)
        case EU(a, b):
            return (a, b)
    return ()


def mapped(formula: Core, of: Callable[[Core], Core]) -> Core:
    """The same operator of the core with other operands: each is what ``of`` makes of it."""
    match formula:
        case And(inside) | Or(inside):
            return type(formula)(tuple(map(of, inside)))
        case Not(a):
            return negation(of(a))
        case EX(a) | EG(a):
            return type(formula)(of(a))
        case EU(a, b):
            return EU(of(a), of(b))
    return formula


def walk(formula: Formula) -> Iterator[tuple[Formula, int]]:
    """Every formula inside a formula, itself included, with the number of operators around it."""
    stack = [(formula, 0)]
    while stack:
        at, depth = stack.pop()
        yield at, depth
        stack.extend((inside, depth + 1) for inside in operands(at))
