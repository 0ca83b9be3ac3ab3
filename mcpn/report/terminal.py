"""The terminal that reports are printed on: plain texts, never markup; no colour where none is wanted."""

from __future__ import annotations

import os
import sys
from errno import EPIPE

from rich.console import Console


class _Terminal(Console):
    """A console that leaves a pipe closed by its reader to whoever runs the command."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError(EPIPE, os.strerror(EPIPE))


def terminal(*, error: bool = False) -> Console:
    """Standard output, or standard error, as reports need it.

    Texts are shown as they are: paths may hold what rich takes for markup. Escape sequences are
    written to terminals only, and not where the environment sets ``NO_COLOR``. Integers have any size: Python
    refuses to write more than 4,300 digits unless told otherwise.

    Args:
        error: Whether standard error is meant.
    """
    sys.set_int_max_str_digits(0)
    return _Terminal(
        stderr=error,
        markup=False,
        emoji=False,
        highlight=False,
        soft_wrap=True,
        color_system=None if os.environ.get("NO_COLOR") else "auto",
    )
