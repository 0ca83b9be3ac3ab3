"""CTL on the fly: markings are explored as needed, no space is built; places may hold several tokens.

Source: Vergauwen, Lewi, *A linear local model checking algorithm for CTL* (CONCUR 1993); the native kernel
has it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from mcpn._kernel import Checker
from mcpn.logic.formulas import EG, EU, EX
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import FALSE, TRUE, And, Formula, Goal, Not, Or, as_goal, encode
from mcpn.spaces.search.searches import Searches

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
        """Whether a formula holds, or ``None`` where a limit was hit.

        Args:
            formula: One of those given, or a part of one that begins with a temporal operator.
            max_steps: How often an operator may be asked at a marking, or an edge be followed.
            seed: Draws the order in which successors are tried; 0 for that of the transitions.
        """
        if formula in (TRUE, FALSE):
            return formula == TRUE
        number = self._numbers[formula]
        answer = "" if number in self._given_up else self._kernel.decide(number, max_steps, seed)
        if answer in ("bytes", "tokens"):
            self._given_up.add(number)
        return {"yes": True, "no": False}.get(answer)

    @property
    def markings(self) -> int:
        """Markings looked at."""
        return self._kernel.markings
