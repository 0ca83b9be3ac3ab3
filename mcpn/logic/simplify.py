"""Smaller formulas that hold in the same states, and what formulas come to where every path ends.

The rules are those of CTL on maximal paths, all of which count: not for use with fairness. Source of those on
operators in operators: F. Bønneland, J. Dyhr, P. Jensen, M. Johannsen, J. Srba, *Simplification of CTL
formulae for efficient model checking of Petri nets*, Petri Nets 2018.

A marking in which nothing may fire repeats for ever; there a path satisfies what it satisfies at all later
points, and each operator says what its last operand says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from mcpn.logic.formulas import EG, EU, EX, says_eventually, says_one_state, some_path
from mcpn.logic.ltl.formulas import Next, Release, SomePath, Until
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import changes, needs
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
    Or,
    as_goal,
    asks_dead,
    fireable,
    joined,
)


def simplified(
    formula: Formula,
    net: PetriNet,
    bounds: Sequence[float],
    always: Callable[[Formula], bool | None] = lambda _: None,
    *,
    spelled: bool = False,
) -> Formula:
    """A formula that holds in the same states.

    Args:
        formula: The formula.
        net: The net whose transitions it names.
        bounds: Most tokens of each place of the net in any reachable marking; infinity where not known.
        always: The value of a part, on markings or on paths, where it is the same in every reachable marking;
            else ``None``.
        spelled: Whether ``EX`` of a condition on markings becomes one itself, where that is not long; the net
            has no priorities.

    Returns:
        The formula without constants inside, double negations and operators that change nothing; comparisons
        that the bounds decide are constants.

    Examples:
        >>> from mcpn.logic.syntax import Names, parse
        >>> from mcpn.logic.writing import show
        >>> from mcpn.testing.nets import philosophers
        >>> net = philosophers(2)
        >>> names = Names(net)
        >>> show(simplified(parse("EF EF (deadlock & true)", names), net, [1] * len(net.places)), names)
        'EF deadlock'
    """
    known: dict[Formula, Formula] = {}

    def simple(part: Formula) -> Formula:
        if part not in known:
            inside = part.mapped(simple)
            if isinstance(inside, SomePath) and inside != part:  # a constant may say that states decide
                known[part] = simple(some_path(inside.operands[0]))
            else:
                known[part] = settled(rewritten(inside))
        return known[part]

    def settled(part: Formula) -> Formula:
        if isinstance(part, Not | And | Or):
            return part
        value = always(part)
        return part if value is None else TRUE if value else FALSE

    def rewritten(part: Formula) -> Formula:
        match part:
            case And() | Or():
                return _without_constants(joined(part), always)
            case EX((And(()),)):
                return ~settled(DEADLOCK)
            case EX((Or(()),)):
                return FALSE
            case EX((operand,)) if spelled and says_one_state(operand):
                before = after_one_step(operand, net)
                return part if before is None else simple(before)
            case EU((left, right)):
                return _until(left, right)
            case EG((And(()) | Or(()) | EG() | Not((EU((And(()), _)),)) as inside,)):
                return inside  # AG f holds on the whole way if it holds at first
            case EG((And(operands),)) if kept := [f for f in operands if _says_always(f)]:
                return rewritten(And(*kept, rewritten(EG(*_joined_but(kept, operands)))))
            case AtMost(weights, bound):
                if sum(weight * bounds[place] for place, weight in weights if weight > 0) <= bound:
                    return TRUE
                if sum(weight * bounds[place] for place, weight in weights if weight < 0) > bound:
                    return FALSE
            case Fires(transitions):
                possible = tuple(t for t in transitions if may_fire(t) and always(Fires((t,))) is not False)
                return Fires(possible) if possible else FALSE
        return part

    def may_fire(transition: int) -> bool:
        return all(weight <= bounds[place] for place, weight in needs(net, transition).items())

    return simple(formula)


MOST_SPELLED = 400
"""Comparisons in a condition that says what may hold after one firing."""


def after_one_step(condition: Formula, net: PetriNet) -> Formula | None:
    """The markings of a net without priorities from which one firing leads to where a condition holds.

    Some transition may fire, and the sums of tokens that the condition compares are right with what that
    changes. Nothing is returned where that would be long.
    """
    goal = as_goal(condition, net)
    if goal is None or asks_dead(goal):
        return None
    count = len(net.transitions)
    arcs = sum(len(t.consume) + len(t.read) for t in net.transitions)
    if arcs + count * sum(isinstance(part, AtMost) for part in goal.walk()) > MOST_SPELLED:
        return None

    def shifted(part: Formula, by: Mapping[int, int]) -> Formula:
        if isinstance(part, AtMost):
            return AtMost(part.weights, part.bound - sum(w * by.get(place, 0) for place, w in part.weights))
        return part.mapped(partial(shifted, by=by))

    return Or(*(And(fireable(net, t), shifted(goal, changes(net, t))) for t in range(count)))


def _until(left: Formula, right: Formula) -> Formula:
    if right in (TRUE, FALSE) or left in (FALSE, right):
        return right
    if says_eventually(right):
        return right  # E[f U EF g] is EF g
    if isinstance(right, Or) and left != TRUE and any(map(says_eventually, right.operands)):
        later = [f for f in right.operands if says_eventually(f)]
        now = joined(Or(*(f for f in right.operands if f not in later)))
        return joined(Or(*later, _until(left, now)))
    # E[f U E[f U g]] is E[f U g], and EF E[h U g] and EF AF g are EF g; also as one of several alternatives.
    parts = right.operands if isinstance(right, Or) else (right,)
    inner: list[Formula] = []
    for part in parts:
        match part:
            case EU((along, goal)) if left in (TRUE, along):
                inner.append(goal)
            case Not((EG((stays,)),)) if left == TRUE:
                inner.append(~stays)
            case _:
                inner.append(part)
    return EU(left, right) if tuple(inner) == parts else _until(left, joined(Or(*inner)))


def _says_always(formula: Formula) -> bool:
    """Whether it is ``AG f``: true in all later states if in one."""
    return isinstance(formula, Not) and says_eventually(formula.operands[0])


def _joined_but(kept: Sequence[Formula], operands: Sequence[Formula]) -> tuple[Formula, ...]:
    return (joined(And(*(f for f in operands if f not in kept))),)


def _without_constants(formula: Formula, always: Callable[[Formula], bool | None]) -> Formula:
    """Puts a constant for the conditions on markings that are joined, if together they are one."""
    if not isinstance(formula, And | Or):
        return formula
    of_state = [f for f in formula.operands if says_one_state(f)]
    if len(of_state) < 2:
        return formula
    value = always(type(formula)(*of_state))
    if value is None:
        return formula
    rest = (f for f in formula.operands if f not in of_state)
    return joined(type(formula)(TRUE if value else FALSE, *rest))


def takes_away(net: PetriNet) -> bool:
    """Whether each firing leaves fewer tokens, so that every path ends.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> takes_away(philosophers(2))
        False
    """
    return all(sum(changes(net, t).values()) < 0 for t in range(len(net.transitions)))


def where_all_ends(formula: Formula) -> bool | None:
    """The value of a formula, on markings or on paths, in every dead marking; ``None`` where not the same.

    Examples:
        >>> from mcpn.spaces.search.goal import DEADLOCK, TRUE, marked
        >>> where_all_ends(EG(Or(Fires((0,)), DEADLOCK))), where_all_ends(EX(TRUE)), where_all_ends(marked(0))
        (True, False, None)
    """
    match formula:
        case Deadlock():
            return True
        case Fires() | EX():
            return False
        case Not((operand,)):
            value = where_all_ends(operand)
            return None if value is None else not value
        case And(operands) | Or(operands):
            values = set(map(where_all_ends, operands))
            decides = isinstance(formula, Or)
            return decides if decides in values else None if None in values else not decides
        case (
            EG((last,))
            | SomePath((last,))
            | Next((last,))
            | EU((_, last))
            | Until((_, last))
            | Release((_, last))
        ):
            return where_all_ends(last)
    return None


def where_paths_end(part: Formula) -> bool | None:
    """The value of a part of a formula where every path ends; ``None`` where it may differ by marking.

    Args:
        part: What ``EG``, ``EF`` say of paths, or ``G`` and ``F`` of one.
    """
    match part:
        case EG((last,)) | Release((Or(()), last)) if where_all_ends(last) is False:
            return False
        case EU((And(()), last)) | Until((And(()), last)) if where_all_ends(last):
            return True
    return None
