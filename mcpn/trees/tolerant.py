"""XML as tinyxml2 takes it: ``&`` and ``<`` as they are in attributes, where trees have scripts.

Files are untrusted: one pass, in time and space linear in the file, and what it makes is parsed as strictly
as any other file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

_LONE = re.compile(r"&(?!(?:amp|lt|gt|quot|apos|#[0-9]{1,7}|#x[0-9a-fA-F]{1,6});)")
_WITHIN = re.compile(r"[\"'>]")
_APART = (("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"))


def escaped(text: str) -> tuple[str, list[int]]:
    """A text whose attributes are written as XML has them.

    Args:
        text: What a file holds.

    Returns:
        The text, line by line as before, and the lines in which something was written otherwise.
    """
    parts, lines, line = list[str](), list[int](), 1
    for part, may_hold in _parts(text):
        made = _LONE.sub("&amp;", part) if may_hold else part
        if may_hold and part[:1] in "\"'":
            made = made.replace("<", "&lt;")
        if made != part:
            lines += _lines(part, line)
        parts.append(made)
        line += part.count("\n")
    return "".join(parts), list(dict.fromkeys(lines))


def _lines(part: str, first: int) -> Iterator[int]:
    for number, each in enumerate(part.split("\n")):
        if "<" in each or _LONE.search(each):
            yield first + number


def _parts(text: str) -> Iterator[tuple[str, bool]]:
    """The text in pieces: values of attributes with their quotes and text between tags, and all else."""
    at, end = 0, len(text)
    while at < end:
        tag = text.find("<", at)
        if tag < 0:
            tag = end
        if tag > at:
            yield text[at:tag], True
        at = tag
        closing = next((close for begin, close in _APART if text.startswith(begin, at)), None)
        if closing is not None:
            found = text.find(closing, at)
            stop = end if found < 0 else found + len(closing)
            yield text[at:stop], False
            at = stop
        elif at < end:
            for piece, value in _tag(text, at):
                yield piece, value
                at += len(piece)


def _tag(text: str, begin: int) -> Iterator[tuple[str, bool]]:
    """A tag in pieces, up to its end or that of the text."""
    at = begin
    while (found := _WITHIN.search(text, at)) is not None:
        quote = found.start()
        if found[0] == ">":
            yield text[begin : quote + 1], False
            return
        yield text[begin:quote], False
        close = text.find(found[0], quote + 1)
        stop = len(text) if close < 0 else close + 1
        yield text[quote:stop], True
        begin = at = stop
    yield text[begin:], False
