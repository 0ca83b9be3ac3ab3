"""The controller's document as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from io import StringIO
from typing import Any

from mcpn.robot.targets.rows import Rows

FILE_NAME = "controller.json"


def write_json(document: Mapping[str, Any]) -> str:
    """The document of a controller as a JSON text, the same for the same mission.

    Args:
        document: As :func:`mcpn.controller.document.document` makes it.

    Returns:
        The text, a line for each state, entry and edge, ending in a newline.
    """
    text = StringIO()  # whose pieces are not kept beside the text of all
    text.writelines(_pieces(document, 0, 3))
    text.write("\n")
    return text.getvalue()


def canonical(value: object) -> Iterator[str]:
    """JSON of which digests are made, piece by piece: without spaces, keys sorted."""
    if isinstance(value, dict) and any(isinstance(each, Rows) for each in value.values()):
        for number, key in enumerate(sorted(value)):
            yield f"{',' if number else '{'}{_CANONICAL(key)}:"
            yield from canonical(value[key])
        yield "}"
    elif isinstance(value, Rows):
        yield from value.pieces(_CANONICAL, ",", ":", ordered=True)
    else:
        yield _CANONICAL(value)


_CANONICAL = json.JSONEncoder(sort_keys=True, ensure_ascii=False, separators=(",", ":")).encode
_SPACED = json.JSONEncoder(ensure_ascii=False).encode


def _pieces(value: Any, depth: int, broken: int) -> Iterator[str]:
    """JSON with a line for each member down to some depth, and whole members below it."""
    if isinstance(value, Rows):
        yield from value.pieces(_SPACED, ", ", ": ", ordered=False)
        return
    if depth == broken or not isinstance(value, dict | list) or not value:
        yield _SPACED(value)
        return
    left, right = "{}" if isinstance(value, dict) else "[]"
    begin = f"{left}\n{' ' * (depth + 1)}"
    for member in value:
        yield begin
        if isinstance(value, dict):
            yield f"{_SPACED(member)}: "
            yield from _pieces(value[member], depth + 1, broken)
        else:
            yield from _pieces(member, depth + 1, broken)
        begin = f",\n{' ' * (depth + 1)}"
    yield f"\n{' ' * depth}{right}"
