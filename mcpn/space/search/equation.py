"""The state equation: markings that firings could reach if their order did not matter.

Each reachable marking is the initial one and what some numbers of firings change. Where no such marking
satisfies a goal, none is reachable. What the equation lets pass is made narrower by traps: one that is marked
at first stays marked. J. Esparza, S. Melzer, *Verification of safety properties using integer programming:
beyond the state equation*, Formal Methods in System Design 16, 2000.

Conditions become rows of a mixed integer program, which HiGHS solves. Each row of the goal is made a little
wider (:data:`MARGIN`), so that rounding in the solver does not refute what an exact solution satisfies. An
alternative that no finite bound is known for is left out, which only lets more pass.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, inf
from typing import Literal, TypeAlias

from mcpn.net.petri import PetriNet
from mcpn.net.programs import minimise
from mcpn.net.structure import incidence, place_bounds
from mcpn.space.search.goal import DEADLOCK, And, AtMost, Goal, Or, as_goal, fireable

MARGIN = 1e-3
LARGEST = 10_000
"""Weights and tokens beyond this are not given to the solver."""
MOST_ENTRIES = 200_000
NODES = 100
TRAPS = 30

Kind: TypeAlias = Literal["unreachable", "possible", "unknown"]


@dataclass(frozen=True)
class Solution:
    """What the state equation says of a goal.

    Args:
        kind: No marking of the goal is reachable, some numbers of firings may lead to one, or the solver
            has not decided.
        counts: Numbers of firings, by transition.
        traps: How many traps were needed.
    """

    kind: Kind
    counts: tuple[int, ...] = ()
    traps: int = 0


class StateEquation:
    """The state equation of a net.

    Args:
        net: The net.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net

    @cached_property
    def bounds(self) -> list[float]:
        """Most tokens of each place, as far as invariants say."""
        return place_bounds(self.net)

    def solve(self, goal: Goal) -> Solution:
        """Whether the equation, with traps, rules a goal out.

        Args:
            goal: Any goal.

        Returns:
            The answer; ``unknown`` also where the net or the goal is too large for the solver.
        """
        arcs = [w for t in self.net.transitions for side in (t.consume, t.produce, t.read) for _, w in side]
        if max((*arcs, *self.net.initial), default=0) > LARGEST or len(arcs) > MOST_ENTRIES:
            return Solution("unknown")
        program = _Program(self.net, self.bounds)
        if not program.require(goal):
            return Solution("unknown")
        traps, values = 0, list[float]()
        for whole in (False, True):
            while True:
                kind, values = program.solve(whole=whole)
                if kind != "possible":
                    return Solution(kind, traps=traps)
                empty = {
                    p
                    for p, tokens in enumerate(values[program.first_place :][: len(self.bounds)])
                    if tokens < 0.5 * MARGIN
                }
                trap = self._trap(empty) if traps < TRAPS else frozenset()
                if not trap:
                    break
                program.at_least(dict.fromkeys(trap, 1.0), 1.0)
                traps += 1
        counts = tuple(ceil(value - MARGIN) for value in values[: len(self.net.transitions)])
        return Solution("possible", counts, traps)

    def _trap(self, within: Iterable[int]) -> frozenset[int]:
        """An initially marked trap within some places, shrunk greedily; empty where there is none."""
        trap = self._largest_trap(within)
        if not any(self.net.initial[p] for p in trap):
            return frozenset()
        for place in sorted(trap):
            if place in trap:
                smaller = self._largest_trap(trap - {place})
                if any(self.net.initial[p] for p in smaller):
                    trap = smaller
        return trap

    def _largest_trap(self, within: Iterable[int]) -> frozenset[int]:
        """The largest set of some places such that what takes from it also puts in it."""
        trap = set(within)
        queue = list(trap)
        while queue:
            place = queue.pop()
            if place not in trap:
                continue
            if any(trap.isdisjoint(self._puts[t]) for t in self._takers[place]):
                trap.discard(place)
                queue += (p for t in self._feeders[place] for p in self._needs[t] if p in trap)
        return frozenset(trap)

    @cached_property
    def _needs(self) -> list[frozenset[int]]:
        return [frozenset(p for p, _ in t.consume) for t in self.net.transitions]

    @cached_property
    def _puts(self) -> list[frozenset[int]]:
        """Places that hold a token after a firing."""
        sets = []
        for t in self.net.transitions:
            taken = dict(t.consume)
            stays = (p for p, weight in t.read if weight > taken.get(p, 0))
            sets.append(frozenset(p for p, _ in t.produce).union(stays))
        return sets

    @cached_property
    def _takers(self) -> list[list[int]]:
        return _by_place(self._needs, len(self.net.places))

    @cached_property
    def _feeders(self) -> list[list[int]]:
        return _by_place(self._puts, len(self.net.places))


