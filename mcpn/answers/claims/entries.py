"""Claims on losses of hardware at the entry of each section of a mission."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.found import MOST_PAIRS

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes

LEFT = Assumes("declared", "others")


def claims_of_entries(causes: Causes) -> Iterator[Claim]:
    """What each loss alone leaves from the entry of each section on, as what the mission survives says."""
    hardware = causes.prospects.hardware
    sections = [found for found in causes.survival if found.section is not None]
    every = len(hardware) * len(sections) <= MOST_PAIRS
    goals = [("loss_at_entry_defeats", "loss_at_entries_spares_success", [(f.section, f) for f in sections])]
    safe = [(f.section, f.safety) for f in sections if f.safety is not None]
    goals += [("loss_at_entry_endangers", "loss_at_entries_spares_safety", safe)] * bool(safe)
    for kind, others, entries in goals:
        for name in hardware:
            harmed = {section for section, level in entries if any(set(s) <= {name} for s in level.cut_sets)}
            for section, _ in entries:
                if every or section in harmed:
                    yield Claim(kind, (name, str(section)), section in harmed, LEFT)
            if not every and len(harmed) < len(entries):
                yield Claim(others, (name,), True, LEFT)
