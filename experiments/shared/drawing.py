"""Draws of hypothesis outside of tests: as many as are asked for, the same ones for the same seed."""

from __future__ import annotations

from typing import TypeVar

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis.strategies import SearchStrategy

Drawn = TypeVar("Drawn")


def drawn(strategy: SearchStrategy[Drawn], number: int, seed: int) -> list[Drawn]:
    """Values of a strategy.

    Args:
        strategy: The strategy.
        number: How many.
        seed: Which ones.
    """
    found: list[Drawn] = []

    @seeded(seed)
    @settings(
        max_examples=number,
        phases=(Phase.generate,),
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(strategy)
    def collect(value: Drawn) -> None:
        found.append(value)

    collect()
    return found
