"""A claim as a certificate holds it, and one that is only trusted."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

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
