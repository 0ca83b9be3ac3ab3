"""Checks a robot's log against requirements: ``python -m mcpn.robot.runtime monitors.json robot.log``."""

from __future__ import annotations

import sys
from pathlib import Path

from mcpn.robot.runtime.journal import JournalError
from mcpn.robot.runtime.monitors import Monitors, told, watch


def main(arguments: list[str]) -> int:
    """Reads a robot's log.

    Args:
        arguments: The file of monitors, and that of the log; standard input where that is left out.

    Returns:
        0, or 1 where a requirement is violated, or 2 where a file cannot be read.
    """
    if len(arguments) not in (1, 2):
        sys.stderr.write("usage: python -m mcpn.robot.runtime MONITORS [LOG]\n")
        return 2
    try:
        monitors = Monitors.load(arguments[0])
        if len(arguments) == 2:
            lines = Path(arguments[1]).read_text(encoding="utf-8").splitlines()
        else:
            if sys.stdin is None:
                raise ValueError("standard input is closed: expected a log there, or its file")
            lines = sys.stdin.read().splitlines()
        watch(monitors, lines)
    except JournalError as error:
        file = arguments[1] if len(arguments) == 2 else "standard input"
        sys.stderr.write(f"error: {file}:{error.line}: {error}\n")
        return 2
    except (OSError, ValueError) as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    for line in told(monitors):
        sys.stdout.write(f"{line}\n")
    return 1 if monitors.violated else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
