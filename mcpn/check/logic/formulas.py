"""Formulas of CTL: Boolean connectives, ``EX``, ``EU`` and ``EG`` over conditions on markings.

Every other operator is written with these (:data:`OPERATORS`). Names of places, transitions and elements of
the mission are looked up as a formula is read (:mod:`mcpn.check.logic.names`).

Paths are maximal: infinite, or ending in a state without successors. In such a state ``EX`` of anything is
false, ``AX`` of anything true, and ``EG f`` and ``AF f`` are what ``f`` is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import AllOf, AnyOf, AtMost, Dead, Goal, fireable
from mcpn.space.search.goal import negation as other_markings

MAX_SIZE = 50_000


@dataclass(frozen=True, slots=True)
class Const:
    """True or false everywhere."""

    value: bool


@dataclass(frozen=True, slots=True)
class Deadlock:
    """Nothing may fire."""


@dataclass(frozen=True, slots=True)
class Stable:
    """No internal transition may fire; true everywhere in nets without priorities."""


@dataclass(frozen=True, slots=True)
class Fires:
    """Some of these transitions, by index, may fire now, priorities respected."""

    transitions: tuple[int, ...]


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


Formula: TypeAlias = AtMost | Const | Deadlock | Stable | Fires | Not | And | Or | EX | EG | EU
TRUE, FALSE = Const(True), Const(False)


@dataclass(frozen=True, slots=True)
class Justice:
    """A constraint on infinite paths: they meet it again and again, or do not count.

    Temporal operators in the constraint itself speak of all paths.

    Args:
        states: A path meets the constraint in these states,
        transitions: and wherever it fires one of these.
    """

    states: Formula = FALSE
    transitions: tuple[int, ...] = ()


def negation(formula: Formula) -> Formula:
    """The negation, without doubling one."""
    match formula:
        case Not(operand):
            return operand
        case Const(value):
            return Const(not value)
    return Not(formula)


def _same(a: Formula, b: Formula) -> Formula:
    return Or((And((a, b)), And((negation(a), negation(b)))))


def _every_until(a: Formula, b: Formula) -> Formula:
    stays = negation(b)
    return And((negation(EU(stays, And((negation(a), stays)))), negation(EG(stays))))


OPERATORS: Mapping[str, Callable[..., Formula]] = {
    "!": negation,
    "&": lambda *operands: And(operands),
    "|": lambda *operands: Or(operands),
    "->": lambda a, b: Or((negation(a), b)),
    "<->": _same,
    "EX": EX,
    "AX": lambda a: negation(EX(negation(a))),
    "EF": lambda a: EU(TRUE, a),
    "AF": lambda a: negation(EG(negation(a))),
    "EG": EG,
    "AG": lambda a: negation(EU(TRUE, negation(a))),
    "EU": EU,
    "AU": _every_until,
}
"""By the operators that people write, the formulas of their operands."""

Sum: TypeAlias = tuple[int, tuple[int, ...]]
"""A constant and the tokens of some places, by index; a place that stands twice counts twice."""


def compare(left: Sum, relation: str, right: Sum) -> Formula:
    """A comparison of two sums of tokens.

    Args:
        left: The sum on the left.
        relation: ``<``, ``<=``, ``=``, ``!=``, ``>=`` or ``>``.
        right: The sum on the right.
    """
    if relation in ("=", "!="):
        equal = And((compare(left, "<=", right), compare(right, "<=", left)))
        return equal if relation == "=" else Not(equal)
    if relation in (">", ">="):
        left, right = right, left
    weights = Counter(left[1])
    weights.subtract(right[1])
    terms = tuple(sorted((place, weight) for place, weight in weights.items() if weight))
    bound = right[0] - left[0] - ("=" not in relation)
    return AtMost(terms, bound) if terms else Const(bound >= 0)


def operands(formula: Formula) -> tuple[Formula, ...]:
    """The formulas directly inside a formula."""
    match formula:
        case And(inside) | Or(inside):
            return inside
        case Not(a) | EX(a) | EG(a):
            return (a,)
        case EU(a, b):
            return (a, b)
    return ()


def mapped(formula: Formula, of: Callable[[Formula], Formula]) -> Formula:
    """The same operator with other operands: each is what ``of`` makes of it."""
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


def walk(formula: Formula) -> Iterator[Formula]:
    """Every formula inside a formula, itself included."""
    stack = [formula]
    while stack:
        at = stack.pop()
        yield at
        stack.extend(operands(at))


def within_limit(formula: Formula) -> Formula:
    """A formula, if it is not too large: ``<->`` and ``A[ U ]`` say what is in them twice.

    Raises:
        LimitError: It has more than :data:`MAX_SIZE` operators.
    """
    if any(number == MAX_SIZE for number, _ in enumerate(walk(formula))):
        raise LimitError(f"the formula says more than {MAX_SIZE} operators in full: the limit was hit")
    return formula


def as_reachability(formula: Formula, net: PetriNet) -> Goal | None:
    """The markings of ``f`` where a formula is ``EF f`` and needs no more than a search; else ``None``."""
    match formula:
        case EU(Const(True), inside):
            return as_goal(inside, net)
    return None


def as_goal(formula: Formula, net: PetriNet) -> Goal | None:
    """The markings of a net without priorities that satisfy a formula; ``None`` if it speaks of paths."""
    match formula:
        case Const(value):
            return AllOf(()) if value else AnyOf(())
        case Not(operand):
            inside = as_goal(operand, net)
            return None if inside is None else other_markings(inside)
        case And(several) | Or(several):
            goals = [as_goal(operand, net) for operand in several]
            known = tuple(each for each in goals if each is not None)
            if len(known) < len(goals):
                return None
            return AllOf(known) if isinstance(formula, And) else AnyOf(known)
        case AtMost():
            return formula
        case Fires(transitions):
            return AnyOf(tuple(fireable(net, t) for t in transitions))
        case Deadlock():
            return Dead()
        case Stable():
            return AllOf(())
    return None
