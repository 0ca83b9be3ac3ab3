"""Conditions on markings that formulas imply, that imply them, and those that stand inside them."""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.logic.formulas import EG, EU, EX, says_one_state
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


def conditions(formula: Formula) -> Iterator[Formula]:
    """The parts that say one state, those inside them as well; several joined with others also together."""
    for part in formula.walk():
        if says_one_state(part):
            yield part
        elif isinstance(part, And | Or):
            of_state = list(filter(says_one_state, part.operands))
            if len(of_state) > 1:
                yield type(part)(*of_state)


def weaker(formula: Formula, wanted: bool = True) -> Formula:
    """A condition on markings that holds wherever a formula does, or its negation as wanted.

    ``E[f U g]`` needs ``f`` or ``g`` now, ``EG f`` needs ``f``; where ``E[f U g]`` is false, so is ``g``.
    """
    match formula:
        case Not((operand,)):
            return weaker(operand, not wanted)
        case And(operands) | Or(operands):
            kind = And if isinstance(formula, And) == wanted else Or
            return joined(kind(*(weaker(operand, wanted) for operand in operands)))
        case EX():
            return Not(DEADLOCK) if wanted else TRUE
        case EU((along, goal)):
            if not wanted:
                return weaker(goal, wanted=False)
            return joined(Or(weaker(along), now)) if (now := weaker(goal)) != FALSE else FALSE
        case EG((operand,)):
            return weaker(operand) if wanted else TRUE
        case _ if says_one_state(formula) or formula in (TRUE, FALSE):
            return formula if wanted else ~formula
    return TRUE


def bounds_of(part: Formula) -> tuple[Formula, Formula]:
    """A weaker and a stronger part of one operator, whose operands are conditions on markings."""
    return part.mapped(weaker), part.mapped(lambda inside: ~weaker(inside, wanted=False))
