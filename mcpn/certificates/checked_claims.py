"""What certcheck says of a certificate that has been written, claim by claim, and what is trusted still."""

from __future__ import annotations

import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from mcpn.certificates import certcheck, corecheck, diagcheck, furthercheck
from mcpn.certificates.corecheck import NET
from mcpn.certificates.sections import sectioncheck

if TYPE_CHECKING:
    from mcpn.certificates.writing import Certificate

SECONDS = 60.0
"""Time that certcheck gets where a command runs it."""
MOST = 2_000_000
"""Markings that it may keep."""
STILL_TRUSTED = (
    "still trusted: reader and templates, which make the net of the mission, and that a formula says what "
    "its text says"
)
BUT_NET = (
    "still trusted: the reader (that the net does what the mission says is checked by corecheck), and that a "
    "formula says what its text says"
)
"""What no claim of a certificate is free of (docs/certificates.md)."""
BY_SECTIONS = "still trusted: the reader, which makes the core mission that the claims are of"
"""The same where there is no net in it."""
GAVE_UP = (certcheck.Malformed, certcheck.Limit, RecursionError, MemoryError)
"""What ends a checker without an answer."""


class EntryChecker(Protocol):
    """A program that checks an entry of its own."""

    def __call__(self, path: str, *, seconds: float) -> certcheck.Report:
        """What becomes of each claim."""


class Verified(NamedTuple):
    """A certificate, and what the checker says of it.

    Args:
        certificate: The certificate.
        file: Where it is.
        found: By key of each claim with evidence: ``proved``, ``refuted`` or ``not checked``, and why.
    """

    certificate: Certificate
    file: Path
    found: dict[str, tuple[str, str]]

    def keys(self, how: str) -> list[str]:
        """The claims of which certcheck says so."""
        return [key for key, (said, _) in self.found.items() if said == how]

    @property
    def programs(self) -> list[str]:
        """The programs that check it, each what it reads."""
        if self.certificate.net is None:
            return ["sections.sectioncheck"]
        if self.certificate.diagrams is not None:
            return ["diagcheck"]
        further = ["furthercheck"] if self.certificate.further else []
        return ["certcheck", *further, "corecheck"]

    def of(self, key: str) -> str:
        """What is known of how a claim is known: ``checked``, ``refuted``, ``not checked`` or ``trusted``."""
        if key in self.found:
            how, why = self.found[key]
            further = any(key == claim["key"] for claim in self.certificate.further)
            by = "corecheck" if key == NET else "furthercheck" if further else "certcheck"
            by = by if self.programs[0] == "certcheck" else self.programs[0].rpartition(".")[2]
            return f"checked by {by}" if how == "proved" else f"{how} by {by}: {why}"
        _, why = self.certificate.trusted.get(key, ("", "no evidence is written for it"))
        return f"trusted, without evidence: {why}"

    @property
    def summary(self) -> str:
        """How many claims are checked, and what is trusted all the same."""
        checked, every = len(self.keys("proved")), len(self.found) + len(self.certificate.trusted)
        still = BUT_NET if self.found.get(NET, ("",))[0] == "proved" else STILL_TRUSTED
        still = BY_SECTIONS if self.certificate.net is None else still
        return f"{checked} of {every} claims are checked; {still}"

    @property
    def said(self) -> dict[str, Any]:
        """For programs: by claim why it is only trusted, and what certcheck says of each other one."""
        checked = {key: how if how == "proved" else f"{how}: {why}" for key, (how, why) in self.found.items()}
        return {**self.certificate.said, "checked": checked}


def verified(certificate: Certificate, file: Path, seconds: float = SECONDS) -> Verified:
    """Has certcheck check a certificate that has been written.

    Args:
        certificate: The certificate.
        file: Where it has been written: this is what is read.
        seconds: After which time what is left is not checked.
    """
    if certificate.net is None:
        return Verified(certificate, file, _by(sectioncheck.checked, certificate.claims, file, seconds))
    if certificate.diagrams is not None:
        claims = certificate.diagrams["claims"]
        return Verified(certificate, file, _by(diagcheck.checked, claims, file, seconds))
    until, report = time.monotonic() + seconds, certcheck.Report()
    try:
        entries, net, claims = certcheck.read(str(file))
        listing = cache(lambda: certcheck.Listing(net, MOST, until))
        report += certcheck.judged(listing, claims)
        if certificate.further:
            report += furthercheck.judged(listing, entries)
        report += corecheck.played(listing, entries)
    except GAVE_UP as error:
        known = {key for _, key, _ in report}
        every = [*certificate.claims, *certificate.further]
        keys = [*(claim["key"] for claim in every), NET]
        report += [("not checked", key, gave_up(error)) for key in keys if key not in known]
    return Verified(certificate, file, {key: (how, why) for how, key, why in report})


def _by(
    checker: EntryChecker, claims: Iterable[dict[str, Any]], file: Path, seconds: float
) -> dict[str, tuple[str, str]]:
    """What the checker of an entry of its own says of claims that no list of states proves."""
    try:
        report = checker(str(file), seconds=seconds)
    except GAVE_UP as error:
        report = [("not checked", claim["key"], gave_up(error)) for claim in claims]
    return {key: (how, why) for how, key, why in report}


def gave_up(error: BaseException) -> str:
    """Why a checker gave up."""
    return str(error) or "there is not enough memory"
