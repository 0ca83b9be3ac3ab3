"""Elements and attributes of a text with their places, also where the text is no XML yet."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

_NAME = r"[A-Za-z_][\w.-]*"
_TOKEN = re.compile(
    r"<!--.*?(?:-->|\Z)|<\?.*?(?:\?>|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)"
    rf"|<(?P<close>/)?(?P<tag>{_NAME})?(?P<inside>(?:\"[^\"<]*\"|'[^'<]*'|[^<>\"']+)*)(?P<end>>)?",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(
    rf"(?<![\w.-])(?P<name>{_NAME})\s*=\s*(?:\"(?P<double>[^\"]*)\"?|'(?P<single>[^']*)'?)"
)


@dataclass(frozen=True, slots=True)
class ScannedAttribute:
    """An attribute in its place.

    Args:
        name: Its name.
        value: Its text as it is written.
        begin: Where the value begins, in characters from the beginning of the text.
    """

    name: str
    value: str
    begin: int

    @property
    def end(self) -> int:
        """Behind the last character of the value."""
        return self.begin + len(self.value)


@dataclass(slots=True, eq=False)
class ScannedElement:
    """An element in its place.

    Args:
        tag: Its name; empty where none is typed yet.
        begin: Where its start tag begins.
        end: Behind its start tag.
        parent: What it stands in.
        attributes: In their order.
        closed: Whether the start tag has its end.
    """

    tag: str
    begin: int
    end: int
    parent: ScannedElement | None
    attributes: list[ScannedAttribute] = field(default_factory=list)
    closed: bool = True

    @property
    def texts(self) -> dict[str, str]:
        """Texts of attributes by name."""
        return {attribute.name: attribute.value for attribute in self.attributes}

    @property
    def around(self) -> Iterator[ScannedElement]:
        """Itself and what it stands in, from the inside."""
        at: ScannedElement | None = self
        while at is not None:
            yield at
            at = at.parent


def scan(text: str) -> list[ScannedElement]:
    """The elements of a text, in its order; what is broken is passed over."""
    found = list[ScannedElement]()
    open_: ScannedElement | None = None
    for token in _TOKEN.finditer(text):
        if token["inside"] is None:  # a comment, or what is no element
            continue
        tag = token["tag"] or ""
        if token["close"]:
            matching = next((e for e in open_.around if e.tag == tag), None) if open_ else None
            open_ = matching.parent if matching else open_
            continue
        element = ScannedElement(tag, token.start(), token.end(), open_, closed=bool(token["end"]))
        for attribute in _ATTRIBUTE.finditer(token["inside"]):
            group = "double" if attribute["double"] is not None else "single"
            begin = token.start("inside") + attribute.start(group)
            element.attributes.append(ScannedAttribute(attribute["name"], attribute[group], begin))
        found.append(element)
        if element.closed and not token["inside"].rstrip().endswith("/"):
            open_ = element
    return found


def enclosing(text: str, offset: int) -> ScannedElement | None:
    """The element in whose content a place stands; ``None`` outside of all, and in a comment."""
    found = scan(text[:offset] + "<here/>")
    return found[-1].parent if found and found[-1].tag == "here" else None
