"""What is asked of nets, and what an answer to one question says of others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias

from mcpn.logic.formulas import EU
from mcpn.logic.without_space import SOME_DEADLOCK
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import And, Fires, Formula

Meaning: TypeAlias = Formula | tuple[int, ...] | str
"""A formula; places, where the most tokens that they hold together is asked; or an examination's name."""

ONE_SAFE, QUASI_LIVE, LIVE = "OneSafe", "QuasiLiveness", "Liveness"
_FOLLOWS: tuple[tuple[Meaning, bool, Meaning, bool], ...] = (
    (SOME_DEADLOCK, True, LIVE, False),
    ("ReachabilityDeadlock", True, LIVE, False),
    (LIVE, True, QUASI_LIVE, True),
)
IMPLICATIONS: tuple[tuple[tuple[Meaning, bool], tuple[Meaning, bool]], ...] = tuple(
    pair
    for what, holds, then, follows in _FOLLOWS
    for pair in (((what, holds), (then, follows)), ((then, not follows), (what, not holds)))
)
"""What an answer implies, of nets that have transitions; each stands here with its contraposition."""


def implied(
    asked: Meaning, value: float, net: PetriNet, parts: Callable[[], Iterable[Formula]]
) -> list[tuple[Meaning, bool]]:
    """What an answer says of examinations, and of formulas that ask whether a transition fires.

    Args:
        asked: The question.
        value: Its answer.
        net: The net.
        parts: What formulas are asked of it.
    """
    if isinstance(asked, tuple):
        return [(ONE_SAFE, False)] if value > len(asked) else []
    if not net.transitions or net.priorities:
        return []
    then = [follows for (what, holds), follows in IMPLICATIONS if (what, holds) == (asked, bool(value))]
    if not value and _asks_firing(asked):
        then += [(QUASI_LIVE, False), (LIVE, False)]
    elif value and asked in (QUASI_LIVE, LIVE):
        then += [(part, True) for part in parts() if _asks_firing(part)]
    return then


def _asks_firing(asked: Meaning) -> bool:
    """Whether it is asked if some of one or more transitions ever fire."""
    match asked:
        case EU((And(()), Fires(transitions))):
            return bool(transitions)
    return False
