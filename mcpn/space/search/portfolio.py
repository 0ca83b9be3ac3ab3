"""Is some marking of a goal reachable? Asked of cheap ways first, each with a budget that grows by rounds.

The ways are a look at the initial marking, walks, structural reductions with a search of what is left, and
the state equation. Nothing here builds the whole space, and nothing is sure to end with an answer.

Budgets are counts of firings and markings, never seconds, so that the same question has the same answer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from mcpn.net.petri import PetriNet
from mcpn.space.search.goal import Goal, holds
from mcpn.space.search.searches import Run, Searches

INITIAL_STATE, RANDOM_WALK, STUBBORN_SETS = "INITIAL_STATE", "RANDOM_WALK", "STUBBORN_SETS"
EXPLICIT = "EXPLICIT"


@dataclass(frozen=True)
class Finding:
    """Whether a goal is reachable, and how that was found.

    Args:
        reachable: The answer.
        run: Transitions of the net from its initial marking to the goal, where it is reachable.
        techniques: The ways that led to the answer, in words of the Model Checking Contest.
    """

    reachable: bool
    run: Run | None
    techniques: tuple[str, ...]


@dataclass(frozen=True)
class Round:
    """Budgets of one round, for each goal.

    Args:
        steps: Firings of a walk.
        states: Markings of a search.
    """

    steps: int
    states: int


ROUNDS = (Round(20_000, 2_000), Round(100_000, 20_000), Round(400_000, 200_000))


class Portfolio:
    """Decides goals on one net.

    Args:
        net: A net without priorities.
    """

    def __init__(self, net: PetriNet) -> None:
        assert not net.priorities, "reductions and stubborn sets do not know priorities"
        self.net = net

    @cached_property
    def searches(self) -> Searches:
        """Walks and searches on the net itself."""
        return Searches(self.net)

    def decide(
        self, goals: Sequence[Goal], rounds: Sequence[Round] = ROUNDS
    ) -> Iterator[tuple[int, Finding]]:
        """Decides goals, the easy ones first.

        Args:
            goals: What may be reachable.
            rounds: Budgets, growing.

        Yields:
            The index of a goal and what was found, as it comes; goals that no way decides are left out.
        """
        waiting = []
        for index, goal in enumerate(goals):
            if holds(goal, self.net, self.net.initial):
                yield index, Finding(True, (), (INITIAL_STATE,))
            else:
                waiting.append(index)
        if not self.searches.fits:
            return
        for number, budget in enumerate(rounds):
            if not waiting:
                return
            walked = self.searches.walk(
                [goals[index] for index in waiting], steps=budget.steps * len(waiting), seed=number
            )
            for position, run in walked.items():
                yield waiting[position], Finding(True, run, (RANDOM_WALK,))
            waiting = [index for position, index in enumerate(waiting) if position not in walked]
            left = []
            for index in waiting:
                finding = self._search(goals[index], budget)
                if finding is None:
                    left.append(index)
                else:
                    yield index, finding
            waiting = left

    def _search(self, goal: Goal, budget: Round) -> Finding | None:
        found = self.searches.seek(goal, max_states=budget.states)
        if found.outcome == "reached":
            return Finding(True, found.run, (EXPLICIT, STUBBORN_SETS))
        if found.outcome == "unreachable":
            return Finding(False, None, (EXPLICIT, STUBBORN_SETS))
        return None
