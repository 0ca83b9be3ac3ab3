"""Smaller formulas that hold in the same states, or in the same initial state.

The rules are those of CTL on maximal paths, all of which count: not for use with fairness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mcpn.check.logic.formulas import EG, EU, EX
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import (
    DEADLOCK,
    FALSE,
    TRUE,
    And,
    AtMost,
    Fires,
    Formula,
    Not,
    Or,
    needs,
)


def simplified(formula: Formula, net: PetriNet, bounds: Sequence[float]) -> Formula:
    """A formula that holds in the same states.

    Args:
        formula: The formula.
        net: The net whose transitions it names.
        bounds: Most tokens of each place of the net in any reachable marking; infinity where not known.

    Returns:
        The formula without constants inside, double negations and operators that change nothing; comparisons
        that the bounds decide are constants.
    """
    known: dict[Formula, Formula] = {}

    def simple(part: Formula) -> Formula:
        if part not in known:
            known[part] = rewritten(part.mapped(simple))
        return known[part]

    def rewritten(part: Formula) -> Formula:
        match part:
            case And() | Or():
                return joined(part)
            case EX((And(()),)):
                return Not(DEADLOCK)
            case EX((Or(()),)):
                return FALSE
            case EU((left, right)):
                return _until(left, right)
            case EG((And(()) | Or(()) | EG() | Not((EU((And(()), _)),)) as inside,)):
                return inside  # AG f holds on the whole way if it holds at first
            case AtMost(weights, bound):
                if sum(weight * bounds[place] for place, weight in weights if weight > 0) <= bound:
                    return TRUE
                if sum(weight * bounds[place] for place, weight in weights if weight < 0) > bound:
                    return FALSE
            case Fires(transitions):
                possible = tuple(t for t in transitions if may_fire(t))
                return Fires(possible) if possible else FALSE
        return part

    def may_fire(transition: int) -> bool:
        return all(weight <= bounds[place] for place, weight in needs(net, transition).items())

    return simple(formula)


def joined(formula: And | Or) -> Formula:
    """A conjunction or disjunction of simplified formulas, simplified."""
    kind, absorbing = (And, FALSE) if isinstance(formula, And) else (Or, TRUE)
    found: dict[Formula, None] = {}
    for operand in formula.operands:
        found.update(dict.fromkeys(operand.operands if isinstance(operand, kind) else (operand,)))
    if absorbing in found or any(isinstance(f, Not) and f.operands[0] in found for f in found):
        return absorbing
    return next(iter(found)) if len(found) == 1 else kind(*found)


def _until(left: Formula, right: Formula) -> Formula:
    if right in (TRUE, FALSE) or left in (FALSE, right):
        return right
    # E[f U E[f U g]] is E[f U g], and EF E[h U g] is EF g; also as one of several alternatives.
    parts = right.operands if isinstance(right, Or) else (right,)
    inner = [f.operands[1] if isinstance(f, EU) and left in (TRUE, f.operands[0]) else f for f in parts]
    return EU(left, right) if tuple(inner) == parts else _until(left, joined(Or(*inner)))


def replaced(formula: Formula, value: Callable[[Formula], Formula]) -> Formula:
    """A formula with other parts outside of temporal operators: each is what ``value`` makes of it."""
    if not isinstance(formula, Not | And | Or):
        return value(formula)
    found = formula.mapped(lambda operand: replaced(operand, value))
    return joined(found) if isinstance(formula, And | Or) and isinstance(found, And | Or) else found


def at_first(formula: Formula, holds: Callable[[Formula], bool]) -> Formula:
    """A formula with the same value in the initial state, as far as that state alone decides.

    Args:
        formula: A simplified one.
        holds: Whether the initial state satisfies a formula without temporal operators and connectives.

    Returns:
        A constant where the initial state decides; else what is left to ask there.
    """

    def value(part: Formula) -> Formula:
        match part:
            case EU((left, right)):
                now = at_first(right, holds)
                if now == TRUE or (now == FALSE and at_first(left, holds) == FALSE):
                    return now
                return part
            case EG((operand,)):
                return FALSE if at_first(operand, holds) == FALSE else part
            case EX():
                return FALSE if holds(DEADLOCK) else part
        return TRUE if holds(part) else FALSE

    return replaced(formula, value)


def parts_at_first(formula: Formula) -> list[Formula]:
    """The parts that a formula's value in the initial state is a Boolean combination of."""
    if isinstance(formula, Not | And | Or):
        return [part for operand in formula.operands for part in parts_at_first(operand)]
    return [formula]
