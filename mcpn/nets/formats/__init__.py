"""One reader and one writer per net format, chosen by a file's suffix."""

from __future__ import annotations

from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded, write_atomically
from mcpn.nets.petri import PetriNet

READABLE = (".pnml", ".net", ".json")
WRITABLE = (".pnml", ".net", ".dot", ".json")


def read_net(path: Path | str) -> PetriNet:
    """Reads a net from a ``.pnml``, ``.net`` or ``.json`` file.

    Args:
        path: The file.

    Returns:
        The net.

    Raises:
        InputError: With file and line; also for a suffix of no known format.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".pnml":
        from mcpn.nets.formats.pnml import read_pnml

        return read_pnml(path)
    if suffix == ".net":
        from mcpn.nets.formats.tina import read_tina

        return read_tina(path, read_bounded(path))
    if suffix == ".json":
        from mcpn.nets.formats.json import read_json

        return read_json(path, read_bounded(path))
    known = ", ".join(READABLE)
    raise InputError.at(Source(str(path)), f"unknown kind of net {suffix or path.name!r}, expected {known}")


def save_net(net: PetriNet, path: Path | str) -> str | None:
    """Writes a net to a ``.pnml``, ``.net``, ``.dot`` or ``.json`` file, whole or not at all.

    Args:
        net: The net.
        path: The file.

    Returns:
        A warning where the format cannot say all of the net in its standard part, else ``None``.

    Raises:
        InputError: The file cannot be written, or its suffix is of no known format.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    warning = None
    if suffix == ".pnml":
        from mcpn.nets.formats.pnml import write_pnml

        write_atomically(path, write_pnml(net))
        if net.priorities:
            warning = f"{path}: standard PNML has no priorities; they are written as toolspecific of mcpn"
    elif suffix == ".net":
        from mcpn.nets.formats.tina import write_tina

        write_atomically(path, write_tina(net))
    elif suffix == ".dot":
        from mcpn.nets.formats.dot import write_dot

        write_atomically(path, write_dot(net))
    elif suffix == ".json":
        from mcpn.nets.formats.json import write_json

        write_atomically(path, write_json(net))
    else:
        known = ", ".join(WRITABLE)
        raise InputError.at(
            Source(str(path)), f"unknown kind of file {suffix or path.name!r}, expected {known}"
        )
    return warning
