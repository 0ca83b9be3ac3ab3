"""Formulas on paths: ``X``, ``U`` and ``R`` over formulas on states, and what the next step is.

A formula on states is one on paths, too: a path satisfies it in its first state. Paths are maximal, and a
state without successors repeats for ever, as in the Model Checking Contest, so that ``X f`` is ``f`` there.
``F f`` is ``true U f``, ``G f`` is ``false R f``.
"""

from __future__ import annotations

from functools import partial

from mcpn.records import record
from mcpn.spaces.search.goal import FALSE, TRUE, And, Formula, Not, Operator, Or, joined


class Next(Operator):
    """The path satisfies the operand from its second state on."""


class Until(Operator):
    """The path satisfies the left operand from each state on, up to one where it satisfies the right one."""


class Release(Operator):
    """The path satisfies the right operand from each state on, up to one from where it satisfies both."""


class SomePath(Operator):
    """Some path that begins here satisfies the operand: a formula on states."""


@record(frozen=True)
class Happens(Formula):
    """The first step of the path is a firing of one of these transitions, by index."""

    transitions: tuple[int, ...]


def is_of_paths(formula: Formula) -> bool:
    """Whether a formula says more of a path than what its first state satisfies."""
    if isinstance(formula, Next | Until | Release | Happens):
        return True
    return isinstance(formula, Not | And | Or) and any(map(is_of_paths, formula.operands))


def atom_of(literal: Formula) -> Formula:
    """What a literal affirms or negates."""
    return literal.operands[0] if isinstance(literal, Not) else literal


def eventually(formula: Formula) -> Formula:
    """``F f``."""
    return Until(TRUE, formula)


def always(formula: Formula) -> Formula:
    """``G f``.

    Examples:
        >>> from mcpn.spaces.search.goal import marked
        >>> always(marked(0)) == Release(FALSE, marked(0))
        True
    """
    return Release(FALSE, formula)


def normal(formula: Formula, wanted: bool = True) -> Formula:
    """The negation normal form of a formula on paths, simplified: formulas on states and steps are its atoms.

    The rules are those of Etessami and Holzmann (*Optimizing Büchi automata*, CONCUR 2000): what is eventual
    holds from a state on if it holds from a later one on, what is universal holds from then on.

    Args:
        formula: On paths.
        wanted: Whether the formula is to hold; its negation otherwise.
    """
    if not is_of_paths(formula):
        return formula if wanted else ~formula
    inside = partial(normal, wanted=wanted)
    match formula:
        case Not((operand,)):
            return normal(operand, not wanted)
        case And(operands) | Or(operands):
            return joined((And if isinstance(formula, And) == wanted else Or)(*map(inside, operands)))
        case Next((operand,)):
            return _next(inside(operand))
        case Until((left, right)) | Release((left, right)):
            until = isinstance(formula, Until) == wanted
            return (_until if until else _release)(inside(left), inside(right))
    return formula if wanted else Not(formula)


def _next(operand: Formula) -> Formula:
    if operand in (TRUE, FALSE) or (is_eventual(operand) and is_universal(operand)):
        return operand
    return Next(operand)


def _until(left: Formula, right: Formula) -> Formula:
    if right in (TRUE, FALSE) or left in (FALSE, right) or is_eventual(right):
        return right
    if isinstance(left, Next) and isinstance(right, Next):
        return _next(_until(left.operands[0], right.operands[0]))
    if left == TRUE and isinstance(right, Next):
        return _next(_until(TRUE, right.operands[0]))
    if isinstance(right, Until) and left in (TRUE, right.operands[0]):
        return _until(left, right.operands[1])
    if left == TRUE and isinstance(right, Or):
        return joined(Or(*(_until(TRUE, operand) for operand in right.operands)))
    return Until(left, right)


def _release(left: Formula, right: Formula) -> Formula:
    if right in (TRUE, FALSE) or left in (TRUE, right) or is_universal(right):
        return right
    if isinstance(left, Next) and isinstance(right, Next):
        return _next(_release(left.operands[0], right.operands[0]))
    if left == FALSE and isinstance(right, Next):
        return _next(_release(FALSE, right.operands[0]))
    if isinstance(right, Release) and left in (FALSE, right.operands[0]):
        return _release(left, right.operands[1])
    if left == FALSE and isinstance(right, And):
        return joined(And(*(_release(FALSE, operand) for operand in right.operands)))
    return Release(left, right)


def is_eventual(formula: Formula) -> bool:
    """Whether a formula in normal form is eventual by its syntax: true of a path if of a suffix.

    Examples:
        >>> from mcpn.spaces.search.goal import marked
        >>> is_eventual(eventually(marked(0))), is_eventual(always(marked(0)))
        (True, False)
        >>> is_universal(eventually(marked(0))), is_universal(always(marked(0)))
        (False, True)
    """
    match formula:
        case And(operands) | Or(operands):
            return all(map(is_eventual, operands))
        case Next((operand,)):
            return is_eventual(operand)
        case Until((left, right)):
            return left == TRUE or (is_eventual(left) and is_eventual(right))
        case Release((left, right)):
            return is_eventual(left) and is_eventual(right)
    return False


def is_universal(formula: Formula) -> bool:
    """Whether a formula in normal form is universal by its syntax: if true of a path, of every suffix."""
    match formula:
        case And(operands) | Or(operands):
            return all(map(is_universal, operands))
        case Next((operand,)):
            return is_universal(operand)
        case Release((left, right)):
            return left == FALSE or (is_universal(left) and is_universal(right))
        case Until((left, right)):
            return is_universal(left) and is_universal(right)
    return False
