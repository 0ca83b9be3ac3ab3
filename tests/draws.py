"""How many examples a property draws, as a share of what the profile of the run asks for."""

from __future__ import annotations

from hypothesis import settings


def fewer(share: float) -> settings:
    """For a property that is costly to judge.

    Args:
        share: Of the examples that the profile draws elsewhere.
    """
    return settings(max_examples=max(5, round(share * settings().max_examples)))
