"""The entry ``sections.json`` of a certificate: claims that the types of many sections prove."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable
from typing import Any

from mcpn.answers.claims import Claim
from mcpn.certificates import certcheck
from mcpn.certificates.entries import Uncertified, entry
from mcpn.certificates.sections import sectioncheck

SECONDS = 300.0
"""Time to play the types of sections, and to ask them all claims."""
OF_THE_NET = "it is of the net, which is too large for a certificate"
MOST_BYTES = certcheck.MOST_BYTES // 2
"""Bytes of the claims; certcheck reads twice as much at most."""
FULL = "the certificate has as many claims as a checker reads"
NO_TYPE = "no type of section proves it"


def _budget() -> sectioncheck.Budget:
    return sectioncheck.Budget(sectioncheck.MOST_STATES, time.monotonic() + SECONDS)


def claims_by_sections(
    core: dict[str, Any], claims: Iterable[Claim], stated: Callable[[Claim], tuple[str, dict[str, Any]]]
) -> tuple[list[dict[str, Any]], dict[str, tuple[str, str]]]:
    """The claims that sections prove, and by key the sentences of all others, with why they do not.

    Args:
        core: The entry ``core.json``.
        claims: What is said of the mission.
        stated: The kind of a claim in the certificate, and what it states; raises Uncertified.

    Raises:
        certcheck.Limit: Its sections are not apart, or have too many states.
    """
    sections = sectioncheck.PlayedSections(core, _budget())
    left = MOST_BYTES
    proved, trusted = dict[str, dict[str, Any]](), dict[str, tuple[str, str]]()
    for claim in claims:
        if claim.key in proved or claim.key in trusted:
            continue
        trusted[claim.key] = (
            claim.sentence,
            OF_THE_NET if claim.of.verdict in ("safe", "confluent") else NO_TYPE,
        )
        if claim.holds is None:
            continue
        try:
            kind, said = stated(claim)
            made = entry(claim.key, kind, claim.subject, claim.holds, claim.sentence, said, {})
            left -= len(json.dumps(made))
            certcheck.need(left >= 0, FULL)
            sectioncheck.judge(sections, made)
        except (certcheck.Refuted, certcheck.Limit, Uncertified) as why:
            trusted[claim.key] = claim.sentence, str(why)
        else:
            proved[claim.key] = made
            del trusted[claim.key]
    return [*proved.values()], trusted
