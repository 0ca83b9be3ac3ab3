"""A claim as a certificate holds it, one that is only trusted, and one that its evidence does not support."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeAlias

from mcpn.errors import McpnError

Claimed: TypeAlias = dict[str, Any]
"""A claim with its statement and evidence."""


class Trusted(NamedTuple):
    """A claim without evidence: its key, its sentence, and why there is none."""

    key: str
    sentence: str
    why: str


def entry(
    key: str,
    kind: str,
    subject: tuple[str, ...],
    holds: bool,
    sentence: str,
    statement: dict[str, Any],
    shown: dict[str, Any],
) -> Claimed:
    """A claim as the certificate holds it.

    Args:
        key: What it is known by.
        kind: What proves it.
        subject: Of what it speaks, for people.
        holds: Whether it holds.
        sentence: It in words.
        statement: What is stated.
        shown: The evidence.
    """
    return {
        "key": key,
        "kind": kind,
        "subject": list(subject),
        "holds": holds,
        "sentence": sentence,
        "statement": statement,
        "evidence": shown,
    }


class Uncertified(Exception):
    """A claim for which there is no evidence that a checker knows."""


class EvidenceError(McpnError):
    """What mcpn has answered and the evidence that it finds for it disagree: a fault of mcpn.

    Args:
        sentence: The claim.
        why: What of the evidence is amiss.
    """

    def __init__(self, sentence: str, why: str) -> None:
        super().__init__(
            "no certificate, and the answer may be wrong: mcpn's own evidence does not support its claim "
            f'"{sentence}" ({why}); this is a fault of mcpn, please report it with the mission'
        )


@contextmanager
def supported(sentence: str) -> Iterator[None]:
    """While evidence is sought that exists if a claim is right.

    Raises:
        EvidenceError: There is none: a run, a state or a number that the claim implies is not found.
    """
    try:
        yield
    except (AssertionError, LookupError, StopIteration) as error:
        raise EvidenceError(sentence, str(error) or type(error).__name__) from error
