"""Names in the files of a mission: where each is declared and used, what it means, and where it may stand.

What names in formulas and conditions mean is known once all declarations are. From them follows what may
stand at a place inside a value: names, words of formulas, values of facts, routes.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

from mcpn.editor.scan import ScannedElement
from mcpn.mission.language.forms import Field, form_of, language
from mcpn.mission.language.references import VALUED, WORDS, happening, reason_in, references
from mcpn.mission.model import Protocol, Use
from mcpn.mission.robot import BOOLEAN_VALUES, Activity, Element


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name in its place.

    Args:
        kind: What it names: ``resource``, ``activity``, ``block``, ``protocol``, ``event``, ``alternative``,
            ``fact``, ``reason``. As it is read, before it is known what is declared, also what
            :func:`mcpn.mission.language.references.references` says of formulas and conditions.
        scope: Where it is unique: the name of the protocol of a block, the activity of an alternative; empty
            where that is the mission. ``None`` where several protocols have what it may name.
        name: The name.
        file: The file.
        place: Where it begins in its element.
        declares: Whether it is declared here.
        element: The element that says it.
    """

    kind: str
    scope: str | None
    name: str
    file: str
    place: int
    declares: bool
    element: ScannedElement

    @property
    def begin(self) -> int:
        """Where it begins in its text."""
        return self.element.begin + self.place

    @property
    def end(self) -> int:
        """Behind its last character."""
        return self.begin + len(self.name)

    def means(self, other: Symbol) -> bool:
        """Whether another one names the same."""
        same = self.kind == other.kind and self.name == other.name
        return same and (self.scope == other.scope or None in (self.scope, other.scope))


def symbols(file: str, elements: Iterable[ScannedElement]) -> list[Symbol]:
    """The names in the elements of a file, declared and used, in their order; elements keep them."""
    found = list[Symbol]()
    for element in elements:
        if element.names is None:
            element.names = list(_of(file, element))
        found += element.names
    return found


def attribute_of(element: ScannedElement, name: str) -> Field | None:
    """What the language knows of an attribute of an element; ``None`` for one that it has not."""
    tag = language().get(element.tag)
    return (
        None if tag is None else _attributes(element.tag, tag.forms.index(tag.form(element.texts))).get(name)
    )


@cache
def _attributes(tag: str, number: int) -> dict[str, Field]:
    """Attributes of an element that is read as one of its classes, and those that others of its name have."""
    known = language()[tag]
    return {**known.attributes, **{a.tag: a for a in form_of(known.forms[number]).attributes}}


_OF_TEXTS = ("block", "objective", "block path", "happening")
"""Kinds of names that are looked for in the text of a protocol first."""


def scope_of(kind: str, element: ScannedElement) -> str:
    """Where a name of an element is unique."""
    around = {"alternative": (Activity.TAG,)}.get(kind, (Protocol.TAG,) if kind in _OF_TEXTS else ())
    return next((e.texts.get("name", "") for e in element.around if e.tag in around), "")


def _of(file: str, element: ScannedElement) -> Iterator[Symbol]:
    tag = language().get(element.tag)
    if tag is None or not element.attributes:
        return
    form = tag.form(element.texts)
    known = _attributes(element.tag, tag.forms.index(form))
    for attribute in element.attributes:
        field = known.get(attribute.name)
        if field is None:
            continue
        named = form.NAMED if attribute.name == "name" and issubclass(form, Element) else ""
        if named and attribute.value:
            scope = scope_of(named, element)
            yield Symbol(named, scope, attribute.value, file, attribute.place, True, element)
        elif field.type is not None and field.datatype.refers:
            for kind, name, place, owner in references(field.datatype.refers, attribute.value):
                scope = owner if kind in ("alternative", "value") else scope_of(kind, element)
                # A reason is declared wherever something is said to fail for it.
                declares = kind == "reason" and field.several
                yield Symbol(kind, scope, name, file, attribute.place + place, declares, element)


_LOOSE = ("objective", "block path", "loss", "happening")


def resolved(symbols: list[Symbol]) -> list[Symbol]:
    """Names as they are read, each as the elements that it means.

    A name of an objective, or of copies of it, is taken apart: ``visit_12.shelter_at_travel`` names three
    blocks. What means nothing stays, as a name of its last part.

    Args:
        symbols: Of all files of a mission.
    """
    if not any(symbol.kind in _LOOSE or symbol.kind == "alternative" for symbol in symbols):
        return symbols
    meaning = _Meaning(symbols)
    return [each for symbol in symbols for each in meaning.of(symbol)]


