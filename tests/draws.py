"""How many examples a property draws, as a share of what the profile asks for, and how large they may be."""

from __future__ import annotations

from hypothesis import assume, settings

from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Mission

MOST_TRANSITIONS = 2_000
"""Larger nets are drawn now and then; a proof on their diagrams takes minutes."""


def composed(mission: Mission) -> MissionNet:
    """The net of a drawn mission; for one of more than :data:`MOST_TRANSITIONS` another is drawn."""
    mission_net = compose(mission)
    assume(len(mission_net.net.transitions) <= MOST_TRANSITIONS)
    return mission_net


def fewer(share: float) -> settings:
    """For a property that is costly to judge.

    Args:
        share: Of the examples that the profile draws elsewhere.
    """
    return settings(max_examples=max(5, round(share * settings().max_examples)))
