"""What certcheck says of a certificate that has been written, claim by claim, and what is trusted still."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from mcpn.certificates import certcheck, corecheck, furthercheck
from mcpn.certificates.core_entry import OBJECTIVES

if TYPE_CHECKING:
    from mcpn.certificates.writing import Certificate

SECONDS = 60.0
"""Time that certcheck gets where a command runs it."""
STILL_TRUSTED = (
    "still trusted: reader and templates, which make the net of the mission, and that a formula says what "
    "its text says"
)
BUT_OBJECTIVES = (
    "still trusted: the reader, the templates of activities and hardware (what those of objectives draw is "
    "checked by corecheck), and that a formula says what its text says"
)
"""What no claim of a certificate is free of (docs/certificates.md)."""
GAVE_UP = (certcheck.Malformed, certcheck.Limit, RecursionError, MemoryError)
"""What ends a checker without an answer."""
NONE_CHECKED = "no claim is checked by certcheck: reader, templates, kernel and engines are trusted"


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

    def of(self, key: str) -> str:
        """What is known of how a claim is known: ``checked``, ``refuted``, ``not checked`` or ``trusted``."""
        if key in self.found:
            how, why = self.found[key]
            further = any(key == claim["key"] for claim in self.certificate.further)
            by = "corecheck" if key == OBJECTIVES else "furthercheck" if further else "certcheck"
            return f"checked by {by}" if how == "proved" else f"{how} by {by}: {why}"
        _, why = self.certificate.trusted.get(key, ("", "no evidence is written for it"))
        return f"trusted, not checked by certcheck: {why}"

    @property
    def summary(self) -> str:
        """How many claims are checked, and what is trusted all the same."""
        checked, every = len(self.keys("proved")), len(self.found) + len(self.certificate.trusted)
        played = self.found.get(OBJECTIVES, ("",))[0] == "proved"
        still = BUT_OBJECTIVES if played else STILL_TRUSTED
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
    try:
        report = certcheck.checked(str(file), seconds=seconds)
    except GAVE_UP as error:
        report = [("not checked", claim["key"], _why(error)) for claim in certificate.claims]
    if certificate.further:
        report += _further(certificate, file, seconds)
    if certificate.core is not None:
        report.append(_played(file, seconds))
    return Verified(certificate, file, {key: (how, why) for how, key, why in report})


def _further(certificate: Certificate, file: Path, seconds: float) -> certcheck.Report:
    """What furthercheck says of the claims that it reads."""
    try:
        return furthercheck.checked(str(file), seconds=seconds)
    except GAVE_UP as error:
        return [("not checked", claim["key"], _why(error)) for claim in certificate.further]


def _played(file: Path, seconds: float) -> tuple[str, str, str]:
    """What corecheck says of the objectives of a certificate."""
    try:
        corecheck.checked(str(file), seconds)
    except certcheck.Refuted as error:
        return "refuted", OBJECTIVES, str(error)
    except GAVE_UP as error:
        return "not checked", OBJECTIVES, _why(error)
    return "proved", OBJECTIVES, ""


def _why(error: BaseException) -> str:
    return str(error) or "there is not enough memory"
