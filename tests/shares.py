"""How often properties return early, and why: a property that mostly looks away shows little.

A test under hypothesis that leaves an example calls :func:`returns_early` with the reason. The reason is an
event of hypothesis (``--hypothesis-show-statistics`` lists them), and it is counted: ``conftest.py`` fails a
test of which more than :data:`CEILING` of the examples left.
"""

from __future__ import annotations

from collections import Counter
from math import sqrt

from hypothesis import event

CEILING = 0.6
"""The largest share of examples that may be left, unless a test is marked ``may_leave(share)``."""

ENOUGH = 5
"""Examples below which a share says nothing."""


def most(examples: int, ceiling: float) -> float:
    """How many of some examples may be left: the share and two standard deviations, but never all.

    The deviations, since they are drawn: of ten examples nine may be left, of two hundred 133. One alone let
    a property that leaves a third of many fail at two of three seeds: draws of one run resemble each other.
    """
    return min(examples - 1, ceiling * examples + 2 * sqrt(ceiling * (1 - ceiling) * examples))


left: Counter[str] = Counter()
"""Examples left by the test under way, by reason."""


def returns_early(reason: str) -> None:
    """Counts that the test under way leaves an example.

    Args:
        reason: Why, in a few words.
    """
    event(f"left: {reason}")
    left[reason] += 1
