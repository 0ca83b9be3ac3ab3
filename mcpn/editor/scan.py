"""Elements and attributes of a text with their places, also where the text is no XML yet."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from mcpn.mission.xml import MAX_DEPTH

_NAME = r"[A-Za-z_][\w.-]*"
_PASSED = r"<!--.*?(?:-->|(\Z))|<\?.*?(?:\?>|(\Z))|<!\[CDATA\[.*?(?:\]\]>|(\Z))"
"""Comments and what is no element, to their end or, as a group, to the end of the text."""
TOKEN = re.compile(
    rf"{_PASSED}|<(?P<close>/)?(?P<tag>{_NAME})?"
    r"(?P<inside>(?:\"[^\"<]*\"|'[^'<]*'|[^<>\"']+)*)(?P<end>>)?",
    re.DOTALL,
)
_WITHOUT_TAGS = re.compile(_PASSED, re.DOTALL)
_ATTRIBUTE = re.compile(
    rf"(?<![\w.-])(?P<name>{_NAME})\s*=\s*(?:\"(?P<double>[^\"]*)\"?|'(?P<single>[^']*)'?)"
)


@dataclass(frozen=True, slots=True, eq=False)
class ScannedAttribute:
    """An attribute in its place.

    Args:
        name: Its name.
        value: Its text as it is written.
        element: What it stands on.
        place: Where the value begins, in characters from the beginning of the element.
    """

    name: str
    value: str
    element: ScannedElement = field(repr=False)
    place: int

    @property
    def begin(self) -> int:
        """Where the value begins, in characters from the beginning of the text."""
        return self.element.begin + self.place

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
        holds: Whether others may stand in it.
        depth: In how many others it stands.
        names: What names are in it, once somebody has found out.
    """

    tag: str
    begin: int
    end: int
    parent: ScannedElement | None
    attributes: list[ScannedAttribute] = field(default_factory=list)
    closed: bool = True
    holds: bool = False
    depth: int = 0
    names: list[Any] | None = field(default=None, repr=False)

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
    """The elements of a text, in its order; what is broken, or nested too deep, is passed over."""
    return _scan(text, 0, len(text), None)[0]


def _scan(
    text: str, begin: int, end: int, around: ScannedElement | None
) -> tuple[list[ScannedElement], ScannedElement | None]:
    """The elements in a part of a text, and the one that is open at its end."""
    found = list[ScannedElement]()
    for token in TOKEN.finditer(text, begin, end):
        if token["inside"] is None:  # a comment, or what is no element
            continue
        tag = token["tag"] or ""
        if token["close"]:
            matching = next((e for e in around.around if e.tag == tag), None) if around else None
            around = matching.parent if matching else around
            continue
        element = ScannedElement(tag, token.start(), token.end(), around, closed=bool(token["end"]))
        element.depth = around.depth + 1 if around else 0
        if element.closed and not token["inside"].rstrip().endswith("/"):
            element.holds, around = True, element
        if element.depth > MAX_DEPTH:
            continue
        before = token.start("inside") - token.start()
        for attribute in _ATTRIBUTE.finditer(token["inside"]):
            group = "double" if attribute["double"] is not None else "single"
            place = before + attribute.start(group)
            element.attributes.append(ScannedAttribute(attribute["name"], attribute[group], element, place))
        found.append(element)
    return found, around


