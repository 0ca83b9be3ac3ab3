"""A mission's text as a whole: its outline, and how it is laid out."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from lxml import etree

from mcpn.editor.scan import TOKEN, ScannedElement
from mcpn.errors import InputError
from mcpn.mission.language.forms import language
from mcpn.mission.robot import Described, Element
from mcpn.xmlio import parse_whole

WIDTH = 120
"""Characters of a line, beyond which attributes go on in lines of their own."""
INDENT = "  "
_ATTRIBUTE = re.compile(r"(?<!\s)\s++([\w:.-]++)=(\"[^\"]*\"|'[^']*')")
_START = re.compile(r"<[A-Za-z_][\w.:-]*(?:\s+[\w:.-]+=(?:\"[^\"]*\"|'[^']*'))*\s*/?>")
_COMMENT = re.compile(r"(<!--.*?-->)", re.DOTALL)


@dataclass
class Outlined:
    """A named element in the outline of a text.

    Args:
        element: The element.
        end: Behind its end tag.
        inside: Named elements inside.
    """

    element: ScannedElement
    end: int
    inside: list[Outlined] = field(default_factory=list)


def outline(text: str, elements: list[ScannedElement]) -> list[Outlined]:
    """The named elements of a text, each in that around it, also where the text is no XML yet.

    Args:
        text: The text.
        elements: What was scanned of it.
    """
    ends, roots = _ends(text, elements), list[Outlined]()
    shown = dict[int, Outlined]()
    for element in elements:
        if not _named(element):
            continue
        made = Outlined(element, ends.get(element.begin, element.end))
        around = (shown[e.begin] for e in element.around if e is not element and e.begin in shown)
        next(around, Outlined(element, 0, roots)).inside.append(made)
        shown[element.begin] = made
    return roots


def _named(element: ScannedElement) -> bool:
    tag = language().get(element.tag)
    return (
        bool(element.texts.get("name")) and tag is not None and issubclass(tag.forms[0], (Element, Described))
    )


def _ends(text: str, elements: list[ScannedElement]) -> dict[int, int]:
    """By where an element begins, behind its end tag; what is never closed ends with the text."""
    found, stack = dict[int, int](), list[ScannedElement]()
    known = {element.begin: element for element in elements}
    for token in TOKEN.finditer(text):
        if token["inside"] is None:
            continue
        if token["close"]:
            while stack:
                last = stack.pop()
                found[last.begin] = token.end() if last.tag == token["tag"] else token.start()
                if last.tag == token["tag"]:
                    break
        elif (element := known.get(token.start())) is not None and element.holds:
            stack.append(element)
    return found | {element.begin: len(text) for element in stack}


def formatted(text: str) -> str | None:
    """The text with one element a line, indented, long start tags over several lines.

    It says the same to every reader. Comments and single empty lines stay.
    ``None`` where the text is no XML that is read, or holds words
    between its elements.

    Args:
        text: The text of a file.
    """
    try:
        tree = parse_whole(text)
    except InputError:
        return None
    root = tree.getroot()
    for node in root.iter():
        if (isinstance(node.tag, str) and _words(node.text)) or (node is not root and _words(node.tail)):
            return None
    for node in root.iter():
        depth = sum(1 for _ in node.iterancestors())
        if len(node) and isinstance(node.tag, str):
            node.text = _gap(node.text, depth + 1, first=True)
        elif isinstance(node.tag, str):
            node.text = None
        if node is not root:
            last = node.getnext() is None
            node.tail = _gap(node.tail, depth - last, first=last)
    declared = re.match(r"\s*(<\?xml[^>]*\?>)", text)
    written = etree.tostring(tree, encoding="unicode")
    laid = "".join(
        part if part.startswith("<!--") else _START.sub(_wrapped, part) for part in _COMMENT.split(written)
    )
    return (declared[1] + "\n" if declared else "") + laid.strip() + "\n"


def _words(text: str | None) -> bool:
    return bool(text and text.strip())


def _gap(text: str | None, depth: int, *, first: bool) -> str:
    """What stands between two elements; an empty line stays, but not next to the element around."""
    lines = 1 if first or (text or "").count("\n") < 2 else 2
    return "\n" * lines + INDENT * depth


def _wrapped(tag: re.Match[str]) -> str:
    """A start tag; one that is too long for its line over several, as many attributes in each as fit."""
    text = tag.string
    begin = tag.start() - (text.rfind("\n", 0, tag.start()) + 1)
    if begin + len(tag[0]) <= WIDTH:
        return tag[0]
    name = re.match(r"<[\w.:-]+", tag[0])
    assert name is not None, "a start tag has a name"
    end = "/>" if tag[0].endswith("/>") else ">"
    return "\n".join(_lines(name[0], [f"{a[1]}={a[2]}" for a in _ATTRIBUTE.finditer(tag[0])], begin)) + end


def _lines(name: str, attributes: list[str], begin: int) -> Iterator[str]:
    line, filled = name, False
    margin = " " * (begin + len(name))
    for attribute in attributes:
        width = len(line) + 1 + len(attribute) + (0 if line.startswith(" ") else begin)
        if filled and width > WIDTH - 2:
            yield line
            line = margin
        line, filled = f"{line} {attribute}", True
    yield line
