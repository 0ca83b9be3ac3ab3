"""Internal evolution of sets of markings, on diagrams: its closure forward (:func:`behind`), and backward.

Where all internal transitions have one rank, both are one saturation. Where they have several, a transition
fires only in markings that enable none of a lower rank: the first rank is saturated, then each of the
others fires once where it may, and so on until nothing is new.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_

from mcpn._kernel import BudgetExceeded, Zdd
from mcpn.spaces.diagrams.encoding import Encoding


class Clock:
    """The steps that closures may take together.

    Args:
        budget: Their number; 0: any.
    """

    def __init__(self, budget: int = 0) -> None:
        self.budget = budget
        self.spent = 0

    @property
    def left(self) -> int:
        """What is left of the budget, 0 where there is none.

        Raises:
            BudgetExceeded: Nothing is left.
        """
        if self.budget and self.spent >= self.budget:
            raise BudgetExceeded(f"the budget of {self.budget} steps was exceeded")
        return self.budget and self.budget - self.spent


def behind(
    encoding: Encoding, begun: Zdd, clock: Clock | None = None, *, ranks: int | None = None
) -> tuple[Zdd, Zdd]:
    """The markings that internal evolution comes to from some others, and those in which it ends.

    Args:
        encoding: The net, which has priorities, on the levels of a store.
        begun: Where internal evolution begins.
        clock: What it may take.
        ranks: How many of the ranks take part, the first ones; all by default.

    Returns:
        All markings that internal evolution passes, those it begins with included; and those in which no
        transition of these ranks is enabled, the stable ones.

    Raises:
        BudgetExceeded: The steps of the clock were not enough.
    """
    clock, store = clock or Clock(), encoding.store
    first, *later = encoding.internal_ranks[:ranks] or ([],)
    unstable, *unstable_later = encoding.unstable_ranks[:ranks] or ([],)
    reached = stable = store.empty()
    front = begun
    while front:
        front = front.saturate(first, max_steps=clock.left)
        clock.spent += store.steps
        if later:
            front -= reached
        reached |= front
        rest, front = front.without(unstable), store.empty()
        for events, conditions in zip(later, unstable_later, strict=True):
            if not rest:
                break
            front |= rest.images(events)
            clock.spent += store.steps
            rest = rest.without(conditions)
        stable |= rest
        front -= reached
    return reached, stable


def leading(encoding: Encoding, goal: Zdd, allowed: Sequence[Zdd]) -> Zdd:
    """The markings from which some internal run leads into a goal.

    Args:
        encoding: The net, which has priorities, on the levels of a store.
        goal: Where the runs lead.
        allowed: By rank, the markings in which its transitions may fire.
    """
    if len(allowed) <= 1:
        return goal.saturate(encoding.internal_back, within=reduce(or_, allowed)) if allowed else goal
    first, *later = encoding.undoing_ranks
    sources, front = encoding.store.empty(), goal
    while front:
        front = front.saturate(first, within=allowed[0]) - sources
        sources |= front
        before = (
            front.images(events, within=where) for events, where in zip(later, allowed[1:], strict=True)
        )
        front = reduce(or_, list(before)) - sources
    return sources


def passing(encoding: Encoding, markings: Zdd) -> list[Zdd]:
    """By rank, those of some markings in which its transitions may fire: none of a lower rank is enabled."""
    sets = []
    for conditions in encoding.unstable_ranks:
        sets.append(markings)
        markings = markings.without(conditions)
    return sets
