"""Formulas that ask for one reachable marking, as goals of a search.

``EF f`` where ``f`` has no temporal operator needs no more than a marking of ``f`` that is reachable or not;
``AG f`` is ``!EF !f``.
"""

from __future__ import annotations

from mcpn.check.logic.formulas import EU, And, Const, Deadlock, Fires, Formula, Not, Or, Stable
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import AllOf, AnyOf, AtMost, Dead, Goal, fireable, negation


def as_reachability(formula: Formula, net: PetriNet) -> Goal | None:
    """The goal of a formula ``EF f``.

    Args:
        formula: The formula.
        net: A net without priorities.

    Returns:
        The markings of ``f``, of which one is to be reachable; ``None`` for any other formula.
    """
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
            goal = as_goal(operand, net)
            return None if goal is None else negation(goal)
        case And(operands) | Or(operands):
            goals = [as_goal(operand, net) for operand in operands]
            known = tuple(goal for goal in goals if goal is not None)
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
