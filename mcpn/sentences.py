"""What sentences for people are made of, whatever they are about."""

from __future__ import annotations

from collections.abc import Sequence


def enumeration(names: Sequence[str]) -> str:
    """Names as a list in a sentence: ``A``, ``A and B``, ``A, B and C``.

    >>> enumeration(["A", "B", "C"])
    'A, B and C'
    """
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def counted(number: int, what: str) -> str:
    """So many of something, as ``1 place`` or ``2 places``.

    >>> counted(1, "place"), counted(2, "place")
    ('1 place', '2 places')
    """
    return f"{number} {what}{'s' * (number != 1)}"


def ordinal(number: int) -> str:
    """A number as it counts times.

    >>> [ordinal(number) for number in (1, 3, 11, 22)]
    ['first', 'third', '11th', '22nd']
    """
    if number <= 3:
        return ("first", "second", "third")[number - 1]
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def quoted(text: str, most: int = 80) -> str:
    """A text of a file in quotes, of a long one the beginning and how long it is.

    >>> quoted("3 m")
    "'3 m'"
    >>> quoted("-" * 100, 5)
    "'-----' ... (100 characters)"
    """
    return repr(text) if len(text) <= most else f"{text[:most]!r} ... ({len(text)} characters)"


def shortened(names: Sequence[str], most: int = 3) -> str:
    """The first few names of a list, and how many more there are.

    >>> shortened(["A", "B", "C", "D", "E"])
    'A, B, C and 2 more'
    """
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"
