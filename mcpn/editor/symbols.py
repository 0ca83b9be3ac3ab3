"""Names in the files of a mission: where each is declared, and where it is used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache

from mcpn.editor.scan import ScannedElement
from mcpn.mission.language.forms import Field, form_of, language
from mcpn.mission.language.references import references
from mcpn.mission.model import Protocol
from mcpn.mission.robot import Activity, Element


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name in its place.

    Args:
        kind: What it names: ``resource``, ``activity``, ``block``, ``protocol``, ``event``, ``alternative``,
            ``fact``. As it is read, before it is known what is declared, also what
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
        declares = form.NAMED if attribute.name == "name" and issubclass(form, Element) else ""
        if declares and attribute.value:
            scope = scope_of(declares, element)
            yield Symbol(declares, scope, attribute.value, file, attribute.place, True, element)
        elif field.type is not None and field.datatype.refers:
            for kind, name, place, of in references(field.datatype.refers, attribute.value):
                scope = of if kind in ("alternative", "value") else scope_of(kind, element)
                yield Symbol(kind, scope, name, file, attribute.place + place, False, element)
