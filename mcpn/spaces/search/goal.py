"""Conditions on markings: the atoms and connectives of formulas, and the goals of searches.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("switch", consume=["off"], produce=["on"])
>>> net = builder.build()
>>> on = marked(1)
>>> holds(on, net, (0, 1)), holds(Not(on), net, (0, 1))
(True, False)
>>> as_goal(Not(on), net)  # no more than 0 tokens
AtMost(weights=((1, 1),), bound=0)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeAlias

from mcpn._kernel import Goals
from mcpn.errors import LimitError
from mcpn.nets.petri import EVENTS, PetriNet
from mcpn.nets.structure import needs
from mcpn.records import record

FARTHEST = 2**62
"""Sums of tokens in searches are nearer than this bound."""
MOST_WEIGHTS = 2**29
"""Searches take weights of a sum up to this total, signs aside."""


class Formula:
    """What holds in some states: an atom, or an operator with the formulas that it is applied to."""

    operands: tuple[Formula, ...] = ()

    def __invert__(self) -> Formula:
        """The negation, without doubling one."""
        match self:
            case Not((operand,)):
                return operand
            case And(()) | Or(()):
                return FALSE if self == TRUE else TRUE
        return Not(self)

    def walk(self) -> Iterator[Formula]:
        """Every formula inside, itself included."""
        stack: list[Formula] = [self]
        while stack:
            at = stack.pop()
            yield at
            stack.extend(at.operands)

    def mapped(self, function: Callable[[Formula], Formula]) -> Formula:
        """A formula with this operator, with the function applied to each operand."""
        operands = map(function, self.operands)
        return ~next(operands) if isinstance(self, Not) else type(self)(*operands) if self.operands else self


@record(frozen=True)
class AtMost(Formula):
    """A weighted sum of tokens is at most a bound; places by index, each once."""

    weights: tuple[tuple[int, int], ...]
    bound: int


@record(frozen=True)
class Fires(Formula):
    """Some of these transitions, by index, may fire now, priorities respected."""

    transitions: tuple[int, ...]


@record(frozen=True)
class Deadlock(Formula):
    """Nothing may fire."""


@record(frozen=True)
class Stable(Formula):
    """No internal transition may fire; true everywhere in nets without priorities."""


@record(frozen=True)
class Operator(Formula):
    """An operator and its operands; its hash is computed once, since formulas are keys again and again."""

    operands: tuple[Formula, ...]

    def __init__(self, *operands: Formula) -> None:
        object.__setattr__(self, "operands", operands)
        object.__setattr__(self, "_hash", hash((operands,)))

    def __hash__(self) -> int:
        hashed: int = self.__dict__["_hash"]
        return hashed

    def __reduce__(self) -> tuple[type[Operator], tuple[Formula, ...]]:
        return type(self), self.operands  # hashes of another process may differ


class Not(Operator):
    """Negation."""


class And(Operator):
    """Conjunction; true without operands."""


class Or(Operator):
    """Disjunction; false without operands."""


TRUE: Formula = And()
FALSE: Formula = Or()
DEADLOCK = Deadlock()


def joined(formula: And | Or) -> Formula:
    """A conjunction or disjunction of simplified formulas, simplified."""
    kind, absorbing = (And, FALSE) if isinstance(formula, And) else (Or, TRUE)
    members: dict[Formula, None] = {}
    for operand in formula.operands:
        members.update(dict.fromkeys(operand.operands if isinstance(operand, kind) else (operand,)))
    if absorbing in members or any(isinstance(f, Not) and f.operands[0] in members for f in members):
        return absorbing
    return next(iter(members)) if len(members) == 1 else kind(*members)


Goal: TypeAlias = Formula
"""``AtMost``, ``Deadlock`` and its negation, joined by ``And`` and ``Or``: what the kernel looks for."""


def marked(*places: int, tokens: int = 1) -> Formula:
    """Some places, by index, hold together at least so many tokens; false of none."""
    return AtMost(tuple((place, -1) for place in sorted(places)), -tokens) if places else FALSE


def fireable(net: PetriNet, transition: int) -> Goal:
    """The marking has the tokens that a transition needs; without priorities, it may fire."""
    return And(*(marked(place, tokens=weight) for place, weight in needs(net, transition).items()))


def as_goal(formula: Formula, net: PetriNet, wanted: bool = True) -> Goal | None:
    """The markings that satisfy a formula, or do not, as wanted.

    Returns:
        A goal; ``None`` where the formula speaks of paths.
    """
    match formula:
        case Not((operand,)):
            return as_goal(operand, net, not wanted)
        case And(operands) | Or(operands):
            parts = [as_goal(operand, net, wanted) for operand in operands]
            goals = [goal for goal in parts if goal is not None]
            kind = And if isinstance(formula, And) == wanted else Or
            return kind(*goals) if len(goals) == len(parts) else None
        case AtMost(weights, bound) if not wanted:
            return AtMost(tuple((place, -weight) for place, weight in weights), -bound - 1)
        case AtMost() | Deadlock():
            return formula if wanted else Not(formula)
        case Fires(transitions) if net.priorities:
            ranks = sorted({net.ranks[t] for t in transitions})
            ways = {rank: [fireable(net, t) for t in transitions if net.ranks[t] == rank] for rank in ranks}
            return as_goal(
                Or(*(And(Or(*ways[rank]), none_more_urgent(net, rank)) for rank in ranks)), net, wanted
            )
        case Fires(transitions):
            return as_goal(Or(*(fireable(net, t) for t in transitions)), net, wanted)
        case Stable():
            return as_goal(none_more_urgent(net, EVENTS), net, wanted)
    return None


def none_more_urgent(net: PetriNet, rank: int) -> Formula:
    """No transition of a lower rank has the tokens that it needs; true everywhere without priorities."""
    lower = [t for t, own in enumerate(net.ranks) if net.priorities and own < rank]
    return And(*(Not(fireable(net, t)) for t in lower))


def asks_dead(goal: Goal) -> bool:
    """Whether a goal speaks of what may fire."""
    return DEADLOCK in goal.walk()


def wanted(goal: Goal) -> dict[int, set[int]]:
    """The places that a goal speaks of: whether it may help to raise (1) or to lower (-1) each."""
    values: dict[int, set[int]] = {}
    for part in goal.walk():
        if isinstance(part, AtMost):
            for place, weight in part.weights:
                values.setdefault(place, set()).add(-1 if weight > 0 else 1)
    return values


def holds(goal: Goal, net: PetriNet, marking: Sequence[int]) -> bool:
    """Whether a marking satisfies a goal."""
    match goal:
        case AtMost(weights, bound):
            return sum(weight * marking[place] for place, weight in weights) <= bound
        case And(operands):
            return all(holds(inside, net, marking) for inside in operands)
        case Or(operands):
            return any(holds(inside, net, marking) for inside in operands)
        case Not((operand,)):
            return not holds(operand, net, marking)
    assert goal == DEADLOCK, "goals speak of markings"
    return not any(net.covers(marking, t) for t in range(len(net.transitions)))


def renamed(goal: Goal, index: Callable[[int], int]) -> Goal:
    """The goal, rewritten for a net in which places have other indices."""
    if isinstance(goal, AtMost):
        return AtMost(tuple((index(place), weight) for place, weight in goal.weights), goal.bound)
    return goal.mapped(partial(renamed, index=index))


def encode(goals: Sequence[Goal], places: int) -> tuple[Goals, list[int]]:
    """Goals as the kernel takes them, and the number of each.

    Raises:
        LimitError: The weights of a sum are beyond what searches follow.
    """
    nodes: list[tuple[str, list[int], list[tuple[int, int]], int]] = []
    known: dict[Goal, int] = {}

    def add(goal: Goal) -> int:
        if goal not in known:
            match goal:
                case AtMost(weights, bound):
                    if (total := sum(abs(weight) for _, weight in weights)) > MOST_WEIGHTS:
                        raise LimitError(
                            f"weights of a sum of tokens that total {total}: more than {MOST_WEIGHTS}, "
                            "the limit of searches"
                        )
                    nodes.append(("at_most", [], list(weights), max(-FARTHEST, min(bound, FARTHEST))))
                case And(operands) | Or(operands):
                    inside = list(map(add, operands))
                    nodes.append(("all" if isinstance(goal, And) else "any", inside, [], 0))
                case _:
                    nodes.append(("dead" if goal == DEADLOCK else "not_dead", [], [], 0))
            known[goal] = len(nodes) - 1
        return known[goal]

    roots = [add(goal) for goal in goals]
    return Goals(places, nodes), roots
