"""Templates of pages and pictures, and how they are filled in: every text is escaped."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def environment() -> Environment:
    """What fills in the templates."""
    made = Environment(
        loader=PackageLoader("mcpn.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["number"] = lambda value: f"{round(value, 1):g}" if abs(value) < 1e5 else f"{value:.0f}"
    return made
