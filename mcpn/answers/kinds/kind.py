"""What a kind of claim is: its formula as a template, its three sentences, its evidence, who shows it."""

from __future__ import annotations

from typing import NamedTuple

TERMINAL, PAGE, FMECA, JSON = "terminal", "page", "FMECA", "JSON"
EVERYWHERE = (TERMINAL, PAGE, JSON)
SAFE_ENDS = "where what should make safe, and fails, has copies of one name"
"""Why there is no formula on safe ends."""
NOT_PLAIN = "where hardware fails by common causes, or activities crash"
"""Why there is no formula on some losses at one moment."""
AT_ENTRY = f"{NOT_PLAIN}, where an event ends a section and begins it again, and of blocks that pause"
"""Why there is no formula on some entries of sections."""


class ClaimKind(NamedTuple):
    """A kind of claim.

    Args:
        name: A stable name.
        formula: A template: it holds where the claim does. Empty where no formula says it.
        holds: What is so where it holds; ``{0}``, ``{1}``: the names of the subject, in their order;
            ``{given}``: what is supposed.
        fails: What is so where it does not.
        unknown: What is said where that is not known.
        evidence: What shows it.
        shown: Where it is shown.
        why: Why there is no formula.
        good: Whether a mission is better where it holds; ``None`` of what is neither good nor bad.
        verdict: The verdict that it is, if it is one.
        several: How several names stand in the place of one.
        joint: What stands between them.
        cell: What a cell of the FMECA table says of it, whose row names the hardware and the objective.
    """

    name: str
    formula: str
    holds: str
    fails: str
    unknown: str
    evidence: str
    shown: tuple[str, ...] = (JSON,)
    why: str = ""
    good: bool | None = None
    verdict: str = ""
    several: str = "any one of {}"
    joint: str = ", "
    cell: str = ""

    @property
    def needs_states(self) -> bool:
        """Whether its formula is made from the mission's states or routes, and not from its ends alone."""
        return "{" in self.formula.replace("{ends}", "")

    @property
    def sentences(self) -> tuple[str, str, str]:
        """Where it holds, fails, is not known; without their full stop."""
        return self.holds, self.fails, self.unknown
