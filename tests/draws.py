"""How many examples a property draws, as a share of what the profile asks for, and how large they may be."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TypeVar

from hypothesis import HealthCheck, Phase, assume, given, seed, settings
from hypothesis.strategies import SearchStrategy

from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Mission

Drawn = TypeVar("Drawn")

MOST_TRANSITIONS = 2_000
"""Larger nets are drawn now and then; a proof on their diagrams takes minutes."""


def composed(mission: Mission) -> MissionNet:
    """The net of a drawn mission; for one of more than :data:`MOST_TRANSITIONS` another is drawn."""
    mission_net = compose(mission)
    assume(len(mission_net.net.transitions) <= MOST_TRANSITIONS)
    return mission_net


def fewer(share: float, least: int = 5) -> settings:
    """For a property that is costly to judge.

    Args:
        share: Of the examples that the profile draws elsewhere.
        least: As many are drawn in each profile.
    """
    return settings(max_examples=max(least, round(share * settings().max_examples)))


def campaign(strategy: SearchStrategy[Drawn], judge: Callable[[Drawn], str], number: int) -> Counter[str]:
    """Judges many draws, for tests that are marked slow; prints how many were of which kind.

    ``MCPN_CAMPAIGN`` says how many are drawn, ``MCPN_CAMPAIGN_SEED`` which ones.

    Args:
        strategy: What is drawn.
        judge: Fails, or says of which kind a draw was.
        number: How many, where the environment does not say.

    Returns:
        How many were drawn, as ``drawn``, and of each kind.
    """
    found = Counter[str]()

    @seed(int(os.environ.get("MCPN_CAMPAIGN_SEED", "1")))
    @settings(
        max_examples=int(os.environ.get("MCPN_CAMPAIGN", number)),
        phases=[Phase.generate, Phase.shrink],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(strategy)
    def judged(drawn: Drawn) -> None:
        found["drawn"] += 1
        found[judge(drawn)] += 1

    judged()
    sys.stderr.write(f"\n{', '.join(f'{count} {what}' for what, count in found.most_common())}\n")
    return found


def compared(
    strategy: SearchStrategy[Drawn],
    judge: Callable[[Drawn], Mapping[str, int]],
    number: int,
    *,
    strict: bool,
) -> Counter[str]:
    """Has other tools judge so many draws; what they cannot be asked is drawn again.

    Args:
        strategy: What is drawn.
        judge: Says how much of what was compared, nothing where it cannot be asked; fails where it differs.
        number: How many are judged, if eight times as many draws have them, or 30.
        strict: Whether a difference fails; else it is counted, as ``differ``, and draws are always the same.

    Returns:
        How many were judged, as ``judged``, and what was compared.
    """
    found = Counter[str]()

    @settings(
        max_examples=max(8 * number, 30),
        phases=[Phase.generate, *([Phase.shrink] if strict else [])],
        deadline=None,
        database=None,
        derandomize=not strict,
        suppress_health_check=list(HealthCheck),
    )
    @given(strategy)
    def judged(drawn: Drawn) -> None:
        if found["judged"] >= number:
            return
        try:
            said = judge(drawn)
        except AssertionError:
            if strict:
                raise
            said = {"differ": 1}
        found.update(said)
        found["judged"] += bool(said)

    judged()
    return found
