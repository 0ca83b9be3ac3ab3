"""Smaller formulas that hold in the same states, or in the same initial state.

The rules are those of CTL on maximal paths, all of which count: not for use with fairness.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from mcpn.logic.formulas import EG, EU, EX
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import needs
from mcpn.spaces.search.goal import DEADLOCK, FALSE, TRUE, And, AtMost, Fires, Formula, Not, Or, joined


def simplified(
    formula: Formula,
    net: PetriNet,
    bounds: Sequence[float],
    always: Callable[[Formula], bool | None] = lambda _: None,
) -> Formula:
    """A formula that holds in the same states.

    Args:
        formula: The formula.
        net: The net whose transitions it names.
        bounds: Most tokens of each place of the net in any reachable marking; infinity where not known.
        always: The value of an atom where it is the same in every reachable marking; else ``None``.

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
                part = Fires(possible) if possible else FALSE
        value = always(part) if isinstance(part, AtMost | Fires) else None
        return part if value is None else TRUE if value else FALSE

    def may_fire(transition: int) -> bool:
        return all(weight <= bounds[place] for place, weight in needs(net, transition).items())

    return simple(formula)


def _until(left: Formula, right: Formula) -> Formula:
    if right in (TRUE, FALSE) or left in (FALSE, right):
        return right
    # E[f U E[f U g]] is E[f U g], and EF E[h U g] is EF g; also as one of several alternatives.
    parts = right.operands if isinstance(right, Or) else (right,)
    inner = [f.operands[1] if isinstance(f, EU) and left in (TRUE, f.operands[0]) else f for f in parts]
    return EU(left, right) if tuple(inner) == parts else _until(left, joined(Or(*inner)))


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
