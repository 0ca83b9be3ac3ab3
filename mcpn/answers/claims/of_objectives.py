"""Claims on which losses of hardware leave an objective no way to succeed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.entries import together
from mcpn.events import Event, What

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, GoalCauses

BEFOREHAND = Assumes(repairs="others")


def claims_of_objectives(causes: Causes) -> Iterator[Claim]:
    """What losses beforehand cost each objective."""
    for name, goal in causes.objectives.items():
        yield from claims_of_objective(goal, name)


def claims_of_objective(goal: GoalCauses, name: str) -> Iterator[Claim]:
    """What losses beforehand cost an objective, or several with the same causes.

    Args:
        goal: One of them.
        name: Its name, or theirs in words.
    """
    if () in goal.cut_sets:
        event = Event(What.SUCCESS, name)
        yield Claim("outcome_comes", (name, "success"), False, formula=f"E(F happens({event}))")
    elif not goal.cut_sets:
        yield Claim("losses_lose_objective", (name,), False, BEFOREHAND)
    else:
        for lost in goal.cut_sets:
            yield Claim("loss_before_loses_objective", (together(lost), name), True, BEFOREHAND)