class Scan:
    """The elements of a text that is edited: an edit inside some tags costs what is edited.

    Elements keep what has been found of them while they move.
    """

    def __init__(self) -> None:
        self.text = ""
        self.elements: list[ScannedElement] = []
        self._lines: list[int] = []

    def of(self, text: str) -> list[ScannedElement]:
        """The elements of a text that is much like the last one."""
        if text != self.text:
            if not self._edited(text):
                self.elements = scan(text)
            self.text, self._lines = text, []
        return self.elements

    @property
    def lines(self) -> list[int]:
        """Where each line begins."""
        if not self._lines:
            self._lines = [0, *(end.end() for end in re.finditer("\n", self.text))]
        return self._lines

    def between(self, begin: int, end: int) -> list[ScannedElement]:
        """The elements of which a part of the start tag stands between two places."""
        first = bisect_right(self.elements, begin, key=lambda e: e.end)
        return self.elements[first : bisect_left(self.elements, end, key=lambda e: e.begin)]

    def open_at(self, offset: int) -> ScannedElement | None:
        """The element in whose start tag a place stands, without what is behind the place."""
        number = bisect_left(self.elements, offset, key=lambda e: e.begin)
        last = self.elements[number - 1] if number else None
        if last is None or (last.end <= offset and last.closed):
            return None
        if last.end < offset:  # a tag without its end: another may begin behind it
            begun = _scan(self.text, last.end, offset, last.parent)[0]
            if begun and not begun[-1].closed:
                return begun[-1]
        return _scan(self.text, last.begin, min(offset, last.end), last.parent)[0][0]

    def around(self, offset: int) -> ScannedElement | None:
        """The element in whose content a place between two tags stands, if one does, and not in a comment."""
        number = bisect_left(self.elements, offset, key=lambda e: e.begin)
        if not number or _commented(self.text, offset):
            return None
        last = self.elements[number - 1]
        return _scan(self.text, last.end, offset, last if last.holds else last.parent)[1]

    def _edited(self, text: str) -> bool:
        """Takes over a text if it differs from the last one in whole tags that hold as much as before."""
        before = self.text
        same, behind = _alike(before, text)
        begin, rest = before.rfind("<", 0, same), before.find("<", len(before) - behind)
        if begin < 0 or rest < 0 or _commented(before, begin):
            return False
        end = len(text) - len(before) + rest
        if any(mark in part for part in (before[begin:rest], text[begin:end]) for mark in _MARKS):
            return False
        first, last = (bisect_left(self.elements, at, key=lambda e: e.begin) for at in (begin, rest))
        around = self.around(begin)
        if around is not None and around.depth >= MAX_DEPTH:
            return False
        open_before = _scan(before, begin, rest, around)[1]
        new, open_now = _scan(text, begin, end, around)
        if open_before is around and open_now is around:
            self.elements[first:last] = new
        elif _tags(before[begin:rest]) == _tags(text[begin:end]):
            for element, now in zip(self.elements[first:last], new, strict=True):
                if element.texts.get("name") != now.texts.get("name"):
                    return False  # names of what stands in it are found by it
                element.begin, element.end, element.names = now.begin, now.end, None
                element.attributes = [replace(each, element=element) for each in now.attributes]
        else:
            return False
        for element in self.elements[first + len(new) :]:
            element.begin += end - rest
            element.end += end - rest
        return True


_MARKS = ("<!", "-->", "<?", "?>", "]]>")


def _commented(text: str, offset: int) -> bool:
    """Whether a place stands in a comment, or in what is no element."""
    return any(passed.lastindex for passed in _WITHOUT_TAGS.finditer(text, 0, offset))


def _tags(text: str) -> list[tuple[str | None, str | None, bool, bool]]:
    """Start and end tags of a text, without what stands in them."""
    tokens = (token for token in TOKEN.finditer(text) if token["inside"] is not None)
    return [(t["close"], t["tag"], bool(t["end"]), t["inside"].rstrip().endswith("/")) for t in tokens]


def _alike(before: str, now: str, step: int = 4096) -> tuple[int, int]:
    """How many characters two texts have in common at their beginnings, and behind these at their ends."""
    most, same, behind = min(len(before), len(now)), 0, 0
    while same < most and before[same : same + step] == now[same : same + step]:
        same += step
    same = min(same, most)
    while same < most and before[same] == now[same]:
        same += 1
    most -= same

    def end(text: str, at: int) -> str:
        return text[max(len(text) - at - step, 0) : len(text) - at]

    while behind + step < most and end(before, behind) == end(now, behind):
        behind += step
    while behind < most and before[-1 - behind] == now[-1 - behind]:
        behind += 1
    return same, behind
