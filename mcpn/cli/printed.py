"""What commands print alike: JSON, counts, which engine answered, and the warnings of a mission."""

from __future__ import annotations

import sys
from math import isfinite
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from mcpn.drawing.compose import MissionNet
    from mcpn.spaces.engines import Choice, NoSpace


def choice_object(choice: Choice | NoSpace) -> dict[str, str | None]:
    """Which engine answered, and why it was asked; ``null`` where the user named it."""
    return {"engine": choice.engine, "why": choice.why}


def emit_json(document: object) -> None:
    """Prints one JSON value on standard output, in ASCII, integers of any size; what is not finite is null.

    Python refuses to write integers of more than 4,300 digits, for they may take long; counts may be larger.
    """
    import json

    sys.set_int_max_str_digits(0)
    try:
        text = json.dumps(document, allow_nan=False)
    except ValueError:
        text = json.dumps(_finite(document))
    click.echo(text)


def _finite(value: object) -> object:
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, dict):
        return {name: _finite(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    return value


def emit_counts(counts: dict[str, Any], as_json: bool) -> None:
    """Prints named numbers, as JSON or as a table."""
    if as_json:
        emit_json(counts)
    else:
        from mcpn.report.text import print_counts

        print_counts(counts)


def tell_warnings(mission_net: MissionNet) -> list[str]:
    """Says on standard error, before anything is explored, what is suspicious in a mission.

    Returns:
        These warnings: a report need not repeat them.
    """
    from mcpn.report.terminal import plain

    if sys.stderr is None:
        return []
    warnings = list(map(str, mission_net.warnings))
    for warning in warnings:
        click.echo(plain(f"warning: {warning}"), err=True)
    return warnings
