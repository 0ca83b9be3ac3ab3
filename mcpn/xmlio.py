"""Parsing of untrusted XML: no DTD, no entities, no network, errors with lines; limits are the readers'."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded
from mcpn.misread import sentence


def parse_xml(path: Path, limit: int, text: str | None = None) -> etree._Element:
    """The root element of an XML file.

    Args:
        path: The file.
        limit: How many bytes it may have.
        text: Read this instead of what the file holds; errors say the file.

    Returns:
        The root. :func:`line_of` knows the lines of its elements as long as the root is held.

    Raises:
        InputError: The file cannot be read, is not well-formed XML, or has a document type declaration.
    """
    if text is None:
        return parse_bytes(path, read_bounded(path, limit))
    return parse_bytes(path, text.encode(), "utf-8")


def parse_bytes(path: Path, data: bytes, encoding: str | None = None) -> etree._Element:
    """The root element of what an XML file holds, or is to hold.

    Args:
        path: The file that errors say.
        data: What it holds.
        encoding: How that is encoded, whatever it says itself.

    Returns:
        As :func:`parse_xml`.

    Raises:
        InputError: As :func:`parse_xml`.
    """
    return _parsed(path, data, encoding, whole=False)


def parse_whole(text: str) -> etree._ElementTree:
    """The tree of a text with its comments and processing instructions, for whoever writes it again.

    Raises:
        InputError: As :func:`parse_xml`.
    """
    return _parsed(Path("text"), text.encode(), "utf-8", whole=True).getroottree()


def stream_xml(
    path: Path, limit: int, far: Callable[[int, int], None] = lambda read, size: None
) -> Iterator[tuple[str, etree._Element]]:
    """The elements of an XML file as they begin and end, so that no tree of a large file is kept.

    Args:
        path: The file.
        limit: How many bytes it may have.
        far: Told now and then how many bytes of how many have been read.

    Yields:
        ``start`` or ``end``, and the element, which has all that stands in it at its end alone. Who takes the
        end of an element may clear it, but for its tail, to which the parser may still add.

    Raises:
        InputError: As :func:`parse_xml`, when the place is reached.
    """
    data = read_bounded(path, limit)
    events = _events(path, data, None, far)
    if not _is_long(data):
        yield from events  # libxml2 knows all lines
        return
    kept: list[etree._Element] = []  # whose lines may be asked: elements in the tree
    begun: list[int] = []  # where in that list the open ones stand
    for event, element in events:
        if event == "start":
            begun.append(len(kept))
            kept.append(element)
            yield event, element
            continue
        yield event, element
        place = begun.pop()
        if not len(element):
            del kept[place + 1 :]
        if begun and element.getprevious() is None:
            del kept[begun[-1] + 1 : place]


def line_of(element: etree._Element) -> int:
    """The line on which the start tag of an element ends, however many lines the file has.

    libxml2 knows lines up to 65,534. Beyond, elements carry the lines that they were read on.

    Args:
        element: An element that a function of this module has given; of one that was not read the line is 1.
    """
    line = getattr(element, "line", None) or element.sourceline
    return line if isinstance(line, int) else 1


class _Numbered(etree.ElementBase):
    """An element of a file with so many lines that libxml2 does not know all: its own, where that is beyond.

    lxml makes such an object anew when nobody holds it, without a line: it must be held while that is asked.
    """

    __slots__ = ("held", "line")
    line: int
    held: list[etree._Element]


_KNOWN = 65_534
"""The last line that libxml2 knows."""
_CHUNK = 1 << 16
"""Bytes that are read before the elements in them are given."""
_TOLD = 1 << 22
"""Bytes after which progress in reading is reported."""


def _events(
    path: Path, data: bytes, encoding: str | None, far: Callable[[int, int], None] = lambda read, size: None
) -> Iterator[tuple[str, etree._Element]]:
    """What begins and ends in some data; an element that begins beyond what libxml2 knows has its line."""
    if long := _is_long(data):
        data, encoding = _by_bytes(data, encoding)
        long = _is_long(data)
    # huge_tree stays off: libxml2 then refuses elements nested more than 256 deep.
    parser = etree.XMLPullParser(
        events=("start", "end"),
        encoding=encoding,
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    if long:
        parser.set_element_class_lookup(etree.ElementDefaultClassLookup(element=_Numbered))
    first, read = True, 0
    for piece, line in _pieces(data, long=long):
        before, read = read, read + len(piece)
        if before // _TOLD < read // _TOLD:
            far(read, len(data))
        with _located(path, parser):
            parser.feed(piece)
            if read == len(data):
                parser.close()
        for event, element in parser.read_events():
            assert isinstance(element, etree._Element)
            if first:
                _refuse_dtd(path, element)
                first = False
            if event == "start":
                if line is not None and isinstance(element, _Numbered):
                    element.line = line
                _refuse_crowded(path, element)
            yield event, element


def _is_long(data: bytes) -> bool:
    return data.count(b"\n") >= _KNOWN


def _pieces(data: bytes, *, long: bool) -> Iterator[tuple[bytes, int | None]]:
    """What a parser is fed with, piece by piece, and the line of all start tags that end in a piece.

    That is ``None`` as far as libxml2 knows it.
    """
    at = 0
    for _ in range(_KNOWN if long else 0):
        at = data.index(b"\n", at) + 1
    known = at if long else len(data)
    for begin in range(0, known or 1, _CHUNK):
        yield data[begin : min(begin + _CHUNK, known)], None
    line = _KNOWN + 1
    while known < len(data):
        # A tag ends with >: none ends before the next one, and all up to the end of its line on that line.
        tag = data.find(b">", known)
        tag = len(data) if tag < 0 else tag
        line += data.count(b"\n", known, tag)
        end = data.find(b"\n", tag) + 1 or len(data)
        for begin in range(known, end, _CHUNK):
            yield data[begin : min(begin + _CHUNK, end)], line
        known, line = end, line + 1


def _by_bytes(data: bytes, encoding: str | None) -> tuple[bytes, str | None]:
    """Data and its encoding; for UTF-16 and UTF-32, in which other signs hold bytes of line ends, UTF-8."""
    if encoding is None and 0 in data[:4]:
        import json

        try:
            return data.decode(json.detect_encoding(data)).encode(), "utf-8"
        except UnicodeDecodeError:
            pass  # libxml2 says where
    return data, encoding


def _parsed(path: Path, data: bytes, encoding: str | None, *, whole: bool) -> etree._Element:
    if not whole and _is_long(data):
        root, *inside = (element for event, element in _events(path, data, encoding) if event == "start")
        if isinstance(root, _Numbered):
            root.held = inside
        return root
    parser = etree.XMLParser(
        encoding=encoding,
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=not whole,
        remove_pis=not whole,
    )
    with _located(path):
        root = etree.fromstring(data, parser)
    _refuse_dtd(path, root)
    if _is_crowded(root):
        for element in root.iter("*"):
            _refuse_crowded(path, element)
    return root


@contextmanager
def _located(path: Path, fed: etree.XMLPullParser | None = None) -> Iterator[None]:
    """Tells errors of the parser with the file and the line; of one that is fed its log may say more."""
    try:
        yield
    except etree.XMLSyntaxError as error:
        line, said = error.lineno, error.msg
        if not line and fed is not None:
            line, said = next(((e.line, e.message) for e in fed.feed_error_log), (1, said))
        raise InputError.at(Source(str(path), line or 1), sentence(str(said))) from error
    except (ValueError, LookupError) as error:
        raise InputError.at(Source(str(path), 1), sentence(str(error))) from error


MOST_ATTRIBUTES = 1000
"""On one element: to read them takes time in proportion to their square, in libxml2 and lxml."""
_is_crowded = etree.XPath(f"boolean(//*[count(@*) > {MOST_ATTRIBUTES}])")


def _refuse_crowded(path: Path, element: etree._Element) -> None:
    if len(element.attrib) > MOST_ATTRIBUTES:
        found = f"found {len(element.attrib)} attributes on one element"
        raise InputError.at(
            Source(str(path), line_of(element)), f"{found}, expected at most {MOST_ATTRIBUTES}"
        )


def _refuse_dtd(path: Path, element: etree._Element) -> None:
    if element.getroottree().docinfo.internalDTD is not None:
        said = "found a document type declaration (DTD), expected none: files are untrusted"
        raise InputError.at(Source(str(path), 1), said)
