"""A controller as a program: it reads events and prints what it does."""

from __future__ import annotations

import logging
import sys
from collections.abc import Sequence

from mcpn.robot.runtime.actions import Action, Refused
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables


def run(tables: Tables, arguments: Sequence[str] = ()) -> None:
    """Reads events from standard input, one a line, and prints a line for each; an empty line begins again.

    A line says ``taken``, ``refused`` or ``unknown``, then the actions.

    Args:
        tables: The controller's.
        arguments: With any, a line also has the mode, the events that are possible next, and the outcome.
    """
    if sys.stdin is None:
        sys.stderr.write("error: standard input is closed: expected events there, one a line\n")
        sys.exit(2)
    # The lines say what was refused: it is not printed on standard error as well.
    logging.getLogger("mcpn.robot.runtime").addHandler(logging.NullHandler())
    controller = Controller(tables)
    for line in sys.stdin:
        event = line.rstrip("\n")
        if not event:
            controller = Controller(tables)
            continue
        actions: tuple[Action, ...] = ()
        try:
            actions, status = controller.handle(event), "taken"
        except Refused as refused:
            status = "refused" if refused.known else "unknown"
        rest = ""
        if arguments:
            mode = " ".join(f"{activity}.{way}" for activity, way in controller.mode.items())
            rest = f" | {mode} | {' '.join(controller.possible)} | {controller.outcome or '-'}"
        sys.stdout.write(f"{status}: {'; '.join(map(str, actions))}{rest}\n")
