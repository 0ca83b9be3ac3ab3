"""Scripts of faults: events with the hours at which they happen."""

from __future__ import annotations

from collections.abc import Collection
from math import inf
from pathlib import Path

from mcpn.did_you_mean import did_you_mean
from mcpn.errors import InputError, Source
from mcpn.files import read_bounded
from mcpn.robot.runtime.actions import spelled


def read_script(path: Path, known: Collection[str]) -> list[tuple[float, str]]:
    """Reads a script: on each line the hours since the start and an event; ``#`` begins a comment.

    Args:
        path: The file.
        known: The events of the mission.

    Returns:
        The events in the order in which they happen.

    Raises:
        InputError: A line is of another form, or its event is none of the mission.
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
            hours, event = float(words[0]), words[1]
        except (ValueError, IndexError):
            hours, event = -1.0, ""
        if len(words) != 2 or not 0 <= hours < inf:
            message = f"found {line.strip()[:80]!r}, expected hours and an event, as in 0.5 GPS_EV_OOS"
            raise InputError.at(Source(str(path), number), message)
        event = spelled(event, known)
        if event not in known:
            message = f"found {event[:80]!r}, which is no event of the mission{did_you_mean(event, known)}"
            raise InputError.at(Source(str(path), number), message)
        found.append((hours, event))
    return sorted(found, key=lambda step: step[0])
