"""Smaller formulas that hold in the same states, or in the same initial state.

The rules are those of CTL on maximal paths, all of which count: not for use with fairness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    FALSE,
    TRUE,
    And,
    Const,
    Deadlock,
    Fires,
    Formula,
    Not,
    Or,
    Stable,
    mapped,
    negation,
)
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import AtMost, needs


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
            known[part] = rewritten(mapped(part, simple))
        return known[part]

    def rewritten(part: Formula) -> Formula:
        match part:
            case And(operands) | Or(operands):
                return joined(type(part), operands)
            case EX(Const(value)):
                return Not(Deadlock()) if value else FALSE
            case EU(left, right):
                return _until(left, right)
            case EG(Const() | EG() | Not(EU(Const(True), _)) as inside):
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


def joined(connective: type[And] | type[Or], operands: Sequence[Formula]) -> Formula:
    """The conjunction or disjunction of simplified formulas."""
    neutral, absorbing = (TRUE, FALSE) if connective is And else (FALSE, TRUE)
    found: dict[Formula, None] = {}
    for operand in operands:
        inside = operand.operands if isinstance(operand, connective) else (operand,)
        found.update(dict.fromkeys(inside))
    found.pop(neutral, None)
    if absorbing in found or any(isinstance(f, Not) and f.operand in found for f in found):
        return absorbing
    if len(found) < 2:
        return next(iter(found), neutral)
    return connective(tuple(found))


def _until(left: Formula, right: Formula) -> Formula:
    if isinstance(right, Const) or left in (FALSE, right):
        return right
    # E[f U E[f U g]] is E[f U g], and EF E[h U g] is EF g; also as one of several alternatives.
    alternatives = right.operands if isinstance(right, Or) else (right,)
    inner = [f.right if isinstance(f, EU) and left in (TRUE, f.left) else f for f in alternatives]
    if inner != list(alternatives):
        return _until(left, joined(Or, inner))
    return EU(left, right)


def replaced(formula: Formula, value: Callable[[Formula], Formula]) -> Formula:
    """A formula with other parts outside of temporal operators: each is what ``value`` makes of it."""
    match formula:
        case Not(operand):
            return negation(replaced(operand, value))
        case And(operands) | Or(operands):
            return joined(type(formula), [replaced(operand, value) for operand in operands])
    return value(formula)


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
            case AtMost() | Fires() | Deadlock() | Stable():
                return Const(holds(part))
            case EU(left, right):
                now = at_first(right, holds)
                if now == TRUE:
                    return TRUE
                if now == FALSE and at_first(left, holds) == FALSE:
                    return FALSE
            case EG(operand) if at_first(operand, holds) == FALSE:
                return FALSE
            case EX() if holds(Deadlock()):
                return FALSE
        return part

    return replaced(formula, value)


def parts_at_first(formula: Formula) -> list[Formula]:
    """The parts that a formula's value in the initial state is a Boolean combination of."""
    match formula:
        case Not(operand):
            return parts_at_first(operand)
        case And(operands) | Or(operands):
            return [part for operand in operands for part in parts_at_first(operand)]
    return [formula]
