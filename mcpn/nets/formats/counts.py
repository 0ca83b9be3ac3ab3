"""Numbers in files of nets: of tokens, exact and bounded because files are untrusted, and ranks."""

from __future__ import annotations

from mcpn.errors import InputError
from mcpn.nets.petri import PetriNet

MAX_DIGITS = 18
MAX_COUNT = 10**MAX_DIGITS - 1
"""The most tokens that a file may put in a place, or an arc may move."""


def read_count(text: str) -> int | None:
    """The number that a text says in decimal digits, or ``None`` where it says none or too large a one.

    >>> read_count("12"), read_count("-1"), read_count("1" + "0" * 18)
    (12, None, None)
    """
    return int(text) if text.isascii() and text.isdigit() and len(text) <= MAX_DIGITS else None


def rank_without_use(event: object | None, *, priorities: bool) -> str:
    """Why a rank that a file gives a transition says nothing; empty where it says something.

    >>> rank_without_use(None, priorities=True)
    ''
    """
    if event is not None:
        return "expected none: events come after all ranks"
    return "" if priorities else "expected none: the net has no priorities"


def check_counts(net: PetriNet, digits: int = MAX_DIGITS) -> None:
    """Sees to it that what is written can be read back.

    Args:
        net: What is to be written.
        digits: The most digits of a number in the format.

    Raises:
        InputError: A place holds, or an arc moves, more tokens than files may say.
    """
    most, said = 10**digits - 1, f"files say whole numbers of at most {digits} digits"
    for place in net.places:
        if not 0 <= place.initial <= most:
            raise InputError.at(None, f"place {place.name} holds {_shown(place.initial)} tokens, {said}")
    for t in net.transitions:
        for p, weight in (*t.consume, *t.produce, *t.read):
            if not 1 <= weight <= most:
                between = f"transition {t.name} and place {net.places[p].name}"
                raise InputError.at(None, f"weight {_shown(weight)} between {between}, {said}")


def _shown(number: int) -> str:
    return str(number) if abs(number) < 10**60 else "too many"
