"""Claims on losses of hardware at the entry of each section of a mission."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes

MOST_PAIRS = 2_000
"""Pairs of hardware and sections up to which there is a claim on each; of more, on those that do harm."""


def claims_of_entries(causes: Causes) -> Iterator[Claim]:
    """What each loss alone leaves from the entry of each section on, as what the mission survives says."""
    hardware = causes.prospects.hardware
    every = len(hardware) * len(causes.survival) <= MOST_PAIRS
    for found in causes.survival:
        if found.section is None:
            continue
        for kind, level in (("loss_at_entry_defeats", found), ("loss_at_entry_endangers", found.safety)):
            if level is None:
                continue
            for name in hardware:
                harms = any(set(lost) <= {name} for lost in level.cut_sets)
                if harms or every:
                    yield Claim(kind, (name, found.section), harms, Assumes("declared", "others"))
