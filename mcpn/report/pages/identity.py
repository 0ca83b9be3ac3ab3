"""Where a report comes from, for its printed head: tool, date, engine, proof, digest of the sources."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from mcpn import __version__
from mcpn.errors import InputError
from mcpn.mission.model import Mission

if TYPE_CHECKING:
    from mcpn.findings import Findings

EPOCH = "SOURCE_DATE_EPOCH"
"""Environment variable: seconds since 1970 that pages say in place of the time now, so that they can be made
again byte by byte (reproducible-builds.org)."""

MOST_DIGITS = 16
"""Digits of the digest that a page shows; the tooltip has all of them."""


def identity(findings: Findings) -> Iterator[tuple[str, str, str]]:
    """The lines of the head of a page: name, value, and the text of the tooltip."""
    check = findings.check
    yield "made", f"{date()} by mcpn {__version__}", ""
    yield "engine", findings.engine, check.choice.why or "it was named"
    confluent = check.verdicts["confluent"]
    if confluent.holds:
        yield "proof", confluent.explanation, ""
    digest, files = digest_of(check.mission_net.mission)
    if files:
        shown = f"SHA-256 {digest[:MOST_DIGITS]} of {', '.join(Path(file).name for file in files)}"
        yield "sources", shown, f"{digest}: cat {' '.join(files)} | sha256sum"


def date() -> str:
    """The day and time of a page, of the world's clock (UTC).

    Raises:
        InputError: The environment variable that sets it is no number of seconds.
    """
    said = os.environ.get(EPOCH)
    if not said:
        return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
    try:
        return time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime(int(said)))
    except (ValueError, OverflowError, OSError) as error:
        message = f"found {EPOCH}={said[:40]!r} in the environment, expected seconds since 1970"
        raise InputError.at(None, message) from error


def files_of(mission: Mission) -> list[str]:
    """The files in which the elements of a mission stand, its own first; none of one built in Python."""
    elements = (mission, *mission.robots, *mission.protocols, *mission.requirements, *mission.blocks)
    return list(dict.fromkeys(element.source.file for element in elements if element.source))


def digest_of(mission: Mission) -> tuple[str, list[str]]:
    """The SHA-256 of the files of a mission one after the other, and their names; none where one is gone."""
    found, files = hashlib.sha256(), files_of(mission)
    try:
        for file in files:
            found.update(Path(file).read_bytes())
    except OSError:
        return "", []
    return (found.hexdigest(), files) if files else ("", [])
