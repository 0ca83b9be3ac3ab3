"""Which step of the work is under way: announced by what takes time, shown by who watches.

Steps are messages of the logger ``mcpn.steps`` at level INFO. Nobody hears them by default; a program that
uses the package as a library listens with a handler of its own.
"""

from __future__ import annotations

import logging

STEPS = logging.getLogger("mcpn.steps")


def step(doing: str) -> None:
    """Announces a step.

    Args:
        doing: What is being done, as in "exploring section dive".
    """
    STEPS.info("%s", doing)
