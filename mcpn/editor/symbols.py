"""Names in the files of a mission: where each is declared, and where it is used."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from mcpn.editor.scan import ScannedAttribute, ScannedElement, scan
from mcpn.mission.language.forms import Field, form_of, language
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Mission, Protocol
from mcpn.mission.robot import Activity, Element

EXITS = (SUCCEED, FAIL, ABORT)
_NAME = re.compile(r"[A-Za-z_]\w*")
_SAID = re.compile(r"\b([a-z]+)\(\s*([A-Za-z_][\w.]*)")
_OBJECTIVE = re.compile(r"OBJ_(?P<name>[A-Za-z_][\w.]*)_EV_(?:OK|FAIL|TIMEOUT)")
_KINDS = {
    **dict.fromkeys(("objective", "pending", "block", "done"), "block"),
    **dict.fromkeys(("activity", "waiting", "refused", "alternative"), "activity"),
    **dict.fromkeys(("oos", "available"), "resource"),
    **dict.fromkeys(("event", "happens"), "event"),
    "fact": "fact",
}
"""By word of formulas about a name, what it names."""


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name in its place.

    Args:
        kind: What it names: ``resource``, ``activity``, ``block``, ``protocol``, ``event``, ``alternative``.
        scope: Where it is unique: the name of the protocol of a block, the activity of an alternative; empty
            where that is the mission. ``None`` in formulas, which may name what stands in any protocol.
        name: The name.
        file: The file.
        begin: Where it begins in its text.
        declares: Whether it is declared here.
        element: The element that says it.
    """

    kind: str
    scope: str | None
    name: str
    file: str
    begin: int
    declares: bool
    element: ScannedElement

    @property
    def end(self) -> int:
        """Behind its last character."""
        return self.begin + len(self.name)

    def means(self, other: Symbol) -> bool:
        """Whether another one names the same."""
        same = self.kind == other.kind and self.name == other.name
        return same and (self.scope == other.scope or None in (self.scope, other.scope))


def symbols(file: str, text: str) -> list[Symbol]:
    """The names in a text, declared and used, in its order."""
    return [symbol for element in scan(text) for symbol in _of(file, element)]


def attribute_of(element: ScannedElement, name: str) -> Field | None:
    """What the language knows of an attribute of an element; ``None`` for one that it has not."""
    tag = language().get(element.tag)
    if tag is None:
        return None
    of_form = {a.tag: a for a in form_of(tag.form(element.texts)).attributes}
    return of_form.get(name) or tag.attributes.get(name)


def scope_of(kind: str, element: ScannedElement) -> str:
    """Where a name of an element is unique."""
    around = {"block": (Protocol.TAG,), "alternative": (Activity.TAG,)}.get(kind, ())
    return next((e.texts.get("name", "") for e in element.around if e.tag in around), "")


def _of(file: str, element: ScannedElement) -> Iterator[Symbol]:
    for attribute in element.attributes:
        known = attribute_of(element, attribute.name)
        if known is None:
            continue
        declares = attribute.name == "name" and _kind_of(element)
        if declares and attribute.value:
            scope = scope_of(declares, element)
            yield Symbol(declares, scope, attribute.value, file, attribute.begin, True, element)
        elif known.type is not None and (kind := known.datatype.refers):
            for word in _NAME.finditer(attribute.value):
                if kind != "block" or word[0] not in EXITS:
                    begin = attribute.begin + word.start()
                    yield Symbol(kind, scope_of(kind, element), word[0], file, begin, False, element)
        elif attribute.name == "formula":
            yield from _in_formula(file, element, attribute)


def _kind_of(element: ScannedElement) -> str:
    """What the name of an element names, where others refer to it; empty for others."""
    tag = language().get(element.tag)
    form = tag.form(element.texts) if tag else Mission
    return form.NAMED if issubclass(form, Element) else ""


def _in_formula(file: str, element: ScannedElement, attribute: ScannedAttribute) -> Iterator[Symbol]:
    """Names that a formula says; of qualified ones the last, which stands in some protocol."""
    for said in _SAID.finditer(attribute.value):
        kind, begin, name = _KINDS.get(said[1]), said.start(2), said[2]
        if (of := _OBJECTIVE.match(name)) is not None:
            kind, begin, name = "block", begin + of.start("name"), of["name"]
        if kind is not None:
            last = name.rpartition(".")[2]
            begin += attribute.begin + len(name) - len(last)
            yield Symbol(kind, None, last, file, begin, False, element)
