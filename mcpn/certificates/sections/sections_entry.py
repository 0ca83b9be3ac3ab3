"""The entry ``sections.json`` of a certificate: claims that the types of many sections prove."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

from mcpn.answers.claims import Claim
from mcpn.certificates import certcheck
from mcpn.certificates.entries import entry
from mcpn.certificates.sections import sectioncheck

SECONDS = 60.0
"""Time to play the types of sections."""
OF_THE_NET = "it is of the net, which is too large for a certificate"
NO_TYPE = "no type of section proves it"


def _budget() -> sectioncheck.Budget:
    return sectioncheck.Budget(sectioncheck.MOST_STATES, time.monotonic() + SECONDS)


def claims_by_sections(
    core: dict[str, Any], claims: Iterable[Claim]
) -> tuple[list[dict[str, Any]], dict[str, tuple[str, str]]]:
    """The claims that sections prove, and by key the sentences of all others, with why they do not.

    Args:
        core: The entry ``core.json``.
        claims: What is said of the mission.

    Raises:
        certcheck.Limit: Its sections are not apart, or have too many states.
    """
    sections = sectioncheck.PlayedSections(core, _budget())
    proved, trusted = dict[str, dict[str, Any]](), dict[str, tuple[str, str]]()
    for claim in claims:
        if claim.key in proved or claim.key in trusted:
            continue
        trusted[claim.key] = (
            claim.sentence,
            OF_THE_NET if claim.of.verdict in ("safe", "confluent") else NO_TYPE,
        )
        if claim.kind in sectioncheck.KINDS and claim.holds is not None and "happens(" not in claim.formula:
            made = entry(claim.key, claim.kind, claim.subject, claim.holds, claim.sentence, {}, {})
            try:
                sectioncheck.judge(sections, made)
            except certcheck.Refuted as why:
                trusted[claim.key] = claim.sentence, str(why)
            else:
                proved[claim.key] = made
                del trusted[claim.key]
    return [*proved.values()], trusted
