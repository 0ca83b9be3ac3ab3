"""What sentences for people are made of, whatever they are about."""

from __future__ import annotations

from collections.abc import Sequence


def enumeration(names: Sequence[str]) -> str:
    """Names as a list in a sentence: ``A``, ``A and B``, ``A, B and C``.

    >>> enumeration(["A", "B", "C"])
    'A, B and C'
    """
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
