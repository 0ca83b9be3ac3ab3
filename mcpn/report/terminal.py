"""The terminal that reports are printed on: lines of words, columns of numbers.

Texts are shown as they are, markup included. Where a person watches, lines are wrapped between words at the
terminal's width and have colours, unless the environment sets ``NO_COLOR``; in a pipe or a file they are
whole and plain, so that other programs find names in them. ``mcpn --width N``, or
``COLUMNS`` in the environment, sets the width.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

LEAST_WIDTH = 40
WIDTH = "mcpn.width"
"""The key of the width in the context of a command."""


def plain(text: str) -> str:
    """A text with control and other unprintable characters escaped, so that no terminal interprets them."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def enough_digits() -> None:
    """Lets integers of any size be written: Python refuses more than 4,300 digits, counts may have more."""
    sys.set_int_max_str_digits(0)


def _decorated() -> bool:
    """Whether standard output is a terminal on which colours are wanted."""
    wanted = not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    return wanted and sys.stdout is not None and sys.stdout.isatty()


def _asked() -> int | None:
    """How many characters a line is to have, where the command line says so."""
    context = click.get_current_context(silent=True)
    return None if context is None else context.meta.get(WIDTH)


def _width() -> int:
    """How many characters a line may have."""
    from shutil import get_terminal_size  # which loads what packs and unpacks archives

    return max(LEAST_WIDTH, get_terminal_size().columns)


def _wrapped(text: str, width: int, first: int, others: int) -> list[str]:
    """A text in lines, the first and the others with so many spaces before them; names are never broken."""
    from textwrap import wrap

    return wrap(
        text,
        width,
        initial_indent=" " * first,
        subsequent_indent=" " * others,
        break_long_words=False,
        break_on_hyphens=False,
    ) or [""]


class Terminal:
    """Standard output, for people."""

    def __init__(self) -> None:
        enough_digits()
        self.colour = _decorated()
        self.watched = sys.stdout is not None and sys.stdout.isatty()
        bounded = self.watched or "COLUMNS" in os.environ
        self.width = _asked() or (_width() if bounded else None)

    def print(self, text: str = "", *, style: str | None = None, indent: int = 0, hang: int = 2) -> None:
        """Prints a text, wrapped between words; names are never broken.

        Args:
            text: What to print.
            style: A colour, ``bold`` or ``dim``; never the only carrier of information.
            indent: Spaces before its first line.
            hang: Spaces more before those that follow.
        """
        text = plain(text)
        lines = [" " * indent + text]
        if self.width is not None:
            lines = _wrapped(text, self.width, indent, indent + hang)
        for line in lines:
            click.echo(self._styled(line, style), color=self.colour)

    def _styled(self, line: str, style: str | None) -> str:
        if style is None or not self.colour:
            return line
        if style in ("bold", "dim"):
            return click.style(line, bold=style == "bold" or None, dim=style == "dim" or None)
        return click.style(line, fg=style)

    def columns(self, rows: Sequence[Sequence[str]], *, left: int = 1) -> None:
        """Prints rows in columns; where they are too wide, each row as a list of what its cells say.

        Args:
            rows: The heads, then the rows.
            left: So many columns are words, the others numbers.
        """
        rows = [[plain(cell) for cell in row] for row in rows]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        if self.width is not None and sum(widths) + 2 * len(widths) > self.width:
            heads, *records = rows
            for first, *others in records:
                self.print(first, indent=2)
                for head, cell in zip(heads[1:], others, strict=True):
                    if cell:
                        self.print(f"{head}: {cell}", indent=4)
            return
        for row in rows:
            cells = [
                cell.ljust(width) if number < left else cell.rjust(width)
                for number, (cell, width) in enumerate(zip(row, widths, strict=True))
            ]
            click.echo("  " + "  ".join(cells).rstrip())
