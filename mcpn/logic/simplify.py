"""Smaller formulas that hold in the same states, or in the same initial state, and bounds of formulas.

The rules are those of CTL on maximal paths, all of which count: not for use with fairness. Source of those on
operators in operators: F. Bønneland, J. Dyhr, P. Jensen, M. Johannsen, J. Srba, *Simplification of CTL
formulae for efficient model checking of Petri nets*, Petri Nets 2018.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial

from mcpn.logic.formulas import EG, EU, EX, some_path
from mcpn.logic.ltl.formulas import SomePath
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
    Stable,
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


def says_eventually(formula: Formula) -> bool:
    """Whether it is ``EF f``: true in a state if in a later one."""
    return isinstance(formula, EU) and formula.operands[0] == TRUE


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


def says_one_state(formula: Formula) -> bool:
    """Whether a formula is a condition on markings, or on what may fire in one, and no constant.

    Examples:
        >>> from mcpn.logic.formulas import EX
        >>> from mcpn.spaces.search.goal import marked
        >>> says_one_state(marked(0)), says_one_state(EX(marked(0)))
        (True, False)
    """
    atoms = (AtMost, Fires, Deadlock, Stable, Not, And, Or)
    return formula not in (TRUE, FALSE) and all(isinstance(f, atoms) for f in formula.walk())


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
