"""Reads a mission again after an edit: elements on lines that have not changed are kept as they were read.

An edit changes a few lines of one file. The elements on all other lines stay the same objects, so that the
checks of a mission, too, can pass over the elements that they have seen.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from lxml import etree

from mcpn.records import record

if TYPE_CHECKING:
    from mcpn.mission.model import Mission

MAX_LINES = 65_000
"""libxml2 does not know the lines of longer files one from another."""


@record(slots=True)
class Made:
    """What an element of a file was read as.

    Args:
        tag: Its name.
        value: The element of the model.
        members: What stands inside.
        line: Its line.
        last: The line of the last element in it, or its own.
    """

    tag: str
    value: Any
    members: list[Made]
    line: int
    last: int

    def move(self, lines: int) -> None:
        """Adds to the line numbers of the element and of all inside it, in place: only a draft may do so."""
        stack = [self]
        while stack:
            made = stack.pop()
            made.line += lines
            made.last += lines
            object.__setattr__(made.value.source, "line", made.line)
            stack += made.members


class Edit(NamedTuple):
    """Lines that have changed.

    Args:
        first: The first of them, as they were counted before.
        last: The last of them; of lines that are new alone, the one behind them.
        more: How many lines the file has now more than before.
    """

    first: int
    last: int
    more: int

    @classmethod
    def between(cls, before: list[bytes], now: list[bytes]) -> Edit:
        """The edit that makes some lines of others."""
        least, same, behind = min(len(before), len(now)), 0, 0
        while same < least and before[same] == now[same]:
            same += 1
        while behind < least - same and before[-1 - behind] == now[-1 - behind]:
            behind += 1
        first, last = same + 1, len(before) - behind
        return cls(min(first, last), max(first, last), len(now) - len(before))

    def kept(self, made: Made, members: int) -> tuple[int, int]:
        """How many of the first members of an element, and of the last ones, are as before.

        Args:
            made: What the element was read as; the edit is in it, or beside it.
            members: How many it has now.
        """
        # Of a member only two lines are known: where its start tag ends, and that of the last element in it.
        # Its text may begin before and end after them, so the members beside the edit are read again, too.
        before = made.members
        first = max(bisect_left(before, self.first, key=lambda m: m.line) - 1, 0)
        behind = max(len(before) - bisect_right(before, self.last, key=lambda m: m.last) - 1, 0)
        return (first, behind) if first + behind <= members else (0, 0)

    def between_kept(self, made: Made, members: int) -> list[Made | None]:
        """For each member that is not kept, what it was before; ``None`` where their number has changed."""
        first, behind = self.kept(made, members)
        old = made.members[first : len(made.members) - behind]
        new = members - first - behind
        return [*old] if len(old) == new else [None] * new

    def excerpt(self, element: etree._Element, made: Made) -> etree._Element:
        """A copy of the part of an element that may have changed; if it fits the schema, so does the element.

        This is so because of the form of the language: an element holds some elements in any number and any
        order, and then perhaps a series of blocks. So a new member that does not fit is recognised from the
        members beside it.
        """
        # An edit up to the first member may be in the start tag, whose attributes decide what fits inside.
        if not made.members or self.first <= made.members[0].line:
            return deepcopy(element)
        count = len(element)
        first, behind = self.kept(made, count)
        names = cast(dict[str, str], element.nsmap)
        copy = etree.Element(element.tag, {str(k): str(v) for k, v in element.items()}, names)
        copy.text = element.text
        for place, old in enumerate(self.between_kept(made, count), first):
            child = element[place]
            part = self.excerpt(child, old) if old and old.tag == tag_of(child) else deepcopy(child)
            part.tail = child.tail
            copy.append(part)
        for place in dict.fromkeys((count - behind, count - 1) if behind else ()):
            copy.append(deepcopy(element[place]))
        return copy

    def changed(self, element: etree._Element, made: Made) -> Iterator[etree._Element]:
        """An element and those in it that may have changed, or hold such elements, in document order."""
        if made.tag != tag_of(element):
            yield from element.iter()
            return
        yield element
        count = len(element)
        for place, old in enumerate(self.between_kept(made, count), self.kept(made, count)[0]):
            yield from self.changed(element[place], old) if old else element[place].iter()


class MissionDraft:
    """What was read of a mission before, for a reader that reads it again after an edit.

    The draft changes the line numbers of elements in place: a caller that keeps elements may find them moved.
    """

    def __init__(self) -> None:
        self.files: dict[Path, tuple[list[bytes], Made]] = {}
        self.mission: Mission | None = None
        """The last one that was valid."""

    def edit(self, file: Path, lines: list[bytes]) -> tuple[Made, Edit] | None:
        """What a file was read as, and where its lines are others now; ``None`` if it was not read."""
        if file not in self.files:
            return None
        before, made = self.files[file]
        return (made, Edit.between(before, lines)) if max(len(before), len(lines)) <= MAX_LINES else None


def tag_of(element: etree._Element) -> str:
    """The name of an element without its namespace."""
    return etree.QName(element).localname
