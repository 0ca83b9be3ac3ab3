"""The state equation: markings that firings could reach if their order did not matter.

Each reachable marking is the initial one and what some numbers of firings change. Where no such marking
satisfies a goal, none is reachable. What the equation lets pass is made narrower by traps: one that is marked
at first stays marked. J. Esparza, S. Melzer, *Verification of safety properties using integer programming:
beyond the state equation*, Formal Methods in System Design 16, 2000.

Conditions become rows of a linear program, which HiGHS solves; where a solution is not whole, branch and
bound goes on. The solver's numbers are floating: each refutation and each bound is taken from it as
multipliers of rows, and believed once :func:`mcpn.nets.programs.ceiling` has proved it in whole numbers. An
alternative that no finite bound is known for is left out, which only lets more pass.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import chain
from math import ceil, floor, inf, isinf
from typing import Literal, TypeAlias

from mcpn.nets.petri import PetriNet
from mcpn.nets.programs import LinearProgram, Solved, ceiling, proposed
from mcpn.nets.structure import incidence, place_bounds
from mcpn.records import record
from mcpn.spaces.search.goal import DEADLOCK, And, AtMost, Goal, Or, as_goal, fireable
from mcpn.turns import Pausing, finished

WHOLE = 1e-6
"""How far from a whole number the solver's numbers may be that mean it."""
LARGEST = 10**9
"""Weights and tokens beyond this are not given to the solver."""
MOST_ENTRIES = 200_000
ITERATIONS = 20_000
"""Of the simplex method, for each solution."""
NODES = 100
TRAPS = 30
MOST_SHRUNK = 200
"""Traps of more places are taken as they are."""

Kind: TypeAlias = Literal["unreachable", "possible", "unknown"]
Sums: TypeAlias = tuple[dict[int, int], float, float]
"""Weights by variable, and the least and the most that their sum may be."""


@record(frozen=True)
class Proof:
    """Multipliers that show that no values of the variables satisfy some rows, or bound a sum.

    Variables are the numbers of firings, the tokens of the places, and choices between alternatives. The
    first rows, one for each place, are the state equation.

    Args:
        rows: The rows.
        lower: The least value of each variable.
        upper: The greatest value of each.
        multipliers: By row.
        common: Their denominator.
    """

    rows: Sequence[Sums]
    lower: Sequence[float]
    upper: Sequence[float]
    multipliers: Sequence[int]
    common: int


@record(frozen=True)
class Solution:
    """What the state equation says of a goal.

    Args:
        kind: No marking of the goal is reachable, some numbers of firings may lead to one, or it is not
            decided.
        counts: Numbers of firings, by transition.
        marking: The marking of the goal that they seem to lead to.
        traps: How many traps were needed.
        proofs: Why none is reachable: of each case of the branch and bound.
    """

    kind: Kind
    counts: tuple[int, ...] = ()
    marking: tuple[int, ...] = ()
    traps: int = 0
    proofs: tuple[Proof, ...] = ()


@record(frozen=True)
class Ceiling:
    """The most that a sum of tokens may come to, by the state equation.

    Args:
        bound: No reachable marking has more; ``None`` where no bound is proved.
        counts: Numbers of firings that may lead there, by transition.
        traps: How many traps were needed.
        proof: Why.
    """

    bound: int | None
    counts: tuple[int, ...] = ()
    traps: int = 0
    proof: Proof | None = None


