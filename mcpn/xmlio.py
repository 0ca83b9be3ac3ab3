"""Parsing of untrusted XML: no DTD, no entities, no network, bounded size and depth, errors with lines."""

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
        The root; its elements carry their lines.

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
    """The tree of a text with its comments and processing instructions, for who writes it again.

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
    # huge_tree stays off: libxml2 then refuses elements nested more than 256 deep.
    parser = etree.XMLPullParser(
        events=("start", "end"),
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    data, first = read_bounded(path, limit), True
    for begin in range(0, len(data) + 1, _CHUNK):
        if begin and not begin % _TOLD:
            far(begin, len(data))
        with _located(path, parser):
            parser.feed(data[begin : begin + _CHUNK])
            if begin + _CHUNK > len(data):
                parser.close()
        for event, element in parser.read_events():
            assert isinstance(element, etree._Element)
            if first:
                _refuse_dtd(path, element)
                first = False
            if event == "start":
                _refuse_crowded(path, element)
            yield str(event), element


_CHUNK = 1 << 16
"""Bytes that are read before the elements in them are given."""
_TOLD = 1 << 22
"""Bytes after which progress in reading is reported."""


def _parsed(path: Path, data: bytes, encoding: str | None, *, whole: bool) -> etree._Element:
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
        line = element.sourceline if isinstance(element.sourceline, int) else 1
        found = f"found {len(element.attrib)} attributes on one element"
        raise InputError.at(Source(str(path), line), f"{found}, expected at most {MOST_ATTRIBUTES}")


def _refuse_dtd(path: Path, element: etree._Element) -> None:
    if element.getroottree().docinfo.internalDTD is not None:
        found = "a document type declaration (DTD) is not allowed"
        raise InputError.at(Source(str(path), 1), f"{found}: files are untrusted")
