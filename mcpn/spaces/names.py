"""What names in formulas stand for: places and transitions of a net."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import islice
from typing import NoReturn

from mcpn.errors import InputError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import Formula

MAX_LISTED = 20
"""How many known names an error lists where none of them is near."""

WORDS = (
    "objective",
    "block",
    "pending",
    "activity",
    "alternative",
    "waiting",
    "refused",
    "oos",
    "available",
    "fact",
    "done",
    "event",
    "happens",
)
"""Words about an element, ``word(name)``: reserved in all formulas, meant where names know of elements."""
ENDINGS = ("success", "failure", "abort")
"""Words that stand alone."""
PROGRESS = "progress"
"""The fairness constraint that is asked by name."""


class Names:
    """Looks names up in a net; an unknown one is an InputError that lists what is near.

    What a net means beyond its places is for a subclass to know: here words about elements are errors.

    Args:
        net: Names places and transitions.

    Attributes:
        said: By formula the words that were looked up for it.
        endings: Those of :data:`ENDINGS` that are no names of places.
    """

    endings: tuple[str, ...] = ENDINGS[:2]

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self.said: dict[Formula, tuple[str, ...]] = {}

    def place(self, name: str) -> int:
        """The index of a place."""
        return self.net.place_index[known(name, self.net.place_index, "place", self._also_places)]

    _also_places: Sequence[str] = ()
    """What else may be written where a place is expected."""

    def transition(self, name: str) -> int:
        """The index of a transition."""
        return self.net.transition_index[known(name, self.net.transition_index, "transition")]

    def word(self, *said: str) -> Formula:
        """What a word about an element means.

        Args:
            said: One of :data:`WORDS` and the element's name, for ``alternative(activity)=value``,
                ``waiting(activity)=value`` and ``fact(name)=value`` the value too; or one of
                :data:`ENDINGS` alone.
        """
        raise InputError.at(None, f"{said[0]} is a word of missions, and this net is of none")


def known(name: str, names: Collection[str], what: str, also: Sequence[str] = ()) -> str:
    """The name, if it exists; else an error; arguments as of :func:`unknown`."""
    return name if name in names else unknown(name, names, what, also)


def unknown(name: str, names: Collection[str], what: str, also: Sequence[str] = ()) -> NoReturn:
    """Says which names are near one that does not exist.

    Args:
        name: The name.
        names: Those that there are.
        what: What they name.
        also: What else may be written there, which is listed first, as one name for all rounds and tries.
    """
    from difflib import get_close_matches

    near = get_close_matches(name, also, n=3) or get_close_matches(name, names, n=3)
    names = list(dict.fromkeys([*also, *names]))
    if not near:  # the use of a protocol that qualifies a name may have been left out, or be another
        by_last = {known.rpartition(".")[2]: known for known in names}
        near = [by_last[last] for last in get_close_matches(name.rpartition(".")[2], by_last, n=3)]
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    if not near and names:
        shown = ", ".join(islice(names, MAX_LISTED))
        hint = f"; expected one of {shown}{', ...' if len(names) > MAX_LISTED else ''}"
    raise InputError.at(None, f"no {what} is named {name}{hint}")
