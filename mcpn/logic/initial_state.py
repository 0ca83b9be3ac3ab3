"""Formulas in the initial state: what is left to ask there, part by part."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from mcpn.logic.formulas import EG, EU, EX
from mcpn.spaces.search.goal import (
    DEADLOCK,
    FALSE,
    TRUE,
    And,
    Formula,
    Not,
    Or,
    joined,
)


def at_first(formula: Formula, known: Callable[[Formula], bool | None]) -> Formula:
    """A formula with the same value in the initial state, as far as what is known of that state decides.

    Args:
        formula: A simplified one.
        known: Whether the initial state satisfies an atom or a temporal formula; ``None`` where not known.

    Returns:
        A constant where the initial state decides; else what is left to ask there.
    """
    left = partial(at_first, known=known)
    if isinstance(formula, Not):
        return ~left(formula.operands[0])
    if isinstance(formula, And | Or):
        return joined(type(formula)(*map(left, formula.operands)))
    value = known(formula)
    match formula:
        case _ if value is not None:
            return TRUE if value else FALSE
        case EU((along, goal)):
            now = left(goal)
            return now if now == TRUE or (now == FALSE and left(along) == FALSE) else formula
        case EG((operand,)) if left(operand) == FALSE:
            return FALSE
        case EX() if known(DEADLOCK):
            return FALSE
    return formula


def parts_at_first(formula: Formula) -> list[Formula]:
    """The parts that a formula's value in the initial state is a Boolean combination of."""
    if isinstance(formula, Not | And | Or):
        return [part for operand in formula.operands for part in parts_at_first(operand)]
    return [formula]
