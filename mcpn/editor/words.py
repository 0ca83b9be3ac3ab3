"""What may stand at a place inside a value: names, words of formulas, values of facts, routes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from mcpn.editor.symbols import Symbol
from mcpn.mission.language.references import VALUED, WORDS
from mcpn.mission.robot import BOOLEAN_VALUES

_IN_NAME = re.compile(r"\b([a-z]+)\(\s*\"?([\w.]*)\Z")
_IN_VALUE = re.compile(r"(?:\b([a-z]++)\(\s*+)?\"?(?<![\w.])([A-Za-z_][\w.]*+)\"?\s*+\)?\s*+=\s*+\w*+\Z")
_OPERATORS = {
    "AG": "in every state that is reached",
    "AF": "some day, on every run",
    "EF": "in some state that can be reached",
    "EG": "along some run, always",
    "G": "always, on a run",
    "F": "some day, on a run",
    "X": "after the next event",
    "U": "until",
    "W": "until, or for ever",
}
_ENDS = {"success": "the mission has succeeded", "failure": "it has failed", "abort": "it has aborted"}
_MEANINGS = {
    "objective": "the objective runs",
    "pending": "it waits for an activity of another branch",
    "done": "it has succeeded before",
    "block": "an objective inside the block runs",
    "activity": "the activity runs",
    "alternative": "the activity runs so: alternative(activity)=name",
    "waiting": "the activity waits for a resource",
    "refused": "no alternative of the activity is possible",
    "oos": "out of service, or crashed",
    "available": "in service, or produced",
    "event": "the event may happen",
    "happens": "the event happens next",
    "fact": "the fact has a value: fact(name)=value",
}


class Offer(NamedTuple):
    """What may stand at a place.

    Args:
        text: The word.
        meaning: What it means.
        names: Whether it names something of the mission.
        behind: What follows it, where more must.
    """

    text: str
    meaning: str
    names: bool = False
    behind: str = ""


def words(refers: str, before: str, scope: str, symbols: list[Symbol]) -> Iterator[Offer]:
    """The words that may stand at a place in a formula, a condition, or a list of names.

    Args:
        refers: What the datatype of the attribute refers to.
        before: The value up to the place.
        scope: The protocol that it stands in.
        symbols: Of all files of the mission.
    """
    declared = _Declared(symbols)
    if refers in ("formula", "condition") and (inside := _IN_NAME.search(before)):
        if inside[1] in WORDS and (refers == "formula" or inside[1] == "done"):
            yield from declared.named(WORDS[inside[1]], scope, inside[2])
    elif refers == "formula" and (value := _IN_VALUE.search(before)) and value[1] in VALUED:
        yield from declared.values(VALUED[value[1]], value[2])
    elif refers == "condition" and (value := _IN_VALUE.search(before)):
        yield from declared.values("value", value[2])
    elif refers == "formula":
        yield from (Offer(word, meaning, behind="($1)") for word, meaning in _MEANINGS.items())
        yield from (Offer(word, meaning) for word, meaning in (_OPERATORS | _ENDS).items())
    elif refers == "condition":
        yield from declared.named("fact", "", "")
        yield Offer("done", _MEANINGS["done"], behind="($1)")
    elif refers:
        qualified = re.search(r"(?<![\w.])[\w.]*+\Z", before)
        yield from declared.named(refers, scope, qualified[0] if qualified else "")


class _Declared:
    """The names that are declared, by kind."""

    def __init__(self, symbols: list[Symbol]) -> None:
        self.symbols = [symbol for symbol in symbols if symbol.declares]

    def named(self, kind: str, scope: str, begun: str) -> Iterator[Offer]:
        """Names of a kind; of blocks those of the text, or those in the use that qualifies what is begun."""
        match kind:
            case "objective" | "block path":
                around = begun.split(".")[:-1]
                for name in around:
                    block = next((s for s in self._of("block", scope) if s.name == name), None)
                    if block is not None and block.element.tag == "use":
                        scope = block.element.texts.get("protocol", "")
                for symbol in self._of("block", scope):
                    if kind == "block path" or "activities" in symbol.element.texts:
                        yield Offer(".".join([*around, symbol.name]), _description(symbol), True)
            case "loss":
                yield from self.named("resource", "", "")
                for symbol in self.symbols:
                    if (
                        symbol.kind in ("activity", "alternative")
                        and symbol.element.texts.get("faulty") == "true"
                    ):
                        of = f"{symbol.scope}." if symbol.kind == "alternative" else ""
                        yield Offer(of + symbol.name, _description(symbol), True)
            case "happening":
                yield from self.named("event", "", "")
                yield from (
                    Offer(f"{word.text}_EV_OOS", f"{word.text} is lost", True)
                    for word in self.named("loss", "", "")
                )
                for word in self.named("objective", scope, begun.removeprefix("OBJ_")):
                    yield Offer(f"OBJ_{word.text}_EV_OK", f"{word.text} succeeds", True)
                    yield Offer(f"OBJ_{word.text}_EV_FAIL", f"{word.text} fails", True)
            case _:
                found = self._of(kind, scope if kind in ("block", "alternative") else "")
                for symbol in {s.name: s for s in found}.values():
                    yield Offer(symbol.name, _description(symbol), True)

    def values(self, kind: str, of: str) -> Iterator[Offer]:
        """Alternatives of an activity, or values of a fact."""
        if kind == "alternative":
            ways = [s.name for s in self._of("alternative", of)]
            yield from (Offer(way, f"a way of {of}", True) for way in ways or [of])
        for symbol in self._of("fact", "") if kind == "value" else ():
            if symbol.name == of:
                values = symbol.element.texts.get("values", "").split() or BOOLEAN_VALUES
                yield from (Offer(value, f"a value of {of}") for value in values)

    def _of(self, kind: str, scope: str) -> Iterator[Symbol]:
        return (s for s in self.symbols if s.kind == kind and (s.scope or "") == scope)


def _description(symbol: Symbol) -> str:
    return symbol.element.texts.get("description", "")
