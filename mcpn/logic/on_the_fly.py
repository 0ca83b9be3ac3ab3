"""CTL on the fly: markings are explored as needed, no space is built; places may hold several tokens.

Source: Vergauwen, Lewi, *A linear local model checking algorithm for CTL* (CONCUR 1993); the native kernel
has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

from mcpn._kernel import Checker
from mcpn.logic.formulas import EG, EU, EX
from mcpn.nets.petri import PetriNet
from mcpn.nets.reduce.reduction import reduce_for_branching
from mcpn.spaces.search.goal import (
    FALSE,
    TRUE,
    And,
    AtMost,
    Deadlock,
    Fires,
    Formula,
    Goal,
    Not,
    Or,
    as_goal,
    encode,
    renamed,
    wanted,
)
from mcpn.spaces.search.searches import Searches
from mcpn.turns import Pausing, finished

MAX_BYTES = 1 << 30
Kind = Literal["goal", "not", "all", "any", "next", "until", "always"]
KINDS: dict[type, Kind] = {Not: "not", And: "all", Or: "any", EX: "next", EU: "until", EG: "always"}


class OnTheFlyCheck:
    """Decides formulas at the initial marking of a net; formulas share what is found out.

    Args:
        net: A net without priorities, whose numbers fit (:attr:`Searches.fits`).
        formulas: Those to decide.
        searches: Walks on the net, where there are some already.
        max_bytes: What the markings and the values of operators at them may take.
    """

    def __init__(
        self,
        net: PetriNet,
        formulas: Iterable[Formula],
        searches: Searches | None = None,
        *,
        max_bytes: int = MAX_BYTES,
    ) -> None:
        assert not net.priorities, "atoms are conditions on tokens alone"
        self._numbers: dict[Formula, int] = {}
        self._given_up: set[int] = set()
        operators: list[tuple[Kind, list[int]]] = []
        goals: list[Goal] = []

        def add(formula: Formula) -> int:
            if formula in self._numbers:
                return self._numbers[formula]
            if goal := as_goal(formula, net):
                operators.append(("goal", [len(goals)]))
                goals.append(goal)
            else:
                operands = formula.operands
                if isinstance(formula, And | Or):  # parts without temporal operators come first
                    operands = tuple(sorted(operands, key=lambda part: as_goal(part, net) is None))
                operators.append((KINDS[type(formula)], list(map(add, operands))))
            return self._numbers.setdefault(formula, len(operators) - 1)

        for formula in formulas:
            add(formula)
        encoded, roots = encode(goals, len(net.places))
        nodes = [(kind, [roots[i] for i in parts] if kind == "goal" else parts) for kind, parts in operators]
        self._kernel = Checker((searches or Searches(net)).kernel, net.initial, encoded, nodes, max_bytes)

    def decide(self, formula: Formula, max_steps: int, seed: int = 0) -> bool | None:
        """What :meth:`deciding` finds."""
        return finished(self.deciding(formula, max_steps, seed))

    def deciding(self, formula: Formula, max_steps: int, seed: int = 0, *pause: int) -> Pausing[bool | None]:
        """Whether a formula holds, or ``None`` where a limit was hit, with pauses.

        Args:
            formula: One of those given, or a part of one that begins with a temporal operator.
            max_steps: How often an operator may be asked at a marking, or an edge be followed.
            seed: Draws the order in which successors are tried; 0 for that of the transitions.
            *pause: After about how many steps there is one, where the kernel is not to say.
        """
        if formula in (TRUE, FALSE):
            return formula == TRUE
        number = self._numbers[formula]
        if number in self._given_up:
            return None
        while (answer := self._kernel.decide(number, max_steps, seed, *pause)) == "pause":
            yield
        if answer in ("bytes", "tokens"):
            self._given_up.add(number)
        return {"yes": True, "no": False}.get(answer)

    @property
    def markings(self) -> int:
        """Markings looked at."""
        return self._kernel.markings


class LocalChecks:
    """Decides formulas on the fly: those that say nothing of single steps on a net reduced for all of them.

    Args:
        net: A net without priorities, whose numbers fit.
        searches: Walks on it.
    """

    def __init__(self, net: PetriNet, searches: Searches) -> None:
        self._net, self._searches = net, searches
        self._by: dict[Formula, tuple[OnTheFlyCheck, Formula]] = {}

    def ask(self, formulas: Sequence[Formula]) -> None:
        """Makes ready for formulas; what was found out of others is forgotten where some are new."""
        if all(formula in self._by for formula in formulas):
            return
        self._by.clear()
        insensitive = [f for f in formulas if not any(isinstance(part, EX | Deadlock) for part in f.walk())]
        goals = {atom: as_goal(atom, self._net) for f in insensitive for atom in f.walk() if _is_atom(atom)}
        kept = {place for goal in goals.values() if goal for place in wanted(goal)}
        reduction = reduce_for_branching(self._net, kept)
        if len(reduction.net.transitions) < len(self._net.transitions):

            def there(formula: Formula) -> Formula:
                if goal := goals.get(formula):
                    return renamed(goal, reduction.place_index.__getitem__)
                return formula.mapped(there)

            self._put({formula: there(formula) for formula in insensitive}, reduction.net, None)
        self._put({f: f for f in formulas if f not in self._by}, self._net, self._searches)

    def _put(self, formulas: Mapping[Formula, Formula], net: PetriNet, searches: Searches | None) -> None:
        searches = searches or Searches(net)
        if formulas and searches.fits:
            check = OnTheFlyCheck(net, formulas.values(), searches)
            self._by.update((formula, (check, same)) for formula, same in formulas.items())

    def deciding(self, formula: Formula, max_steps: int, seed: int = 0) -> Pausing[bool | None]:
        """Whether a formula holds at first, as :meth:`OnTheFlyCheck.deciding` says it."""
        check, same = self._by[formula]
        return check.deciding(same, max_steps, seed)


def _is_atom(formula: Formula) -> bool:
    return isinstance(formula, AtMost | Fires)
