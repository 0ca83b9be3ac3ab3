"""What is asked of paths from the initial marking, decided marking by marking as they are needed.

The automaton of a formula is run beside the net (:mod:`mcpn.check.paths.search`). What is known to hold
always, or never, of the conditions on markings that the formula speaks of is put in before: an automaton that
then accepts nothing needs no marking at all.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.check.paths.automaton import translated
from mcpn.check.paths.formulas import is_of_paths, normal
from mcpn.check.paths.search import FoundPath, PathSearch
from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import FALSE, TRUE, And, Formula, Goal, Or, as_goal, joined
from mcpn.space.search.portfolio import ROUNDS, Portfolio

RESTARTS = (*[64] * 8, *[8] * 4, 1)
"""What share of the steps each order has: where it begins badly, a search goes astray for ever."""


class PathParts:
    """Says whether paths from the initial marking of a net satisfy formulas.

    Args:
        net: The net.
    """

    def __init__(self, net: PetriNet) -> None:
        self._net = net
        self._searches: dict[Formula, PathSearch | None] = {}
        self._constants: dict[Goal, Formula | None] = {}
        self._enriched = set[Formula]()

    def decide(self, path: Formula, steps: int, seed: int, *, enrich: bool = False) -> FoundPath | None:
        """Whether such a path begins in the initial marking.

        Args:
            path: A formula on paths, or on states.
            steps: How many steps of the product are followed in the last order that is tried.
            seed: Draws the orders.
            enrich: Whether to ask first which conditions hold always, or never.

        Returns:
            How the search ended; ``None`` where it cannot be asked so.
        """
        if path not in self._searches:
            self._searches[path] = self._search(path)
        if enrich and path not in self._enriched:
            self._enriched.add(path)
            self._searches[path] = self._search(path, enrich=True)
        search = self._searches[path]
        if search is None:
            return None
        for number, share in enumerate(RESTARTS):
            found = search.search(steps // share, len(RESTARTS) * seed + number)
            if found.outcome != "steps":
                break
        if found.outcome in ("bytes", "tokens"):
            self._searches[path] = None  # more steps would meet the same limit
        return found

    def _search(self, path: Formula, *, enrich: bool = False) -> PathSearch | None:
        path = normal(path)
        if enrich:
            path = normal(self._with_constants(path))
        try:
            search = PathSearch(self._net, translated(path))
        except LimitError:
            return None
        return search if search.fits else None

    def _with_constants(self, path: Formula) -> Formula:
        """The formula with constants for conditions on markings that hold always, or never."""
        conditions = list(dict.fromkeys(_conditions(path)))
        asked: dict[Goal, None] = {}
        for condition in conditions:
            for wanted in (True, False):
                goal = as_goal(condition, self._net, wanted)
                if goal is not None and goal not in self._constants:
                    asked[goal] = None
        goals = list(asked)
        self._constants.update(dict.fromkeys(goals))
        for index, found in Portfolio(self._net).decide(goals, ROUNDS[:2]):
            if not found.reachable:
                self._constants[goals[index]] = FALSE

        def put(formula: Formula) -> Formula:
            if is_of_paths(formula):
                mapped = formula.mapped(put)
                return joined(mapped) if isinstance(mapped, And | Or) else mapped
            for wanted in (True, False):
                goal = as_goal(formula, self._net, wanted)
                if goal is not None and self._constants.get(goal) == FALSE:
                    return FALSE if wanted else TRUE
            return formula

        return put(path)


def _conditions(path: Formula) -> Iterator[Formula]:
    """The largest parts of a formula on paths that speak of one state, constants aside."""
    if not is_of_paths(path):
        if path not in (TRUE, FALSE):
            yield path
        return
    for operand in path.operands:
        yield from _conditions(operand)
