"""What the terminal says of a certificate: which claims have evidence, which are only trusted, and why."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

from mcpn.certificates.writing import Certificate
from mcpn.report.terminal import Terminal
from mcpn.sentences import shortened

MOST_TOLD = 4
"""Claims without evidence that a line names."""
TRUSTED = "Trusted are the net, drawn from the mission, and the formulas, read from their text."


def print_certificate(certificate: Certificate, file: Path | None) -> None:
    """Prints what a certificate holds, and how it is checked.

    Args:
        certificate: The certificate.
        file: Where it has been written.
    """
    terminal, claims = Terminal(), len(certificate.claims)
    terminal.print(f"certificate {file}: {claims} claims with evidence. {TRUSTED}")
    without = defaultdict[str, list[str]](list)
    for key, (_, why) in certificate.trusted.items():
        without[why].append(key)
    for why, keys in without.items():
        terminal.print(f"without evidence, trusted: {shortened(keys, MOST_TOLD)}: {why}", indent=2)
    terminal.print(f"check it: python -m mcpn.certificates.certcheck {file}", style="dim")
