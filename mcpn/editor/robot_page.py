"""The page of a mission that a robot runs: it shows each event as the controller takes it."""

from __future__ import annotations

import json
import threading
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from time import time
from typing import TYPE_CHECKING

from mcpn.errors import LimitError
from mcpn.report.page import page
from mcpn.robot.runtime.controller import Step
from mcpn.robot.runtime.journal import step_object
from mcpn.study import Study

if TYPE_CHECKING:
    pass
from mcpn.editor.page_server import Content, PageServer, ServedPage

SILENCE = 10.0
"""Seconds after which a stream on which nothing happens says so, so that one whose page is closed ends."""


LAST = 2.0
"""Seconds in which pages are notified of the end."""


class RobotPage(Content):
    """The page of a mission that a robot runs; its stream is the journal, a line for each event.

    Args:
        study: The mission.
        max_states: Limit on states that are listed.

    Raises:
        LimitError: Its controller is too large for a page.
    """

    def __init__(self, study: Study) -> None:
        found = study.findings()
        if found.controller is None:
            raise LimitError(f"--page: {'; '.join(found.notes) or 'the page has no controller'}")
        self.shown = ServedPage(1, page(found, robot=True), study, {})
        self._lines: list[str] = []
        self._ended: str | None = None
        self._listening = 0
        self._changed = threading.Condition()

    def __call__(self, step: Step) -> None:
        """Takes a step; give it to ``Controller.observe``."""
        line = json.dumps({"time": time(), **step_object(step)})
        with self._changed:
            self._lines.append(f"id: {len(self._lines) + 1}\ndata: {line}\n\n")
            self._changed.notify_all()

    def lost(self, what: str) -> None:
        """Tells of a record that cannot be written."""
        with self._changed:
            self._lines.append(f"id: {len(self._lines) + 1}\nevent: lost\ndata: {json.dumps(what)}\n\n")
            self._changed.notify_all()

    def end(self, outcome: str | None) -> None:
        """Tells that the robot has ended, and waits until all pages know it, but not for long."""
        with self._changed:
            self._ended = f"event: end\ndata: {json.dumps(outcome)}\n\n"
            self._changed.notify_all()
            self._changed.wait_for(lambda: not self._listening, LAST)

    def stream(self, after: int) -> Generator[str]:
        """The journal behind a line, as it grows."""
        with self._changed:
            self._listening += 1
        try:
            while True:
                with self._changed:
                    if not self._lines[after:] and self._ended is None:
                        self._changed.wait(SILENCE)
                    lines, ended = self._lines[after:], self._ended
                yield from lines or (":\n\n",)
                after += len(lines)
                if ended is not None:
                    yield ended
                    return
        finally:
            with self._changed:
                self._listening -= 1
                self._changed.notify_all()


@contextmanager
def attached(content: RobotPage, port: int = 0) -> Iterator[PageServer]:
    """Serves the page on threads of its own.

    Args:
        content: The page.
        port: The port; 0 for any that is free.

    Raises:
        OSError: The port cannot be listened on.
    """
    server = PageServer(content, port)
    serving = threading.Thread(target=server.run, daemon=True)
    serving.start()
    try:
        yield server
    finally:
        server.shutdown()
        serving.join()
