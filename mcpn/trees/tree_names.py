"""Names in a mission that is made of a tree: blocks, events, facts, and activities by where they run."""

from __future__ import annotations

import re
import unicodedata

from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
)

_RESERVED = {SUCCEED, FAIL, ABORT, "success", "failure"}
Lane = tuple[tuple[int, int], ...]
"""Where something runs: for each parallel block around it, its number and that of the branch."""


def together(one: Lane, other: Lane) -> bool:
    """Whether what runs in two lanes may run at the same time: they part at one parallel block."""
    for (block, branch), (another, beside) in zip(one, other, strict=False):
        if block != another:
            return False
        if branch != beside:
            return True
    return False


class TreeNames:
    """Gives out names, each once."""

    def __init__(self) -> None:
        self.taken: set[str] = set(_RESERVED)
        self.activities: dict[str, dict[str, list[Lane]]] = {}
        """By what is done, the activities that do it, each with the lanes in which it does."""

    def fresh(self, wish: str) -> str:
        """A name that is not taken, like the one that is wished for."""
        wish = _fitting(wish)
        name, count = wish, 1
        while name in self.taken:
            count += 1
            name = f"{wish}{count}"
        self.taken.add(name)
        return name

    def activity(self, wish: str, lane: Lane) -> str:
        """The activity for something that is done in a lane: no other lane that runs then has it."""
        doing = self.activities.setdefault(_fitting(wish), {})
        for name, lanes in doing.items():
            if not any(together(lane, other) for other in lanes):
                lanes.append(lane)
                return name
        name = self.fresh_activity(wish)
        doing[name] = [lane]
        return name

    def fresh_activity(self, wish: str) -> str:
        """A name for an activity, among all activities."""
        wish = _fitting(wish)
        used = {name for doing in self.activities.values() for name in doing}
        name, count = wish, 1
        while name in used:
            count += 1
            name = f"{wish}{count}"
        return name


def readable(text: str) -> str:
    """What of a text a name can hold: letters without accents, and digits; empty where that is too little."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    plain = plain.translate(_SPELT)
    kept = re.sub(r"[^A-Za-z0-9]", "", plain)
    return plain if 2 * len(kept) >= sum(c.isalnum() for c in plain) and kept else ""


_SPELT = str.maketrans(
    {"ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "Ae", "œ": "oe", "Œ": "Oe", "ł": "l", "Ł": "L"}
)
"""Letters that are no others with a mark."""


def _fitting(text: str) -> str:
    """A text as a name: letters, digits and ``_``, no digit first."""
    name = re.sub(r"[^A-Za-z0-9_]+", "_", readable(text)).strip("_")
    # A number behind _ is how copies of a block are named, so that it is joined to what is before it.
    name = re.sub(r"(?<!_)_++(?=\d++$)", "", name)
    return name if name and not name[0].isdigit() else f"n{name}"
