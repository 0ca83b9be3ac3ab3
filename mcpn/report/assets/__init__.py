"""What pages and pictures are made of, and how it is filled in: every text is escaped."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def environment() -> Environment:
    """What fills in the files of this folder."""
    made = Environment(
        loader=PackageLoader("mcpn.report", "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["number"] = lambda value: f"{round(value, 1):g}" if abs(value) < 1e5 else f"{value:.0f}"
    return made
