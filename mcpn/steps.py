"""Which step of the work is under way: announced by what takes time, shown by who watches.

Steps are messages of the logger ``mcpn.steps`` at level INFO. Nobody hears them by default; a program that
uses the package as a library listens with a handler of its own. The command line listens without logging.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

HEARERS: list[Callable[[str], None]] = []
"""Who is told of each step, beside the logger."""


def step(doing: str) -> None:
    """Announces a step.

    Args:
        doing: What is being done, as in "exploring section dive".
    """
    for hear in HEARERS:
        hear(doing)
    if "logging" in sys.modules:  # else nobody has a handler
        import logging

        logging.getLogger("mcpn.steps").info("%s", doing)
