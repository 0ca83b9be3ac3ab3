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
    """How many of some examples may be left: the share, and a standard deviation, since they are drawn.

    Of five examples four may be left, of ten seven, of two hundred 126. Of the properties at hand none leaves
    more than four of ten; one that leaves 0.4 of many leaves eight of ten once in eighty times.
    """
    return ceiling * examples + sqrt(ceiling * (1 - ceiling) * examples)


left: Counter[str] = Counter()
"""Examples left by the test under way, by reason."""


def returns_early(reason: str) -> None:
    """Counts that the test under way leaves an example.

    Args:
        reason: Why, in a few words.
    """
    event(f"left: {reason}")
    left[reason] += 1
