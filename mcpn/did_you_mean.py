"""Hints at names that exist, where a mission names something that does not."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import chain, islice

MAX_HINTS = 10
"""How many unknown names are compared with the known ones: each comparison costs."""
MAX_LISTED = 10
"""How many known names are listed where none of them is near."""
MAX_COMPARED = 500
"""How many of the known names are searched for a near one."""
_OTHER_WORDS = {
    "actuator": "hardware",
    "default": "initial",
    "device": "hardware",
    "fallback": "alternative",
    "foreach": "each",
    "id": "name",
    "if": "when requires",
    "condition": "when requires",
    "max_retries": "retries",
    "mtbf": "failure_rate",
    "mttr": "repair_rate",
    "needs": "consumes",
    "next": "success",
    "on_failure": "failure",
    "on_success": "success",
    "outputs": "produces",
    "provides": "produces",
    "resources": "consumes",
    "sensor": "hardware",
    "step": "objective",
    "target": "goto",
    "task": "objective activity",
    "to": "goto",
    "uses": "consumes",
    "value": "initial",
    "variable": "fact",
}
"""Words of other languages, each with ours: near in meaning, and not in letters."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A hint at the known name that is nearest in meaning or in letters, if there is one near."""
    from difflib import get_close_matches

    among = sorted(islice(known, MAX_COMPARED))
    meant = [word for word in _OTHER_WORDS.get(name.lower(), "").split() if word in among]
    near = meant or get_close_matches(name, among, n=1)
    return f" (did you mean {near[0]}?)" if near else ""


class Hints:
    """Hints of one mission, as long as looking for them costs little."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, int], tuple[Iterable[str], str]] = {}

    def near(self, name: str, known: Iterable[str], *others: str) -> str:
        """A near name among the others and the known ones."""
        key = name, id(known)  # the value holds `known`, so that its id is not given to another object
        if key not in self._found and len(self._found) < MAX_HINTS:
            self._found[key] = known, did_you_mean(name, chain(others, known))
        return self._found[key][1] if key in self._found else ""

    def known(self, name: str, known: Collection[str]) -> str:
        """A near name, else all that there are if they are few."""
        near = self.near(name, known)
        if near or len(known) > MAX_LISTED:
            return near
        return f" (expected one of {', '.join(known)})" if known else " (none is declared)"
