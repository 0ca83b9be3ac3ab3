"""CTL on the markings of a net as they are needed: no space is built, and places may hold several tokens.

Source: Vergauwen, Lewi, *A linear local model checking algorithm for CTL* (CONCUR 1993); the native kernel
has it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from mcpn._kernel import Checker
from mcpn.check.logic.formulas import EG, EU, EX, And, Const, Formula, Not, Or, as_goal, operands
from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import Goal, encode
from mcpn.space.search.searches import Searches

MAX_BYTES = 1 << 30
KINDS: dict[type, Literal["not", "all", "any", "next", "until", "always"]] = {
    Not: "not",
    And: "all",
    Or: "any",
    EX: "next",
    EU: "until",
    EG: "always",
}


class LocalCheck:
    """Decides formulas at the initial marking of a net; formulas share what is found out.

    Args:
        net: A net without priorities, whose numbers fit (:attr:`Searches.fits`).
        formulas: Those to decide.
        max_bytes: What the markings and the values of operators at them may take.
    """

    def __init__(self, net: PetriNet, formulas: Iterable[Formula], *, max_bytes: int = MAX_BYTES) -> None:
        assert not net.priorities, "atoms are conditions on tokens alone"
        self.net = net
        self._numbers: dict[Formula, int] = {}
        self._given_up: set[int] = set()
        self._operators: list[tuple[str, list[int]]] = []
        goals: list[Goal] = []
        for formula in formulas:
            self._add(formula, goals)
        encoded, roots = encode(goals, len(net.places))
        told = [
            (kind, [roots[i] for i in inside] if kind == "goal" else inside)
            for kind, inside in self._operators
        ]
        self._kernel = Checker(Searches(net).kernel, net.initial, encoded, told, max_bytes)

    def _add(self, formula: Formula, goals: list[Goal]) -> int:
        if formula not in self._numbers:
            goal = as_goal(formula, self.net)
            if goal is None:
                # Parts that no path is looked at for come first.
                inside = operands(formula)
                if isinstance(formula, And | Or):
                    inside = tuple(sorted(inside, key=lambda part: as_goal(part, self.net) is None))
                told: tuple[str, list[int]] = (
                    KINDS[type(formula)],
                    [self._add(part, goals) for part in inside],
                )
            else:
                told = "goal", [len(goals)]
                goals.append(goal)
            self._operators.append(told)
            self._numbers[formula] = len(self._operators) - 1
        return self._numbers[formula]

    def decide(self, formula: Formula, max_steps: int, seed: int = 0) -> bool | None:
        """Whether a formula holds, or ``None`` where a limit was hit.

        Args:
            formula: One of those given, or a part of one that begins with a temporal operator.
            max_steps: How often an operator may be asked at a marking, or an edge be followed.
            seed: Draws the order in which successors are tried; 0 for that of the transitions.
        """
        if isinstance(formula, Const):
            return formula.value
        number = self._numbers[formula]
        answer = "" if number in self._given_up else self._kernel.decide(number, max_steps, seed)
        if answer in ("bytes", "tokens"):
            self._given_up.add(number)
        return {"yes": True, "no": False}.get(answer)

    @property
    def markings(self) -> int:
        """Markings looked at."""
        return self._kernel.markings