class _Meaning:
    def __init__(self, symbols: Iterable[Symbol]) -> None:
        self.blocks = defaultdict[str, dict[str, Symbol]](dict)
        """By text (a protocol; the mission itself has no name) and name, blocks that are declared."""
        self.declared = set[tuple[str, str]]()
        self.alternatives = defaultdict[str, list[str]](list)
        """By name of an alternative its activities."""
        for symbol in symbols:
            if symbol.declares:
                self.declared.add((symbol.kind, symbol.name))
                if symbol.kind == "block":
                    self.blocks[symbol.scope or ""].setdefault(symbol.name, symbol)
                elif symbol.kind == "alternative":
                    self.alternatives[symbol.name].append(symbol.scope or "")

    def of(self, symbol: Symbol) -> Iterable[Symbol]:
        if symbol.declares:
            return (symbol,)
        match symbol.kind:
            case "objective" | "block path":
                return self.path(symbol)
            case "loss":
                return self.loss(symbol)
            case "happening" if ("event", symbol.name) in self.declared:
                return (replace(symbol, kind="event", scope=""),)
            case "happening":
                said = happening(symbol.name)
                found = replace(symbol, kind=said.kind, name=said.name, place=symbol.place + said.place)
                if said.kind == "event":
                    return (replace(found, scope=""),)
                why = reason_in(symbol.name)
                named = [] if why is None else [replace(symbol, kind="reason", scope="", name=why.name)]
                named = [replace(each, place=symbol.place + why.place) for each in named if why]
                return *self.of(found), *named
            case "alternative" if (symbol.scope or "") not in self.alternatives.get(symbol.name, ()):
                # An activity that says no alternative has one of its own name.
                return (
                    (replace(symbol, kind="activity", scope=""),)
                    if symbol.name == symbol.scope
                    else (symbol,)
                )
        return (symbol,)

    def loss(self, symbol: Symbol) -> Iterator[Symbol]:
        """Hardware, or what may crash: an activity, or an alternative that its activity may qualify."""
        activity, dot, way = symbol.name.rpartition(".")
        if dot:
            yield replace(symbol, kind="activity", scope="", name=activity)
            place = symbol.place + len(activity) + 1
            yield from self.of(replace(symbol, kind="alternative", scope=activity, name=way, place=place))
        elif ("resource", way) in self.declared or not self._crashes(way):
            yield replace(symbol, kind="resource", scope="")
        elif ("activity", way) in self.declared:
            yield replace(symbol, kind="activity", scope="")
        else:
            (owner,) = self.alternatives[way]
            yield replace(symbol, kind="alternative", scope=owner)

    def _crashes(self, name: str) -> bool:
        return ("activity", name) in self.declared or len(self.alternatives.get(name, ())) == 1

    def path(self, symbol: Symbol) -> Iterable[Symbol]:
        """The blocks of a qualified name, in its own text, else in the only text that has such blocks."""
        own = self._path(symbol, symbol.scope or "")
        if own:
            return own
        found = [path for text in self.blocks if (path := self._path(symbol, text))]
        if len(found) == 1:
            return found[0]
        last = symbol.name.rpartition(".")[2]
        place = symbol.place + len(symbol.name) - len(last)
        return (replace(symbol, kind="block", scope=None, name=last, place=place),)

    def _path(self, symbol: Symbol, text: str) -> list[Symbol]:
        """The blocks of a qualified name that begins in a text; none where there are no such blocks."""
        found, place = list[Symbol](), symbol.place
        parts = symbol.name.split(".")
        for number, part in enumerate(parts):
            named = list(self._copy(part, text))
            if not named:
                return []
            for at, within, name in named:
                found.append(replace(symbol, kind="block", scope=within, name=name, place=place + at))
            block = self.blocks[text][named[0][2]].element
            if number == len(parts) - 1:
                elementary = block.tag == "objective" and "activities" in block.texts
                return found if elementary or symbol.kind == "block path" else []
            text = self._inside(text, named[0][2])
            place += len(part) + 1
        return []

    def _inside(self, text: str, name: str) -> str:
        """The text of the blocks that stand in a block: of a use of a protocol, the protocol."""
        block = self.blocks[text][name].element
        return block.texts.get("protocol", "") if block.tag == Use.TAG else text

    def _copy(self, name: str, text: str) -> Iterator[tuple[int, str, str]]:
        """The blocks that the name of a copy is made of: where each stands in it, its text and its name."""
        known = self.blocks.get(text, {})
        base = _longest(name, known)
        if base is None:
            return
        yield 0, text, base
        rest, at = name[len(base) + 1 :], len(base) + 1
        if rest.startswith("at_"):
            for place, within, other in self._stopped(rest[3:], text):
                yield at + 3 + place, within, other
        elif (recovered := _numbered(rest, known)) is not None:
            yield at, text, recovered

    def _stopped(self, name: str, text: str) -> Iterator[tuple[int, str, str]]:
        """The blocks of a qualified name whose dots have become ``_``, as :meth:`_copy` tells them."""
        base = _longest(name, self.blocks.get(text, {}))
        inside = self._inside(text, base) if base is not None else text
        if base is None or inside == text:
            yield from self._copy(name, text)
            return
        yield 0, text, base
        # What tells its own copies apart, as ``run2``, stands before the blocks in it.
        starts = [at + 1 for at in range(len(base), len(name)) if name[at] == "_"]
        for start in starts:
            if _longest(name[start:], self.blocks.get(inside, {})) is not None:
                for place, within, other in self._stopped(name[start:], inside):
                    yield start + place, within, other
                return


