"""Formulas of CTL*: Boolean connectives, ``EX``, ``EU``, ``EG`` and "some path" over conditions on markings.

Atoms and connectives are those of goals (:mod:`mcpn.spaces.search.goal`); every other operator is written
with these (:data:`OPERATORS`). Names of places, transitions and elements of the mission are looked up as a
formula is read (:mod:`mcpn.spaces.formula_names`).

Paths are maximal: infinite, or ending in a state without successors. In such a state ``EX`` of anything is
false, ``AX`` of anything true, and ``EG f`` and ``AF f`` are what ``f`` is.

What a formula on paths (:mod:`mcpn.logic.ltl.formulas`) says by single states alone is written in CTL
(:func:`some_path`): so searches and closures answer most formulas of linear temporal logic, too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.logic.ltl.formulas import Next, Release, SomePath, Until, always, is_of_paths, normal
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.search.goal import (
    DEADLOCK,
    FALSE,
    TRUE,
    And,
    AtMost,
    Deadlock,
    Fires,
    Formula,
    Not,
    Operator,
    Or,
    Stable,
    as_goal,
)

MAX_SIZE = 50_000


class EX(Operator):
    """Some next state satisfies the operand."""


class EG(Operator):
    """Some path satisfies the operand all along."""


class EU(Operator):
    """Some path satisfies the left operand until it reaches the right one."""


@record(frozen=True)
class Justice:
    """A constraint on infinite paths: they meet it again and again, or do not count.

    Temporal operators in the constraint itself speak of all paths.

    Args:
        states: A path meets the constraint in these states,
        transitions: and wherever it fires one of these.
    """

    states: Formula = FALSE
    transitions: tuple[int, ...] = ()


OPERATORS: Mapping[str, Callable[..., Formula]] = {
    "!": lambda a: ~a,
    "&": And,
    "|": Or,
    "->": lambda a, b: Or(~a, b),
    "<->": lambda a, b: Or(And(a, b), And(~a, ~b)),
    "xor": lambda a, b: ~Or(And(a, b), And(~a, ~b)),
    "EX": EX,
    "AX": lambda a: ~EX(~a),
    "EF": lambda a: EU(TRUE, a),
    "AF": lambda a: ~EG(~a),
    "EG": EG,
    "AG": lambda a: ~EU(TRUE, ~a),
    "EU": EU,
    "AU": lambda a, b: And(~EU(~b, And(~a, ~b)), ~EG(~b)),
}
"""By operator as people write it, the function that makes a formula of its operands."""

Sum: TypeAlias = tuple[int, Mapping[int, int]]
"""A constant and how often the tokens of places count, by index."""


def compare(left: Sum, relation: str, right: Sum) -> Formula:
    """A comparison of two sums of tokens, by ``<``, ``<=``, ``=``, ``!=``, ``>=`` or ``>``."""
    if relation in ("=", "!="):
        equal = And(compare(left, "<=", right), compare(right, "<=", left))
        return equal if relation == "=" else Not(equal)
    if relation in (">", ">="):
        left, right = right, left
    weights = Counter(dict(left[1]))
    weights.subtract(right[1])
    terms = tuple(sorted((place, weight) for place, weight in weights.items() if weight))
    bound = right[0] - left[0] - ("=" not in relation)
    return AtMost(terms, bound) if terms else TRUE if bound >= 0 else FALSE


def is_temporal(formula: Formula) -> bool:
    """Whether a formula speaks of paths.

    Examples:
        >>> from mcpn.spaces.search.goal import marked
        >>> is_temporal(~marked(0)), is_temporal(EX(marked(0)))
        (False, True)
    """
    return any(isinstance(inside, EX | EU | EG | SomePath) for inside in formula.walk())


def says_eventually(formula: Formula) -> bool:
    """Whether it is ``EF f``: true in a state if in a later one."""
    return isinstance(formula, EU) and formula.operands[0] == TRUE


def says_one_state(formula: Formula) -> bool:
    """Whether a formula is a condition on markings, or on what may fire in one, and no constant.

    Examples:
        >>> from mcpn.spaces.search.goal import marked
        >>> says_one_state(marked(0)), says_one_state(EX(marked(0)))
        (True, False)
    """
    atoms = (AtMost, Fires, Deadlock, Stable, Not, And, Or)
    return formula not in (TRUE, FALSE) and all(isinstance(f, atoms) for f in formula.walk())


def says_paths(formula: Formula) -> bool:
    """Whether an automaton is needed for some part of a formula."""
    return any(isinstance(inside, SomePath) for inside in formula.walk())


def some_path(formula: Formula, *, fair: bool = False) -> Formula:
    """The formula on states that some path from here satisfies a formula on paths.

    Args:
        formula: On paths; on states it is what it is.
        fair: Whether not all paths count: then some path that does must begin here.

    Returns:
        A formula of CTL as far as single states tell; where they do not, :class:`SomePath` of what is left.
    """
    return _some(normal(formula), EG(TRUE) if fair else TRUE)


def every_path(formula: Formula, *, fair: bool = False) -> Formula:
    """The formula on states that every path from here, or each that counts, satisfies one on paths."""
    return ~_some(normal(formula, wanted=False), EG(TRUE) if fair else TRUE)


def _some(formula: Formula, begins: Formula) -> Formula:
    """See :func:`some_path`, of a formula in normal form.

    Args:
        formula: The formula.
        begins: Where some path begins that counts.
    """
    if not is_of_paths(formula):
        return formula if begins == TRUE else And(formula, begins)
    some = partial(_some, begins=begins)
    match formula:
        case Or(operands):
            return Or(*map(some, operands))
        case And(operands) if len(on_paths := [f for f in operands if is_of_paths(f)]) == 1:
            return And(*(f for f in operands if f not in on_paths), some(on_paths[0]))
        case Next((operand,)):
            after = some(operand)
            return Or(And(DEADLOCK, after), EX(after))
        case Until((left, right)) if not is_of_paths(left):
            return EU(left, some(right))
        case Release((left, right)) if not is_of_paths(right):
            return Or(EU(right, And(right, some(left))), EG(right)) if left != FALSE else EG(right)
    return SomePath(formula)


def on_one_path(part: Formula, net: PetriNet) -> Formula | None:
    """A formula on paths that some path satisfies where a part holds; ``None`` where none says the same.

    Args:
        part: A formula on states, which some path from there decides if it is true.
        net: Whose markings are the states.
    """

    def of_state(formula: Formula) -> bool:
        return as_goal(formula, net) is not None

    if of_state(part):
        return part
    match part:
        case SomePath((path,)):
            return path
        case EX((operand,)):
            after = on_one_path(operand, net)
            return None if after is None else And(Not(DEADLOCK), Next(after))
        case EU((left, right)) if of_state(left):
            reached = on_one_path(right, net)
            return None if reached is None else Until(left, reached)
        case EG((operand,)) if of_state(operand):
            return always(operand)
        case Or(operands):
            said = [on_one_path(operand, net) for operand in operands]
            parts = [each for each in said if each is not None]
            return Or(*parts) if len(parts) == len(said) else None
        case And(operands) if sum(not of_state(operand) for operand in operands) == 1:
            said = [on_one_path(operand, net) for operand in operands]
            parts = [each for each in said if each is not None]
            return And(*parts) if len(parts) == len(said) else None
    return None


def within_limit(formula: Formula) -> Formula:
    """A formula, if it is not too large: ``<->`` and ``A[ U ]`` say what is in them twice.

    Raises:
        LimitError: It has more than :data:`MAX_SIZE` operators.
    """
    if any(number == MAX_SIZE for number, _ in enumerate(formula.walk())):
        raise LimitError(f"the formula says more than {MAX_SIZE} operators in full: the limit was hit")
    return formula
