"""What a search looks for: a condition on markings, in negation normal form.

>>> from mcpn.net.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("switch", consume=["off"], produce=["on"])
>>> net = builder.build()
>>> on = AtMost(((1, -1),), -1)  # at least one token in the place of index 1
>>> holds(on, net, (0, 1)), holds(negation(on), net, (0, 1))
(True, False)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

from mcpn._kernel import Goals
from mcpn.net.petri import PetriNet


@dataclass(frozen=True, slots=True)
class AtMost:
    """A weighted sum of tokens is at most a bound; places by index, each once."""

    weights: tuple[tuple[int, int], ...]
    bound: int


@dataclass(frozen=True, slots=True)
class AllOf:
    """Conjunction; true without operands."""

    goals: tuple[Goal, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    """Disjunction; false without operands."""

    goals: tuple[Goal, ...]


@dataclass(frozen=True, slots=True)
class Dead:
    """No transition may fire, or (``holds`` false) some may."""

    holds: bool = True


Goal: TypeAlias = AtMost | AllOf | AnyOf | Dead
DEADLOCK = Dead()


def marked(place: int, tokens: int = 1) -> AtMost:
    """A place holds at least so many tokens."""
    return AtMost(((place, -1),), -tokens)


def fireable(net: PetriNet, transition: int) -> Goal:
    """The marking has the tokens that a transition needs; without priorities, it may fire."""
    return AllOf(tuple(marked(place, weight) for place, weight in needs(net, transition).items()))


def needs(net: PetriNet, transition: int) -> dict[int, int]:
    """Tokens that a transition needs, by place."""
    arcs = net.transitions[transition]
    found = dict(arcs.consume)
    for place, weight in arcs.read:
        found[place] = max(found.get(place, 0), weight)
    return found


def changes(net: PetriNet, transition: int) -> dict[int, int]:
    """Tokens that a firing of a transition adds, or takes, by place that it changes."""
    arcs = net.transitions[transition]
    found = dict(arcs.produce)
    for place, weight in arcs.consume:
        found[place] = found.get(place, 0) - weight
    return {place: by for place, by in found.items() if by}


def negation(goal: Goal) -> Goal:
    """The markings that a goal leaves out."""
    match goal:
        case AtMost(weights, bound):
            return AtMost(tuple((place, -weight) for place, weight in weights), -bound - 1)
        case AllOf(goals):
            return AnyOf(tuple(map(negation, goals)))
        case AnyOf(goals):
            return AllOf(tuple(map(negation, goals)))
        case Dead(wanted):
            return Dead(not wanted)


def parts(goal: Goal) -> Iterator[AtMost | Dead]:
    """The conditions that a goal is made of."""
    stack = [goal]
    while stack:
        at = stack.pop()
        if isinstance(at, AllOf | AnyOf):
            stack.extend(at.goals)
        else:
            yield at


def asks_dead(goal: Goal) -> bool:
    """Whether a goal speaks of what may fire."""
    return any(isinstance(part, Dead) for part in parts(goal))


def wanted(goal: Goal) -> dict[int, set[int]]:
    """The places that a goal speaks of: whether it may help to raise (1) or to lower (-1) each."""
    found: dict[int, set[int]] = {}
    for part in parts(goal):
        if isinstance(part, AtMost):
            for place, weight in part.weights:
                found.setdefault(place, set()).add(-1 if weight > 0 else 1)
    return found


def holds(goal: Goal, net: PetriNet, marking: Sequence[int]) -> bool:
    """Whether a marking satisfies a goal."""
    match goal:
        case AtMost(weights, bound):
            return sum(weight * marking[place] for place, weight in weights) <= bound
        case AllOf(goals):
            return all(holds(inside, net, marking) for inside in goals)
        case AnyOf(goals):
            return any(holds(inside, net, marking) for inside in goals)
        case Dead(wanted):
            return wanted != any(net.covers(marking, t) for t in range(len(net.transitions)))


def renamed(goal: Goal, index: Callable[[int], int]) -> Goal:
    """The same on a net whose places have other indices."""
    match goal:
        case AtMost(weights, bound):
            return AtMost(tuple((index(place), weight) for place, weight in weights), bound)
        case AllOf(goals):
            return AllOf(tuple(map(partial(renamed, index=index), goals)))
        case AnyOf(goals):
            return AnyOf(tuple(map(partial(renamed, index=index), goals)))
    return goal


def encode(goals: Sequence[Goal], places: int) -> tuple[Goals, list[int]]:
    """Goals as the kernel takes them, and the number of each."""
    nodes: list[tuple[str, list[int], list[tuple[int, int]], int]] = []
    known: dict[Goal, int] = {}

    def add(goal: Goal) -> int:
        if goal not in known:
            match goal:
                case AtMost(weights, bound):
                    node: tuple[str, list[int], list[tuple[int, int]], int] = (
                        "at_most",
                        [],
                        list(weights),
                        bound,
                    )
                case AllOf(inside):
                    node = ("all", list(map(add, inside)), [], 0)
                case AnyOf(inside):
                    node = ("any", list(map(add, inside)), [], 0)
                case Dead(wanted):
                    node = ("dead" if wanted else "not_dead", [], [], 0)
            nodes.append(node)
            known[goal] = len(nodes) - 1
        return known[goal]

    roots = [add(goal) for goal in goals]
    return Goals(places, nodes), roots