class StateEquation:
    """The state equation of a net.

    Args:
        net: The net.
        bounds: Most tokens of each place, where they are known already; else by the invariants.
    """

    def __init__(self, net: PetriNet, bounds: Sequence[float] = ()) -> None:
        self.net, self._bounds = net, bounds
        self._traps: list[frozenset[int]] = []

    @cached_property
    def bounds(self) -> Sequence[float]:
        """Most tokens of each place, as far as invariants say."""
        return self._bounds or place_bounds(self.net)

    @cached_property
    def fits(self) -> bool:
        """Whether the net is within what the solver is given."""
        arcs = sum(len(t.consume) + len(t.produce) + len(t.read) for t in self.net.transitions)
        return self.net.largest <= LARGEST and arcs <= MOST_ENTRIES

    @cached_property
    def _plain(self) -> _Program:
        """The equation and the traps found, without a goal and without bounds."""
        return _Program(self.net, self._traps)

    def most(self, weights: Mapping[int, int], empty: Iterable[int] = ()) -> Ceiling:
        """The most that a weighted sum of tokens may come to.

        Args:
            weights: By place.
            empty: Places that hold no token in the markings that are asked about.

        Returns:
            A bound that holds, with its proof.
        """
        return finished(self.bounding(weights, empty))

    def bounding(self, weights: Mapping[int, int], empty: Iterable[int] = ()) -> Pausing[Ceiling]:
        """:meth:`most`, with a pause after each program."""
        if not self.fits or max(map(abs, weights.values()), default=0) > LARGEST:
            return Ceiling(None)
        program, best = self._plain, Ceiling(None)
        last: Solved | None = None
        sum_of_places = {program.first_place + place: weight for place, weight in weights.items()}
        case = {program.first_place + place: (0.0, 0.0) for place in empty}
        while True:
            solved = program.solve(sum_of_places, case)
            found = program.proved(solved.duals, sum_of_places, case) if solved.kind == "solved" else None
            if found is None:
                break
            bound, proof = found
            last, best = solved, Ceiling(floor(bound), (), len(program.traps), proof)
            if len(program.traps) >= TRAPS or not (trap := self._trap(program.empty(solved))):
                break
            program.mark(trap)
            yield
        yield
        return best if last is None else replace(best, counts=program.counts(last))

    def shared(self, ceiling: Ceiling) -> dict[int, int]:
        """Bounds of single places that a proof gives besides, where no weight of its sum is negative."""
        if ceiling.proof is None:
            return {}
        first, total = len(self.net.transitions), 0
        weights = [0] * len(self.net.places)
        for multiplier, (row, least, _) in zip(ceiling.proof.multipliers, ceiling.proof.rows, strict=True):
            if multiplier:
                total -= multiplier * int(least)
                for variable, weight in row.items():
                    if variable >= first:
                        weights[variable - first] -= multiplier * weight
        return {place: total // weight for place, weight in enumerate(weights) if weight > 0}

    def solve(self, goal: Goal, most: int = NODES) -> Solution:
        """Whether the equation, with traps, rules a goal out.

        Args:
            goal: Any goal.
            most: Cases of the branch and bound.

        Returns:
            The answer; ``unknown`` also where the net or the goal is too large for the solver.
        """
        return finished(self.solving(goal, most))

    def solving(self, goal: Goal, most: int = NODES) -> Pausing[Solution]:
        """:meth:`solve`, with a pause after each program."""
        found = yield from self._branching(goal, most)
        yield
        return found

    def _branching(self, goal: Goal, most: int) -> Pausing[Solution]:
        if not self.fits:
            return Solution("unknown")
        box = _box(goal)
        if box is not None:  # bounds of places: nothing but them is added to the equation
            program = self._plain
            cases = [{program.first_place + place: pair for place, pair in box.items()}]
        else:
            program, cases = _Program(self.net, self._traps, self.bounds, self._plain), [{}]
            if not program.require(goal):
                return Solution("unknown")
        proofs: list[Proof] = []
        nodes = 0
        while cases:
            case = cases.pop()
            solved = program.solve({}, case)
            if solved.kind == "infeasible":
                found = program.proved(solved.duals, {}, case)
                if found is None:
                    return Solution("unknown")
                proofs.append(found[1])
                yield
                continue
            nodes += 1
            if solved.kind == "unknown" or nodes > most + len(program.traps):
                return Solution("unknown")
            trap = self._trap(program.empty(solved)) if len(program.traps) < TRAPS else frozenset()
            if trap:
                program.mark(trap)
                cases.append(case)
                yield
                continue
            split = program.between(solved)
            if split is None:
                marking = tuple(map(round, program.tokens(solved)))
                return Solution("possible", program.counts(solved), marking, len(program.traps))
            variable, value = split
            low, high = case.get(variable, (program.lower[variable], program.upper[variable]))
            cases += [
                {**case, variable: (low, floor(value))},
                {**case, variable: (floor(value) + 1.0, high)},
            ]
            yield
        return Solution("unreachable", traps=len(program.traps), proofs=tuple(proofs))

    def _trap(self, within: Iterable[int]) -> frozenset[int]:
        """An initially marked trap within some places, shrunk greedily; empty where there is none."""
        trap = self._marked_trap(within)
        for place in sorted(trap) if len(trap) <= MOST_SHRUNK else ():
            if place in trap:
                trap = self._marked_trap(trap - {place}) or trap
        return trap

    def _marked_trap(self, within: Iterable[int]) -> frozenset[int]:
        """The largest set of some places such that what takes from it also puts in it, if it is marked."""
        trap = set(within)
        held = {p for p in trap if self.net.initial[p]}
        if not held:
            return frozenset()
        puts = Counter(chain.from_iterable(map(self._feeders.__getitem__, trap)))
        leaks = list(set(chain.from_iterable(map(self._takers.__getitem__, trap))) - puts.keys())
        while leaks and held:
            for place in self._needs[leaks.pop()] & trap:
                trap.discard(place)
                held.discard(place)
                for t in self._feeders[place]:
                    puts[t] -= 1
                    if not puts[t]:
                        leaks.append(t)
        return frozenset(trap) if held else frozenset()

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


def _box(goal: Goal) -> dict[int, tuple[float, float]] | None:
    """The bounds of places that a goal is made of; ``None`` where it is made of more."""
    box: dict[int, tuple[float, float]] = {}
    for part in goal.operands if isinstance(goal, And) else (goal,):
        match part:
            case AtMost(((place, weight),), bound) if max(abs(weight), abs(bound)) <= LARGEST:
                low, high = box.get(place, (0.0, inf))
                if weight > 0:
                    high = min(high, bound // weight)
                else:
                    low = max(low, -(bound // -weight))
                box[place] = low, high
            case _:
                return None
    # The solver refuses bounds that cross; branch and bound is for all others.
    return None if any(low > high for low, high in box.values()) else box


class _Program:
    """Rows of a linear program: numbers of firings, tokens, and choices between alternatives."""

    def __init__(
        self,
        net: PetriNet,
        traps: list[frozenset[int]],
        bounds: Sequence[float] = (),
        plain: _Program | None = None,
    ) -> None:
        self.net, self.traps, self._plain = net, traps, plain
        self.bounds = bounds = bounds or [inf] * len(net.places)
        self.first_place = len(net.transitions)
        self.first_choice = self.first_place + len(net.places)
        self.lower = [0.0] * self.first_choice
        self.upper = [inf] * self.first_place + list(bounds)
        self._firings = dict.fromkeys(range(self.first_place), 1.0)
        if plain:
            self.rows: list[Sums] = list(plain.rows)
            self._priced: dict[int, float] = plain._priced
            self._changed = set(range(self.first_place, self.first_choice))
        else:
            self.rows = []
            for place, (row, tokens) in enumerate(zip(incidence(net), net.initial, strict=True)):
                self.rows.append(({**row, self.first_place + place: -1}, -tokens, -tokens))
            self._priced, self._changed = {}, set()
            for trap in traps:
                self.at_least(dict.fromkeys(trap, 1), 1)

    def at_least(self, weights: dict[int, int], least: int, choice: int | None = None) -> None:
        """A weighted sum of places is at least so much, where an alternative is chosen if one is given."""
        row = {self.first_place + place: weight for place, weight in weights.items()}
        if choice is not None:
            if any(w < 0 and self.bounds[p] == inf for p, w in weights.items()):
                return
            lowest = sum(w * int(self.bounds[p]) for p, w in weights.items() if w < 0)
            if lowest >= least:
                return
            row[choice] = lowest - least
            least = lowest
        self.rows.append((row, least, inf))

    def mark(self, trap: frozenset[int]) -> None:
        """A trap stays marked."""
        self.traps.append(trap)
        self.at_least(dict.fromkeys(trap, 1), 1)
        self._solver.require(self.rows[-1])

    def require(self, goal: Goal, choice: int | None = None) -> bool:
        """Adds a goal; whether its numbers are within what the solver is given."""
        match goal:
            case AtMost(weights, bound):
                if max([abs(bound), *(abs(weight) for _, weight in weights)]) > LARGEST:
                    return False
                self.at_least({p: -w for p, w in weights}, -bound, choice)
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
        weights: dict[int, int] = {}
        least = 1
        for goal in goals:
            match goal:
                case AtMost(((place, 1),), 0) if self.bounds[place] <= 1 and place not in weights:
                    weights[place] = -1
                    least -= 1
                case AtMost(((place, -1),), -1) if self.bounds[place] <= 1 and place not in weights:
                    weights[place] = 1
                case _:
                    return False
        self.at_least(weights, least, choice)
        return True

    def _choose(self, goals: tuple[Goal, ...], choice: int | None) -> bool:
        chosen = []
        for goal in goals:
            number = len(self.upper)
            self.lower.append(0.0)
            self.upper.append(1.0)
            chosen.append(number)
            if not self.require(goal, number):
                return False
        row = dict.fromkeys(chosen, 1)
        if choice is not None:
            row[choice] = -1
        self.rows.append((row, 1 if choice is None else 0, inf))
        return True

    @cached_property
    def _solver(self) -> LinearProgram:
        if self._plain:
            choices = zip(self.lower[self.first_choice :], self.upper[self.first_choice :], strict=True)
            return self._plain._solver.extended(list(choices), self.rows[len(self._plain.rows) :])
        return LinearProgram(
            [0.0] * len(self.upper),
            self.rows,
            self.lower,
            self.upper,
            presolve="off",  # which tells no multipliers
            simplex_iteration_limit=ITERATIONS,
        )

    def solve(self, most: Mapping[int, int], case: Mapping[int, tuple[float, float]] | None = None) -> Solved:
        """Looks for values where a sum is greatest, or else the firings fewest, within bounds of a case."""
        case = case or {}
        back = {variable: (self.lower[variable], self.upper[variable]) for variable in self._changed}
        self._solver.limit({**back, **case})
        self._changed = set(case)
        costs = {variable: -float(w) for variable, w in most.items()} or self._firings
        self._solver.price({**dict.fromkeys(self._priced, 0.0), **costs})
        self._priced = costs
        return self._solver.minimise()

    def proved(
        self,
        duals: Sequence[float],
        weights: Mapping[int, int],
        case: Mapping[int, tuple[float, float]] | None = None,
    ) -> tuple[float | Fraction, Proof] | None:
        """What a sum cannot exceed; of no sum, that there are no values. ``None`` where neither is proved."""
        if len(duals) != len(self.rows):  # the solver has no proof to propose
            return None
        lower, upper = list(self.lower), list(self.upper)
        for variable, (low, high) in (case or {}).items():
            lower[variable], upper[variable] = low, high
        signs = (1,) if weights else (1, -1)
        largest = 1.0 if weights else max(map(abs, duals), default=1.0) or 1.0
        for sign in signs:
            for multipliers, common in proposed([sign * value / largest for value in duals]):
                bound = ceiling(weights, self.rows, lower, upper, multipliers, common)
                if bound < 0 or (weights and not isinf(bound)):
                    return bound, Proof(tuple(self.rows), lower, upper, multipliers, common)
        return None

    def counts(self, solved: Solved) -> tuple[int, ...]:
        """Numbers of firings of a solution."""
        return tuple(ceil(value - WHOLE) for value in solved.values[: self.first_place])

    def empty(self, solved: Solved) -> set[int]:
        """Places without tokens in a solution."""
        return {place for place, value in enumerate(self.tokens(solved)) if value < WHOLE}

    def tokens(self, solved: Solved) -> Sequence[float]:
        """Tokens of a solution."""
        return solved.values[self.first_place : self.first_choice]

    def between(self, solved: Solved) -> tuple[int, float] | None:
        """A choice, or else the tokens of a place, that a solution leaves between two whole numbers."""
        split = [
            (v < self.first_choice, abs(value % 1 - 0.5), v)
            for v, value in enumerate(solved.values)
            if v >= self.first_place and abs(value - round(value)) > WHOLE
        ]
        return (variable, solved.values[variable]) if split and (variable := min(split)[2]) else None
