"""What sentences for people are made of, whatever they are about."""

from __future__ import annotations

from collections.abc import Sequence


def enumeration(names: Sequence[str]) -> str:
    """Names as a list in a sentence: ``A``, ``A and B``, ``A, B and C``.

    >>> enumeration(["A", "B", "C"])
    'A, B and C'
    """
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def shortened(names: Sequence[str], most: int = 3) -> str:
    """The first few names of a list, and how many more there are.

    >>> shortened(["A", "B", "C", "D", "E"])
    'A, B, C and 2 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"