def _longest(name: str, known: dict[str, Symbol]) -> str | None:
    """The block itself of this name, else that of the longest name that ``_`` and more follow."""
    if name in known:
        return name
    ends = (end for end in range(len(name) - 1, 0, -1) if name[end] == "_")
    return next((name[:end] for end in ends if name[:end] in known), None)


def _numbered(name: str, known: dict[str, Symbol]) -> str | None:
    """The block that recovers, where a name begins with it and the number of its recovery."""
    ends = (end for end in range(len(name) - 1, 0, -1) if name[end].isdigit())
    return next((name[:end] for end in ends if name[:end] in known), None)


_IN_NAME = re.compile(r"\b([a-z]+)\(\s*\"?([\w.]*)\Z")
_IN_VALUE = re.compile(r"(?:\b([a-z]++)\(\s*+)?\"?(?<![\w.])([A-Za-z_][\w.]*+)\"?\s*+\)?\s*+=\s*+\w*+\Z")
_OPERATORS = {
    "AG": "in every state that is reached",
    "AF": "some day, on every run",
    "EF": "in some state that can be reached",
    "EG": "along some run, always",
    "EX": "after some event that may be next",
    "AX": "after every event that may be next",
    "G": "always, on a run",
    "F": "some day, on a run",
    "X": "after the next event",
    "U": "until",
    "W": "until, or for ever",
    "R": "the second, up to and with the moment of the first, or for ever",
    "A": "on every run",
    "E": "on some run",
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
                        qualifier = f"{symbol.scope}." if symbol.kind == "alternative" else ""
                        yield Offer(qualifier + symbol.name, _description(symbol), True)
            case "happening":
                yield from self.named("event", "", "")
                yield from (
                    Offer(f"{word.text}_EV_OOS", f"{word.text} is lost", True)
                    for word in self.named("loss", "", "")
                )
                for word in self.named("objective", scope, begun.removeprefix("OBJ_")):
                    yield Offer(f"OBJ_{word.text}_EV_OK", f"{word.text} succeeds", True)
                    yield Offer(f"OBJ_{word.text}_EV_FAIL", f"{word.text} fails", True)
                    for reason in self.reasons(word.text, scope):
                        told = f"{word.text} fails for {reason}"
                        yield Offer(f"OBJ_{word.text}_EV_FAIL_{reason}", told, True)
            case _:
                found = self._of(kind, scope if kind in ("block", "alternative") else "")
                for symbol in {s.name: s for s in found}.values():
                    yield Offer(symbol.name, _description(symbol), True)

    def reasons(self, path: str, scope: str) -> Iterator[str]:
        """The reasons for which an objective fails, by its name in a text."""
        name = path.rpartition(".")[2]
        every = {s.name: s.element.texts.get("failures", "") for s in self._of("activity", "")}
        for symbol in self.symbols:
            texts = symbol.element.texts
            if symbol.kind == "block" and symbol.name == name and ("." in path or symbol.scope == scope):
                said = [every.get(activity, "") for activity in texts.get("activities", "").split()]
                words = " ".join((*said, texts.get("failures", ""))).split()
                yield from dict.fromkeys(word.partition("=")[0] for word in words)
                return

    def values(self, kind: str, owner: str) -> Iterator[Offer]:
        """Alternatives of an activity, or values of a fact."""
        if kind == "alternative":
            ways = [s.name for s in self._of("alternative", owner)]
            yield from (Offer(way, f"a way of {owner}", True) for way in ways or [owner])
        for symbol in self._of("fact", "") if kind == "value" else ():
            if symbol.name == owner:
                values = symbol.element.texts.get("values", "").split() or BOOLEAN_VALUES
                yield from (Offer(value, f"a value of {owner}") for value in values)

    def _of(self, kind: str, scope: str) -> Iterator[Symbol]:
        return (s for s in self.symbols if s.kind == kind and (s.scope or "") == scope)


def _description(symbol: Symbol) -> str:
    return symbol.element.texts.get("description", "")
