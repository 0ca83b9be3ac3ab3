"""Templates, scripts and styles of pages and pictures; templates escape every text."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def environment() -> Environment:
    """The template engine for the files of this folder."""
    made = Environment(
        loader=PackageLoader("mcpn.report", "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["number"] = lambda value: f"{round(value, 1):g}" if abs(value) < 1e5 else f"{value:.0f}"
    made.filters["css_string"] = css_string
    return made


def css_string(text: str) -> str:
    r"""A text as a string of CSS, in which nothing can end it.

    >>> print(css_string('mission a"</b'))
    "mission a\22 \3c \2f b"
    """
    plain = (c if (c.isascii() and c.isalnum()) or c in " .,:-_" else f"\\{ord(c):x} " for c in text)
    return f'"{"".join(plain)}"'
