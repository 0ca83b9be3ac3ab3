"""What names in formulas stand for: places and transitions of a net."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
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
        """The index of the place that has a name: its id in the net, or its label if it is the only one."""
        net = self.net
        return _one(name, net.place_index, net.place_labels, "place", self._also_places)

    _also_places: Sequence[str] = ()
    """What else may be written where a place is expected."""

    def transition(self, name: str) -> int:
        """The index of the transition that has a name, as of :meth:`place`."""
        return _one(name, self.net.transition_index, self.net.transition_labels, "transition")

    def place_of_file(self, name: str) -> int:
        """As :meth:`place`, where files mean ids: one that is also the label of another is no doubt."""
        return self.net.place_index[name] if name in self.net.place_index else self.place(name)

    def transition_of_file(self, name: str) -> int:
        """As :meth:`transition`, where files mean ids."""
        index = self.net.transition_index
        return index[name] if name in index else self.transition(name)

    def word(self, *said: str) -> Formula:
        """What a word about an element means.

        Args:
            said: One of :data:`WORDS` and the element's name, for ``alternative(activity)=value``,
                ``waiting(activity)=value`` and ``fact(name)=value`` the value too; or one of
                :data:`ENDINGS` alone.
        """
        raise InputError.at(None, f"{said[0]} is a word of missions, and this net is of none")


def _one(
    name: str,
    ids: Mapping[str, int],
    labels: Mapping[str, Sequence[int]],
    what: str,
    also: Sequence[str] = (),
) -> int:
    """The only node with an id or a label; else an error."""
    meant = list(dict.fromkeys([*([ids[name]] if name in ids else []), *labels.get(name, ())]))
    if len(meant) == 1:
        return meant[0]
    if not meant:
        unknown(name, {**ids, **labels}, what, also)
    names = list(ids)
    shown = [names[each] for each in meant]
    them = " and ".join(shown[:3]) + (f" and {len(shown) - 3} more" if len(shown) > 3 else "")
    raise InputError.at(
        None, f"{name} may mean the {what}s {them}, expected an id that is not a label of another"
    )


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
