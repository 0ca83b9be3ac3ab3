"""The controller's document as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

FILE_NAME = "controller.json"


def write_json(document: Mapping[str, Any]) -> str:
    """The document of a controller as a JSON text, the same for the same mission.

    Args:
        document: As :func:`mcpn.controller.document.document` makes it.

    Returns:
        The text, a line for each state, entry and edge, ending in a newline.
    """
    return _text(document, 0, 3) + "\n"


def _text(value: Any, depth: int, broken: int) -> str:
    """JSON with a line for each member down to some depth, and whole members below it."""
    if depth == broken or not isinstance(value, dict | list) or not value:
        return json.dumps(value, ensure_ascii=False)
    inner = " " * (depth + 1)
    if isinstance(value, dict):
        members = [
            f"{json.dumps(key, ensure_ascii=False)}: {_text(member, depth + 1, broken)}"
            for key, member in value.items()
        ]
    else:
        members = [_text(member, depth + 1, broken) for member in value]
    left, right = "{}" if isinstance(value, dict) else "[]"
    return f"{left}\n{inner}" + f",\n{inner}".join(members) + f"\n{' ' * depth}{right}"
