"""How the text of a mission is laid out: its lines, its indentation, its attributes."""

from __future__ import annotations

import re
from collections.abc import Iterator

from lxml import etree

from mcpn.errors import InputError
from mcpn.xmlio import parse_whole

WIDTH = 120
"""Characters of a line, beyond which attributes go on in lines of their own."""
INDENT = "  "
_ATTRIBUTE = re.compile(r"(?<!\s)\s++([\w:.-]++)=(\"[^\"]*\"|'[^']*')")
_START = re.compile(r"<[A-Za-z_][\w.:-]*(?:\s+[\w:.-]+=(?:\"[^\"]*\"|'[^']*'))*\s*/?>")
_COMMENT = re.compile(r"(<!--.*?-->)", re.DOTALL)


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
