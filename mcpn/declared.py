"""Tables of the elements and attributes that a reader of XML knows, and the check of a document against one.

A table has a row for each element: its attributes and what may stand inside, each as words. A word is

- ``name``: the reader asks for it;
- ``-name``: known, and without meaning for the reader, whatever its value or what stands inside;
- ``name=one|other``: known with these values alone, which change nothing; in a row's ``inside`` the value is
  the text of the element, or of its only child.

What is in no row is refused with its line: nothing is skipped because no code asks for it. Attributes of XML
itself (``xml:``, ``xsi:``) are without meaning everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple, NoReturn

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.sentences import quoted
from mcpn.xmlio import line_of

_OF_XML = (
    "{http://www.w3.org/XML/1998/namespace}",
    "{http://www.w3.org/2001/XMLSchema-instance}",
)


class Declared(NamedTuple):
    """What an element may have.

    Args:
        attributes: Words for its attributes.
        inside: Words for the elements that may stand in it.
        text: Whether text may stand in it.
    """

    attributes: str = ""
    inside: str = ""
    text: bool = False


class ElementRule(NamedTuple):
    """A row that has been read: by name the values that may stand there, empty for any."""

    attributes: Mapping[str, frozenset[str]]
    inside: Mapping[str, frozenset[str]]
    ignored: frozenset[str]
    text: bool
    valued: bool
    """Whether some element in it may say no more than some values."""


_NOTHING = ElementRule({}, {}, frozenset(), text=True, valued=False)


class ElementTable:
    """The rows of a format.

    Args:
        rows: By name of the element; one that a row names and that has no row itself holds text alone, or
            is without meaning.
        root: The element that a document is.
    """

    def __init__(self, rows: Mapping[str, Declared], root: str) -> None:
        self.root = root
        self.rules = {name: _rule(row) for name, row in rows.items()}

    def entered(self, file: str, element: etree._Element, around: ElementRule | None) -> ElementRule | None:
        """Checks an element that begins: its name where it stands, and its attributes.

        Args:
            file: For errors.
            element: What begins.
            around: The rule of the element around it; ``None`` of the root.

        Returns:
            The rule for what stands in it; ``None`` where it is without meaning, and so is all in it.

        Raises:
            InputError: What is in no row, with its line.
        """
        space, tag = _parted(element.tag)
        parent, before = element.getparent(), element.getprevious()
        if around is not None and parent is not None and not around.text:
            _no_text(file, parent, parent.text if before is None else before.tail)
        if parent is None or around is None:
            if tag != self.root:
                refuse(file, element, f"found <{tag}>, expected <{self.root}>")
        elif tag not in around.inside or space != _space(parent):
            found = f"<{tag}>" if _space(element) == _space(parent) else f"<{tag}> of {_shown(element)}"
            known = [f"<{name}>" for name in around.inside if name not in around.ignored]
            said = f"found {found} in {_described(parent)}, expected {_listed(known)}"
            refuse(file, element, said + _near(tag, around.inside))
        elif tag in around.ignored:
            return None
        rule = self.rules.get(tag, _NOTHING)
        for key, value in element.attrib.items():
            self._attribute(file, element, rule, str(key), str(value))
        return rule

    def _attribute(
        self, file: str, element: etree._Element, rule: ElementRule, name: str, value: str
    ) -> None:
        if name.startswith(_OF_XML):
            return
        if name not in rule.attributes:
            known = [key for key in rule.attributes if f"@{key}" not in rule.ignored]
            said = f"found the attribute {name} of {_described(element)}, expected {_listed(known)}"
            refuse(file, element, said + _near(name, rule.attributes))
        values = rule.attributes[name]
        if values and value.strip() not in values:
            allowed = " or ".join(map(repr, sorted(values)))
            said = f"found {name}={quoted(value, 40)} of {_described(element)}, expected {allowed}"
            refuse(file, element, f"{said}: what else it may say is not supported")

    def left(self, file: str, element: etree._Element, rule: ElementRule) -> None:
        """Checks an element that ends: the last text in it, and the values of elements in it.

        Raises:
            InputError: A text where none may stand, or a value that is in no row.
        """
        if not rule.text:
            _no_text(file, element, element[-1].tail if len(element) else element.text)
        for child in element if rule.valued else ():
            values = rule.inside.get(name_of(child))
            if values and (value := text_of(child)) not in values:
                allowed = " or ".join(sorted(map(repr, values)))
                found = f"found <{name_of(child)}> {quoted(value, 40)} in {_described(element)}"
                said = f"{found}, expected {allowed}: what else it may say is not supported"
                refuse(file, child, said)

    def check(self, file: str, root: etree._Element, around: ElementRule | None = None) -> None:
        """Checks an element and all that stands in it.

        Args:
            file: For errors.
            root: The element.
            around: The rule of the element around it; ``None`` of the root of a document.

        Raises:
            InputError: What is in no row, with its line.
        """
        stack: list[tuple[etree._Element, ElementRule | None]] = [(root, around)]
        while stack:
            element, around = stack.pop()
            rule = self.entered(file, element, around)
            if rule is not None:
                self.left(file, element, rule)
                stack.extend((child, rule) for child in reversed(element))


def _rule(row: Declared) -> ElementRule:
    attributes, inside = dict(_words(row.attributes)), dict(_words(row.inside))
    ignored = [*_ignored(row.inside), *(f"@{name}" for name in _ignored(row.attributes))]
    return ElementRule(attributes, inside, frozenset(ignored), row.text, any(inside.values()))


def _words(row: str) -> Iterator[tuple[str, frozenset[str]]]:
    for word in row.split():
        name, _, values = word.removeprefix("-").partition("=")
        yield (
            name,
            frozenset(value.replace("_", " ") for value in values.split("|")) if values else frozenset(),
        )


def _ignored(row: str) -> Iterator[str]:
    return (word[1:] for word in row.split() if word.startswith("-"))


def refuse(file: str, element: etree._Element, message: str) -> NoReturn:
    """Raises the error at an element."""
    raise InputError.at(source_of(file, element), message)


def source_of(file: str, element: etree._Element) -> Source:
    """Where an element begins."""
    return Source(file, line_of(element))


def _no_text(file: str, element: etree._Element, text: str | None) -> None:
    if text and text.strip():
        found = f"found the text {quoted(text.strip(), 40)} in {_described(element)}"
        refuse(file, element, f"{found}, expected elements alone")


@lru_cache(maxsize=1024)  # a document has few tags, and asks for each again and again
def _parted(tag: str) -> tuple[str, str]:
    """The namespace of a tag, and its name."""
    space, _, name = tag.rpartition("}")
    return space, name


def name_of(element: etree._Element) -> str:
    """The name of an element without its namespace."""
    return _parted(element.tag)[1]


def text_of(element: etree._Element) -> str:
    """The text of an element, or that of what stands in it."""
    return "".join(map(str, element.itertext())).strip()


def _space(element: etree._Element) -> str:
    return _parted(element.tag)[0]


def _shown(element: etree._Element) -> str:
    return f"the namespace {_space(element)[1:]}" if _space(element) else "no namespace"


def _described(element: etree._Element) -> str:
    key = element.get("id")
    return f"<{name_of(element)}>" if key is None else f"{name_of(element)} {key}"


def _listed(names: Iterable[str]) -> str:
    *most, last = [*names] or ["nothing"]
    return f"{', '.join(most)} or {last}" if most else last


def _near(name: str, known: Iterable[str]) -> str:
    from difflib import get_close_matches

    near = get_close_matches(name, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""
