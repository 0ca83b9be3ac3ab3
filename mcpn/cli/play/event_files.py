"""Runs that a file tells: events one after the other."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.events import Event, What
from mcpn.files import read_bounded
from mcpn.robot.runtime.journal import JournalError, read_journal


def events_of_file(path: Path) -> Iterator[tuple[int, Event | None, bool]]:
    """Reads a run: as other commands print it, a JSON list, or a journal of the runtime (JSON lines).

    Args:
        path: The file.

    Yields:
        A line, its event, ``None`` where a heading begins another run, and whether a controller refused it.

    Raises:
        InputError: A line holds no event.
    """
    try:
        text = read_bounded(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path)), f"expected text in UTF-8: {error.reason}") from error
    if text.lstrip().startswith("["):
        try:
            listed = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise InputError.at(
                Source(str(path), getattr(error, "lineno", None)), f"no JSON: {error}"
            ) from error
        if not all(isinstance(item, str) for item in listed):
            raise InputError.at(Source(str(path)), "expected a JSON list of events")
        yield from ((1, Event.parse(item), False) for item in listed)
        return
    if text.lstrip().startswith("{"):
        yield from _of_journal(path, text)
        return
    within_step = False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        # A step as other commands print it, perhaps on several lines: "1. GPS fails  [GPS_EV_OOS]".
        identifier = re.fullmatch(r".*\[([^\s\[]+)\]\s*", line)
        if identifier is not None:
            yield number, Event.parse(identifier[1]), False
        within_step = identifier is None and (within_step or re.fullmatch(r"\d+\.", words[0]) is not None)
        if identifier is not None or within_step:
            continue
        if line.rstrip().endswith(":") or words[0] == "run":
            yield number, None, False
        elif len(words) == 1 or Event.parse(words[0]).what is not What.DECLARED:
            yield number, Event.parse(words[0]), False
        else:
            expected = "expected an event, or a heading that ends in a colon"
            raise InputError.at(Source(str(path), number), f"found {words[0][:80]!r}, {expected}")


def _of_journal(path: Path, text: str) -> Iterator[tuple[int, Event | None, bool]]:
    try:
        for told in read_journal(text.splitlines()):
            yield told.line, Event.parse(told.event), told.refused
    except JournalError as error:
        raise InputError.at(Source(str(path), error.line), str(error)) from error
