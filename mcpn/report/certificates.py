"""What the terminal says of a certificate: by claim whether certcheck has checked it, or what is trusted."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from typing import TYPE_CHECKING

from mcpn.report.terminal import Terminal
from mcpn.sentences import shortened

if TYPE_CHECKING:
    from mcpn.certificates.checked_claims import Verified

NONE_CHECKED = "no claim is checked by certcheck: reader, templates, kernel and engines are trusted"
"""What is trusted of a check without a certificate."""
MOST_TOLD = 4
"""Claims that a line names one by one."""


def print_unchecked() -> None:
    """Prints what is trusted of a check without a certificate."""
    Terminal().print(f"{NONE_CHECKED} (--certificate OUT)", style="dim")


def print_certificate(verified: Verified) -> None:
    """Prints what certcheck says of each claim of a certificate, and what is only trusted.

    Args:
        verified: The certificate as it has been checked.
    """
    terminal = Terminal()
    terminal.print(f"certificate {verified.file}: {verified.summary}")
    terminal.print(f"checked: {_by_kind(verified.keys('proved'))}", indent=2)
    reasons = defaultdict[tuple[str, str], list[str]](list)
    for how in ("refuted", "not checked"):
        for key in verified.keys(how):
            reasons[how, verified.found[key][1]].append(key)
    for key, (_, why) in verified.certificate.trusted.items():
        reasons["trusted, without evidence", why].append(key)
    for (how, why), keys in reasons.items():
        style = "red" if how == "refuted" else None
        terminal.print(f"{how}: {shortened(keys, MOST_TOLD)}: {why}", indent=2, style=style)
    commands = (f"python -m mcpn.certificates.{program} {verified.file}" for program in verified.programs)
    terminal.print(f"check it elsewhere: {'; '.join(commands)}", style="dim")


def _by_kind(keys: Iterable[str]) -> str:
    """Claims by their kinds, each with how many there are of it."""
    kinds = Counter(key.partition(":")[0] for key in keys)
    return (
        ", ".join(kind if number == 1 else f"{kind} ({number})" for kind, number in kinds.items()) or "none"
    )
