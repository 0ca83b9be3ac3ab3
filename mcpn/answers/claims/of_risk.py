"""Claims on how probable a mission's ends are, what each resource is worth, and which numbers are equal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Claim

if TYPE_CHECKING:
    from mcpn.answers.causes.risk import Risk

ROUNDING = 1e-12
"""Differences of probabilities up to which they are equal."""


def claims_of_risk(risk: Risk) -> Iterator[Claim]:
    """The claims on the numbers of a mission: its ends, then the importance of its hardware."""
    for end, chance in (("success", risk.success), ("abort", risk.abort), ("failure", risk.failure)):
        if chance is not None:
            yield Claim("chance", (end,), True, refers_to=(near_one(chance),))
    for kind, found in (("importance", risk.importance), ("safe_importance", risk.safety_importance or {})):
        for hardware, worth in sorted(found.items(), key=lambda pair: -pair[1]):
            number = worth if abs(worth) > ROUNDING else 0.0
            yield Claim(kind, (hardware,), True, refers_to=(f"{number:.6g}",))
    for event in risk.unrated:
        yield Claim("unrated", (event,), True)


def near_one(chance: float) -> str:
    """A probability; one that only rounding would make certain says by how much it is not.

    >>> near_one(0.25), near_one(1 - 1e-9)
    ('0.25', '1 - 1e-09')
    """
    said = f"{chance:.6g}"
    return f"1 - {1 - chance:.3g}" if said == "1" and chance < 1 else said
