"""Whether some path from the initial marking satisfies a formula, decided on the fly, without a space.

The automaton of the formula is run beside the net (:mod:`mcpn.logic.ltl.lasso`). Before that, conditions on
markings that are known to hold always, or never, are replaced by constants. If the automaton then accepts
nothing, no marking is explored; nor is one if it accepts nothing in conjunction with the conditions that are
known to hold at some time on every path. For a stutter-insensitive formula the net is reduced first.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from mcpn.errors import LimitError
from mcpn.logic.ltl.automaton import translated
from mcpn.logic.ltl.formula_classes import is_stutter_insensitive
from mcpn.logic.ltl.formulas import Release, Until, atom_of, is_of_paths, normal
from mcpn.logic.ltl.path_search import FoundPath, PathSearch
from mcpn.nets.petri import PetriNet
from mcpn.nets.reduce.reduction import Reduction, reduce_for_paths
from mcpn.records import record
from mcpn.spaces.search.goal import (
    FALSE,
    TRUE,
    And,
    Formula,
    Goal,
    Not,
    Or,
    as_goal,
    asks_dead,
    holds,
    joined,
    renamed,
    wanted,
)
from mcpn.spaces.search.portfolio import ROUNDS, Portfolio
from mcpn.spaces.search.searches import Searches
from mcpn.turns import Pausing, finished

RESTARTS = (
    *[(64, False)] * 2,
    *[(400, True)] * 2,
    *[(64, False)] * 6,
    *[(8, False)] * 4,
    (1, False),
)
"""Searches with a drawn order each, for one that begins badly may never end: the divisor of the steps, and
whether it is guided, so that each step looks at all of the net."""

MOST_ASKED = 8
"""Limit on conditions that are tested for holding at some time on every path."""
MOST_KNOWN = 2_000
"""Places and transitions of a net up to which conditions are searched that hold always, or never."""
FEW_STEPS = 2_000
"""Limit on steps of the product in such a test."""


@record(frozen=True)
class _Asked:
    """A search for a path of a net.

    Args:
        net: The net.
        search: The search, in it or in a smaller one.
        reduction: The reduction that made the smaller net; ``None`` where the search is in the net.
    """

    net: PetriNet
    search: PathSearch
    reduction: Reduction | None = None

    def finding(self, steps: int, seed: int, *, guided: bool) -> Pausing[FoundPath | None]:
        """How the search ends; ``None`` where it finds a path that is a cycle in the smaller net alone."""
        path = yield from self.search.searching(steps, seed, guided=guided)
        return path if self.reduction is None or path.outcome != "found" else self._lifted(path)

    def _lifted(self, path: FoundPath) -> FoundPath | None:
        """A path of the smaller net in the net; ``None`` where its cycle is none there."""
        assert self.reduction is not None
        split = len(path.run) if path.cycle is None else path.cycle
        begin = self.reduction.lift(path.run[:split])
        repeated = tuple(chain.from_iterable(self.reduction.runs[t] for t in path.run[split:]))
        marking = list(self.net.initial)
        for t in begin:
            self.net.fire_in_place(marking, t)
        if path.cycle is not None:
            after = list(marking)
            for t in repeated:
                self.net.fire_in_place(after, t)
            return path._replace(run=begin + repeated, cycle=len(begin)) if after == marking else None
        return path._replace(run=begin + self._ended(path, marking))

    def _ended(self, path: FoundPath, marking: list[int]) -> tuple[int, ...]:
        """Where the path has ended in the smaller net, what is left to fire until it ends in this one."""
        assert self.reduction is not None
        smaller, reached = self.reduction.net, list(self.reduction.net.initial)
        for t in path.run:
            smaller.fire_in_place(reached, t)
        rest = list[int]()
        while not smaller.enabled(reached) and (enabled := self.net.enabled(marking)):
            rest.append(enabled[0])
            self.net.fire_in_place(marking, enabled[0])
        return tuple(rest)


class PathParts:
    """Says whether paths from the initial marking of a net satisfy formulas.

    Args:
        net: The net.
        searches: Walks on it, where there are some already.
    """

    def __init__(self, net: PetriNet, searches: Searches | None = None) -> None:
        self._net, self._own = net, searches or Searches(net)
        self._searches: dict[Formula, _Asked | None] = {}
        self._constants: dict[Goal, Formula | None] = {}
        self._enriched = set[Formula]()
        self._inevitable: dict[Formula, bool] = {}

    def decide(self, path: Formula, steps: int, seed: int, *, enrich: bool = False) -> FoundPath | None:
        """What :meth:`deciding` finds."""
        return finished(self.deciding(path, steps, seed, enrich=enrich))

    def deciding(
        self, path: Formula, steps: int, seed: int, *, enrich: bool = False
    ) -> Pausing[FoundPath | None]:
        """Whether such a path begins in the initial marking, with pauses.

        Args:
            path: A formula on paths, or on states.
            steps: How many steps of the product are followed in the last order that is tried.
            seed: Draws the orders.
            enrich: Whether to ask first which conditions hold always, never, or at some time on every path,
                and to make the net smaller.

        Returns:
            How the search ended; ``None`` where it cannot be asked so.
        """
        if path not in self._searches:
            self._searches[path] = self._search(path)
        if enrich and path not in self._enriched:
            self._enriched.add(path)
            self._searches[path] = yield from self._enriching(path)
        asked = self._searches[path]
        if asked is None:
            return None
        for number, (share, guided) in enumerate(RESTARTS):
            number += len(RESTARTS) * seed
            answer = yield from asked.finding(steps // share, number, guided=guided)
            if answer is None or answer.outcome != "steps":
                break
            yield
        if answer is None:
            self._searches[path] = self._search(path)
            return (yield from self.deciding(path, steps, seed))
        if answer.outcome in ("bytes", "tokens"):
            self._searches[path] = None  # more steps would meet the same limit
        return answer

    def _enriching(self, path: Formula) -> Pausing[_Asked | None]:
        """The search for what is left of a formula by what is known, in a smaller net."""
        path = normal(path)
        if sum(_size(self._net)) <= MOST_KNOWN:
            path = normal((yield from self._with_constants(path)))
        refuted = yield from self._refuting(path)
        path, reduction = FALSE if refuted else path, None
        try:
            if (smaller := self._reduced(path)) is not None:
                reduction, path = smaller
            return self._search(path, reduction)
        except LimitError:
            return None

    def _search(self, path: Formula, reduction: Reduction | None = None) -> _Asked | None:
        net, searches = (reduction.net, None) if reduction else (self._net, self._own)
        try:
            search = PathSearch(net, translated(normal(path)), searches)
        except LimitError:
            return None
        return _Asked(self._net, search, reduction) if search.fits else None

    def _refuting(self, path: Formula) -> Pausing[bool]:
        """Whether no path satisfies both a formula and what holds at some time on every path of the net."""
        plain = dict.fromkeys(map(atom_of, _conditions(path)))
        literals = [literal for c in [*plain][:MOST_ASKED] for literal in (c, Not(c))]
        inevitable = []
        for literal in literals:
            if self._is_inevitable(literal):
                inevitable.append(Until(TRUE, literal))
            yield
        try:
            return bool(inevitable) and translated(normal(And(path, *inevitable))).is_empty
        except LimitError:
            return False

    def _is_inevitable(self, condition: Formula) -> bool:
        """Whether a short search proves that a condition, false at first, holds some time on every path."""
        if condition not in self._inevitable:
            self._inevitable[condition] = False
            goal = as_goal(condition, self._net)
            if goal is not None and not holds(goal, self._net, self._net.initial):
                never = translated(normal(Release(FALSE, Not(condition))))
                search = PathSearch(self._net, never, self._own)
                self._inevitable[condition] = search.fits and search.search(FEW_STEPS, 0).outcome == "none"
        return self._inevitable[condition]

    def _reduced(self, path: Formula) -> tuple[Reduction, Formula] | None:
        """A smaller net for a formula, and the formula there; ``None`` where none would give its answer."""
        goals = {condition: as_goal(condition, self._net) for condition in _conditions(path)}
        observed = [goal for goal in goals.values() if goal is not None and not asks_dead(goal)]
        if self._net.priorities or len(observed) < len(goals) or not is_stutter_insensitive(path):
            return None
        reduction = reduce_for_paths(self._net, {place for goal in observed for place in wanted(goal)})
        if _size(reduction.net) == _size(self._net):
            return None  # it would only be searched in another order
        there = {
            condition: renamed(goal, reduction.place_index.__getitem__)
            for condition, goal in goals.items()
            if goal is not None
        }

        def put(formula: Formula) -> Formula:
            return formula.mapped(put) if is_of_paths(formula) else there.get(formula, formula)

        return reduction, put(path)

    def _with_constants(self, path: Formula) -> Pausing[Formula]:
        """The formula with constants for conditions on markings that hold always, or never."""
        conditions = list(dict.fromkeys(_conditions(path)))
        asked: dict[Goal, None] = {}
        for condition in conditions:
            for value in (True, False):
                goal = as_goal(condition, self._net, value)
                if goal is not None and goal not in self._constants:
                    asked[goal] = None
        goals = list(asked)
        self._constants.update(dict.fromkeys(goals))
        for told in Portfolio(self._net, self._own).deciding(goals, ROUNDS[:2]):
            if told is None:
                yield
            elif not told[1].reachable:
                self._constants[goals[told[0]]] = FALSE

        def put(formula: Formula) -> Formula:
            if is_of_paths(formula):
                mapped = formula.mapped(put)
                return joined(mapped) if isinstance(mapped, And | Or) else mapped
            for value in (True, False):
                goal = as_goal(formula, self._net, value)
                if goal is not None and self._constants.get(goal) == FALSE:
                    return FALSE if value else TRUE
            return formula

        return put(path)


def _size(net: PetriNet) -> tuple[int, int]:
    return len(net.places), len(net.transitions)


def _conditions(path: Formula) -> Iterator[Formula]:
    """The largest parts of a formula on paths that speak of one state, constants aside."""
    if not is_of_paths(path):
        if path not in (TRUE, FALSE):
            yield path
        return
    for operand in path.operands:
        yield from _conditions(operand)
