"""What a run shows on the terminal, on a thread of its own: no terminal that stands still stops a robot."""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcpn.runtime.controller import Step

MOST = 1000
"""Lines of drivers that wait to be shown; more are counted alone."""
LAST = 5.0
"""Seconds that the terminal has at the end to show what waits."""


class EventLines:
    """What happens, on the terminal: each event with its actions, and what runs then."""

    def __init__(self) -> None:
        from mcpn.report.terminal import Terminal

        self._terminal = Terminal()
        self._began = time.monotonic()
        self._runs = ""
        self._waiting: deque[tuple[str, dict[str, Any]]] = deque()
        self._changed = threading.Condition()
        self._left_out = 0
        self._closed = False
        self.lost: OSError | None = None
        """Why standard output shows no more."""
        self._thread = threading.Thread(target=self._print, daemon=True)
        self._thread.start()

    def __call__(self, step: Step) -> None:
        """Shows an event."""
        at = f"{time.monotonic() - self._began:8.2f} s  {step.event}"
        if not step.taken:
            self._put(f"{at}: not possible now", style="yellow")
            return
        actions = "; ".join(map(str, step.actions)) or "nothing to do"
        self._put(f"{at}: {actions}")
        inside = step.after.inside
        mode = ", ".join(name if name == way else f"{name} ({way})" for name, way in inside.mode.items())
        ended = "" if step.after.phase == "running" else step.after.phase
        runs = ended or f"{', '.join(inside.objectives)}: {mode or 'nothing'}"
        if runs != self._runs:
            self._put(f"runs {runs}" if not ended else runs, style="bold", indent=12)
            self._runs = runs

    def line(self, name: str, line: str) -> None:
        """Shows what a driver says that tells no event."""
        with self._changed:
            if len(self._waiting) >= MOST:
                self._left_out += 1
                return
        self._put(f"{name}: {line}", style="dim", indent=12)

    def close(self) -> None:
        """Waits until all is shown, but not for long."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        self._thread.join(LAST)

    def _put(self, text: str, **how: Any) -> None:
        with self._changed:
            if self._left_out:
                self._waiting.append((f"({self._left_out:,} lines of drivers are not shown)", {"indent": 12}))
                self._left_out = 0
            self._waiting.append((text, how))
            self._changed.notify()

    def _print(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._closed)
                if not self._waiting:
                    return
                text, how = self._waiting.popleft()
            if self.lost is None:
                try:
                    self._terminal.print(text, **how)
                except OSError as error:
                    self.lost = error
