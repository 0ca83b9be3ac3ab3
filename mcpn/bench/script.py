"""Scripts of faults: events with the hours at which they happen."""

from __future__ import annotations

from math import inf
from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.files import read_bounded
from mcpn.nets.events import Event, What


def read_script(path: Path) -> list[tuple[float, str]]:
    """Reads a script: on each line the hours since the start and an event; ``#`` begins a comment.

    Args:
        path: The file.

    Returns:
        The events in the order in which they happen.

    Raises:
        InputError: A line is of another form.
    """
    try:
        lines = read_bounded(path).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path)), f"expected text in UTF-8: {error.reason}") from error
    found: list[tuple[float, str]] = []
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            hours, event = float(words[0]), Event.parse(words[1])
        except (ValueError, IndexError):
            hours, event = -1.0, Event(What.NAMED, "")
        if len(words) != 2 or not 0 <= hours < inf or event.what is What.NAMED:
            message = f"found {line.strip()[:80]!r}, expected hours and an event, as in 0.5 GPS_EV_OOS"
            raise InputError.at(Source(str(path), number), message)
        found.append((hours, str(event)))
    return sorted(found, key=lambda step: step[0])
