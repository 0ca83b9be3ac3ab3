"""Reads and writes nets by the suffix of their file; each format has one reader and one writer."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded, write_atomically
from mcpn.nets.petri import PetriNet


def _pnml(path: Path) -> PetriNet:
    from mcpn.nets.formats.pnml import read_pnml

    return read_pnml(path)


def _to_pnml(net: PetriNet) -> bytes:
    from mcpn.nets.formats.pnml_writer import write_pnml

    return write_pnml(net)


def _tina(path: Path) -> PetriNet:
    from mcpn.nets.formats.tina import read_tina

    return read_tina(path, read_bounded(path))


def _to_tina(net: PetriNet) -> str:
    from mcpn.nets.formats.tina import write_tina

    return write_tina(net)


def _to_dot(net: PetriNet) -> str:
    from mcpn.nets.formats.dot import write_dot

    return write_dot(net)


def _json(path: Path) -> PetriNet:
    from mcpn.nets.formats.json import read_json

    return read_json(path, read_bounded(path))


def _to_json(net: PetriNet) -> str:
    from mcpn.nets.formats.json import write_json

    return write_json(net)


class NetFormat(NamedTuple):
    """A format of nets; its module is loaded when a file of it is read or written.

    Args:
        read: Reads a file; ``None`` where nets are only written so.
        write: The text or bytes of a net; ``None`` where nets are only read so.
        priorities: How priorities are written beyond the standard, if they are; whoever writes is warned.
    """

    read: Callable[[Path], PetriNet] | None
    write: Callable[[PetriNet], str | bytes] | None
    priorities: str = ""


NET_FORMATS: Mapping[str, NetFormat] = {
    ".pnml": NetFormat(
        _pnml, _to_pnml, "standard PNML has no priorities; they are written as toolspecific of mcpn"
    ),
    ".net": NetFormat(_tina, _to_tina),
    ".dot": NetFormat(None, _to_dot),
    ".json": NetFormat(_json, _to_json),
}
"""The formats by the suffixes of their files."""
READABLE = tuple(suffix for suffix, form in NET_FORMATS.items() if form.read)
WRITABLE = tuple(suffix for suffix, form in NET_FORMATS.items() if form.write)

FOREIGN = {
    ".ndr": "a drawing of TINA: its program ndrio writes it as .net (ndrio FILE.ndr FILE.net)",
    ".tpn": "a net with time of TINA or Romeo, which is not read",
    ".tapn": "a file of TAPAAL's editor: it exports nets without time as .pnml (File, Export)",
    ".xtapn": "a file of TAPAAL's editor: it exports nets without time as .pnml (File, Export)",
    ".lola": "a net of LoLA, which is not read: write it as .net or .pnml",
    ".llnet": "a net of LoLA or PEP, which is not read: write it as .net or .pnml",
    ".ll_net": "a net of PEP, which is not read: write it as .net or .pnml",
    ".pnpro": "a file of GreatSPN's editor: it exports nets as .pnml (File, Export)",
    ".gspn": "a net of GreatSPN: its editor exports nets as .pnml (File, Export)",
    ".cpn": "a coloured net of CPN Tools: colours are not read",
    ".spept": "a net of Snoopy: it exports nets as .pnml or .net",
    ".spn": "a net of Snoopy: it exports nets as .pnml or .net",
    ".andl": "a net of Snoopy or MARCIE: Snoopy exports nets as .pnml",
    ".apnn": "a net of APNN, which is not read: write it as .net or .pnml",
    ".apt": "a net of APT, which is not read: write it as .net or .pnml",
    ".g": "a net of Petrify, which is not read: write it as .net or .pnml",
    ".pnt": "a net of INA, which is not read: write it as .net or .pnml",
    ".rnw": "a drawing of Renew: it exports nets as .pnml (File, Export)",
    ".work": "a file of Workcraft, which is not read: write it as .net or .pnml",
    ".pn": "a net of another tool, which is not read: write it as .net or .pnml",
}
"""By suffix of files that other tools keep nets in, what they are and what to do."""


_BEGINS_AS_PNML = rb"(?:\xef\xbb\xbf)?\s*(?:<\?[^>]*>\s*|<!--(?:(?!-->).)*-->\s*)*<pnml\b"


def refuse_foreign(path: Path) -> None:
    """Refuses files that other tools keep nets in, by a sentence that says what to do.

    Raises:
        InputError: It is such a file; or PNML by a name that says something else.
    """
    if known := FOREIGN.get(path.suffix.lower()):
        raise InputError.at(Source(str(path)), f"found {known}; expected {', '.join(READABLE)}")
    try:
        with path.open("rb") as file:
            begin = file.read(4096)
    except OSError:
        return  # which is told where it is read
    if re.match(_BEGINS_AS_PNML, begin, re.DOTALL):
        said = f"found <pnml> in a file {path.suffix or 'without a suffix'}, expected the suffix .pnml"
        raise InputError.at(Source(str(path)), said)


def read_net(path: Path | str) -> PetriNet:
    """Reads a net from a file of one of the formats in :data:`READABLE`.

    Args:
        path: The file.

    Returns:
        The net.

    Raises:
        InputError: With file and line; also for a suffix of no known format.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix in READABLE and (read := NET_FORMATS[suffix].read):
        return read(path)
    refuse_foreign(path)
    known = ", ".join(READABLE)
    raise InputError.at(
        Source(str(path)), f"found an unknown kind of net {suffix or path.name!r}, expected {known}"
    )


def save_net(net: PetriNet, path: Path | str) -> str | None:
    """Writes a net to a file of one of the formats in :data:`WRITABLE`, whole or not at all.

    Args:
        net: The net.
        path: The file.

    Returns:
        A warning where the format cannot say all of the net in its standard part, else ``None``.

    Raises:
        InputError: The file cannot be written, or its suffix is of no known format.
    """
    path = Path(path)
    form = NET_FORMATS.get(path.suffix.lower())
    if form is None or form.write is None:
        known = ", ".join(WRITABLE)
        raise InputError.at(
            Source(str(path)), f"unknown kind of file {path.suffix.lower() or path.name!r}, expected {known}"
        )
    write_atomically(path, form.write(net))
    if net.priorities and form.priorities:
        return f"{path}: {form.priorities}"
    if net.complements:
        return f"{path}: inhibitor arcs are written as arcs of {len(net.complements)} complement places"
    return None