def _by_place(sides: list[frozenset[int]], places: int) -> list[list[int]]:
    lists: list[list[int]] = [[] for _ in range(places)]
    for t, side in enumerate(sides):
        for place in side:
            lists[place].append(t)
    return lists


class _Program:
    """Rows of a mixed integer program: numbers of firings, tokens, and choices between alternatives."""

    def __init__(self, net: PetriNet, bounds: list[float]) -> None:
        self.net = net
        self.bounds = bounds
        self.first_place = len(net.transitions)
        self.first_choice = self.first_place + len(net.places)
        self.choices = 0
        self.rows: list[tuple[dict[int, float], float]] = []  # weights by variable, and the least sum
        self.equations: list[tuple[dict[int, float], float]] = []
        for place, row in enumerate(incidence(net)):
            weights = {t: float(change) for t, change in row.items()}
            weights[self.first_place + place] = -1.0
            self.equations.append((weights, float(-net.initial[place])))

    def at_least(self, weights: dict[int, float], least: float, choice: int | None = None) -> None:
        """A weighted sum of places is at least so much, where an alternative is chosen if one is given."""
        row = {self.first_place + place: weight for place, weight in weights.items()}
        if choice is not None:
            lowest = sum(w * self.bounds[p] if w < 0 else 0.0 for p, w in weights.items())
            if lowest == -inf or lowest >= least:
                return
            row[choice] = lowest - least
            least = lowest
        self.rows.append((row, least))

    def require(self, goal: Goal, choice: int | None = None) -> bool:
        """Adds a goal; whether its numbers are within what the solver is given."""
        match goal:
            case AtMost(weights, bound):
                if max([abs(bound), *(abs(weight) for _, weight in weights)]) > LARGEST:
                    return False
                self.at_least({p: -float(w) for p, w in weights}, -bound - MARGIN, choice)
                return True
            case And(goals):
                return all(self.require(inside, choice) for inside in goals)
            case Or((only,)):
                return self.require(only, choice)
            case Or(goals):
                return self._clause(goals, choice) or self._choose(goals, choice)
            case _:  # a deadlock, or that something may fire
                fires = Or(*(fireable(self.net, t) for t in range(len(self.net.transitions))))
                spelled = as_goal(fires, self.net, goal != DEADLOCK)
                assert spelled is not None, "it speaks of tokens alone"
                return self.require(spelled, choice)

    def _clause(self, goals: tuple[Goal, ...], choice: int | None) -> bool:
        """One row for alternatives that each ask whether a place of at most one token is marked."""
        weights: dict[int, float] = {}
        least = 1.0
        for goal in goals:
            match goal:
                case AtMost(((place, 1),), 0) if self.bounds[place] <= 1 and place not in weights:
                    weights[place] = -1.0
                    least -= 1.0
                case AtMost(((place, -1),), -1) if self.bounds[place] <= 1 and place not in weights:
                    weights[place] = 1.0
                case _:
                    return False
        self.at_least(weights, least - MARGIN, choice)
        return True

    def _choose(self, goals: tuple[Goal, ...], choice: int | None) -> bool:
        chosen = []
        for goal in goals:
            number = self.first_choice + self.choices
            self.choices += 1
            chosen.append(number)
            if not self.require(goal, number):
                return False
        row = dict.fromkeys(chosen, 1.0)
        if choice is not None:
            row[choice] = -1.0
        self.rows.append((row, 1.0 if choice is None else 0.0))
        return True

    def solve(self, *, whole: bool) -> tuple[Kind, list[float]]:
        """Looks for a solution; of whole numbers of tokens and choices, where so asked."""
        variables = self.first_choice + self.choices
        solution = minimise(
            [1.0] * self.first_place + [0.0] * (variables - self.first_place),
            [
                *((row, value, value) for row, value in self.equations),
                *((row, least, inf) for row, least in self.rows),
            ],
            [0.0] * variables,
            [inf] * self.first_place + self.bounds + [1.0] * self.choices,
            whole=range(self.first_place, variables) if whole else (),
            nodes=NODES,
        )
        kinds: dict[str, Kind] = {"solved": "possible", "infeasible": "unreachable", "unknown": "unknown"}
        return kinds[solution.kind], list(solution.values)
