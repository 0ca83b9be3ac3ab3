"""Formulas that ask for one reachable marking, as goals of a search.

``EF f`` and ``AG f`` where ``f`` has no temporal operator need no more than a marking of ``f``, or of ``!f``,
that is reachable or not.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcpn.check.logic.formulas import EU, And, Const, Core, Deadlock, Fires, Not, Or, Stable, TokenBound
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import AllOf, AnyOf, AtMost, Dead, Goal, fireable, negation


@dataclass(frozen=True)
class ReachabilityQuestion:
    """A question that a search can answer.

    Args:
        goal: The markings looked for.
        if_reachable: What the formula is where one of them is reachable.
    """

    goal: Goal
    if_reachable: bool


def as_reachability(formula: Core, net: PetriNet) -> ReachabilityQuestion | None:
    """The question for a reachable marking that a formula asks in its initial state.

    Args:
        formula: Of the core.
        net: A net without priorities.

    Returns:
        The question; ``None`` where the formula asks for more.
    """
    value = True
    while isinstance(formula, Not):
        formula, value = formula.operand, not value
    match formula:
        case EU(Const(True), inside):
            goal = as_goal(inside, net)
            return None if goal is None else ReachabilityQuestion(goal, value)
    return None


def as_goal(formula: Core, net: PetriNet) -> Goal | None:
    """The markings of a net without priorities that satisfy a formula; ``None`` if it speaks of paths."""
    match formula:
        case Const(value):
            return AllOf(()) if value else AnyOf(())
        case Not(operand):
            goal = as_goal(operand, net)
            return None if goal is None else negation(goal)
        case And(operands) | Or(operands):
            goals = [as_goal(operand, net) for operand in operands]
            known = tuple(goal for goal in goals if goal is not None)
            if len(known) < len(goals):
                return None
            return AllOf(known) if isinstance(formula, And) else AnyOf(known)
        case TokenBound(weights, bound):
            return AtMost(weights, bound)
        case Fires(transitions):
            return AnyOf(tuple(fireable(net, t) for t in transitions))
        case Deadlock():
            return Dead()
        case Stable():
            return AllOf(())
    return None
