"""Parsing of untrusted XML: no DTD, no entities, no network, bounded size and depth, errors with lines."""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded


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


def _parsed(path: Path, data: bytes, encoding: str | None, *, whole: bool) -> etree._Element:
    # huge_tree stays off: libxml2 then refuses elements nested more than 256 deep.
    parser = etree.XMLParser(
        encoding=encoding,
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=not whole,
        remove_pis=not whole,
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        line = error.lineno or 1
        raise InputError.at(Source(str(path), line), f"not well-formed XML: {error.msg}") from error
    except (ValueError, LookupError) as error:
        raise InputError.at(Source(str(path), 1), f"not well-formed XML: {error}") from error
    if root.getroottree().docinfo.internalDTD is not None:
        found = "a document type declaration (DTD) is not allowed"
        raise InputError.at(Source(str(path), 1), f"{found}: files are untrusted")
    return root
