"""What a run shows on the terminal, on threads of their own: no terminal that stands still stops a robot."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from mcpn.robot.runtime.controller import Step


MOST = 1000
"""Lines that wait to be shown, from which on those that may be left out are counted alone."""
LAST = 5.0
"""Seconds that the terminal has at the end to show what waits."""


class ShownLines:
    """Lines that a thread shows, in their order.

    Args:
        show: Shows a line; called on that thread. Where it raises, nothing more is shown.
        many: What is shown in the place of lines that were left out, from their number.
    """

    def __init__(self, show: Callable[..., object], many: Callable[[int], str]) -> None:
        self._show, self._many = show, many
        self._waiting: deque[tuple[str, dict[str, Any]]] = deque()
        self._changed = threading.Condition()
        self._untold = 0
        self._closed = False
        self.left_out = 0
        """How many lines were left out."""
        self.lost: OSError | None = None
        """Why nothing further is shown."""
        self._thread = threading.Thread(target=self._print, daemon=True)
        self._thread.start()

    def put(self, text: str, **how: Any) -> None:
        """Has a line shown."""
        with self._changed:
            self._tell_left_out()
            self._waiting.append((text, how))
            self._changed.notify()

    def offer(self, text: str, **how: Any) -> None:
        """Has a line shown, unless too many wait."""
        with self._changed:
            if len(self._waiting) >= MOST:
                self._untold += 1
                self.left_out += 1
                return
        self.put(text, **how)

    def close(self) -> None:
        """Waits until all is shown, but not for long."""
        with self._changed:
            if self._closed:
                return
            self._tell_left_out()
            self._closed = True
            self._changed.notify()
        self._thread.join(LAST)

    def _tell_left_out(self) -> None:
        if self._untold:
            self._waiting.append((self._many(self._untold), {}))
            self._untold = 0

    def _print(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closed)
                if not self._waiting:
                    return
                text, how = self._waiting.popleft()
            if self.lost is None:
                try:
                    self._show(text, **how)
                except OSError as error:
                    self.lost = error


class EventLines:
    """What happens, on the terminal: each event with its actions, and what runs then."""

    def __init__(self) -> None:
        from mcpn.report.terminal import Terminal

        self._began = time.monotonic()
        self._runs = ""
        self._lines = ShownLines(
            Terminal().print, lambda count: f"({count:,} lines of drivers are not shown)"
        )
        self.close = self._lines.close

    def __call__(self, step: Step) -> None:
        """Shows an event."""
        at = f"{time.monotonic() - self._began:8.2f} s  {step.event}"
        if not step.taken:
            self._lines.put(f"{at}: not possible now", style="yellow")
            return
        actions = "; ".join(map(str, step.actions)) or "nothing to do"
        self._lines.put(f"{at}: {actions}")
        inside = step.after.inside
        mode = ", ".join(name if name == way else f"{name} ({way})" for name, way in inside.mode.items())
        ended = "" if step.after.phase == "running" else step.after.phase
        runs = ended or f"{', '.join(inside.objectives)}: {mode or 'nothing'}"
        if runs != self._runs:
            self._lines.put(f"runs {runs}" if not ended else runs, style="bold", indent=12)
            self._runs = runs

    def line(self, name: str, line: str) -> None:
        """Shows output of a driver that is no event."""
        self._lines.offer(f"{name}: {line}", style="dim", indent=12)

    @property
    def lost(self) -> OSError | None:
        """Why standard output shows nothing further."""
        return self._lines.lost


class WarningLines(logging.Handler):
    """Warnings on standard error; those that it does not take in time are counted."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._lines = ShownLines(
            lambda text: click.echo(text, err=True),
            lambda count: f"warning: {count:,} warnings are not shown",
        )

    def emit(self, record: logging.LogRecord) -> None:
        """Has a warning shown."""
        self._lines.offer(f"{record.levelname.lower()}: {record.getMessage()}")

    @property
    def left_out(self) -> int:
        """How many warnings were not shown."""
        return self._lines.left_out

    def close(self) -> None:
        """Waits until all is shown, but not for long."""
        self._lines.close()
        super().close()
