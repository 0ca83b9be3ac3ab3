"""Progress on a terminal for work of more than a second, and what is said of work that is interrupted."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from mcpn.spaces.engine_names import EXPLICIT, LOCAL, SYMBOLIC
from mcpn.steps import Doing, WorkStep, heard_by

SILENT_SECONDS = 1.0
"""Work that ends sooner shows no progress."""

ENGINES = (LOCAL, SYMBOLIC, EXPLICIT)
RUNNING = {
    Doing.MAKING_DIAGRAM: (SYMBOLIC,),
    Doing.LISTING: (EXPLICIT,),
    Doing.LISTING_MARKINGS: (EXPLICIT,),
    Doing.LISTING_SECTION: (LOCAL,),
    Doing.LEFT_OPEN: ENGINES,  # a diagram is drawn, markings are listed and searched, by turns
}
"""Engines that work in a step, and in those after it until another engine does: no hint names them."""

_TICK = 0.25


class UnderWay:
    """Keeps the step that was announced last (:mod:`mcpn.steps`), since when, and how far it is."""

    def __init__(self) -> None:
        self.step: WorkStep | None = None
        self.since = self.started = time.monotonic()
        self.explored = (0, 0)
        self.running: tuple[str, ...] = ()

    def begins(self, step: WorkStep) -> None:
        """Begins a step."""
        self.step, self.since, self.explored = step, time.monotonic(), (0, 0)
        self.running = RUNNING.get(step.doing, self.running)

    def comes_to(self, states: int, edges: int) -> None:
        """Notes how far it is."""
        self.explored = states, edges

    def line(self) -> str:
        """The step, and how far it is."""
        now = time.monotonic()
        spent = now - self.since
        name = "reading" if self.step is None else str(self.step)
        if self.explored == (0, 0):
            return f"{name}, {duration(spent)}; {duration(now - self.started)} in all"
        return f"{name}: {exploring(*self.explored, spent)}"

    def interrupted(self) -> list[str]:
        """What is said of work that ends before its time: the step, and what to try."""
        if self.step is None:
            return []
        now = time.monotonic()
        spent = f"{duration(now - self.since)} of {duration(now - self.started)}"
        lines = [f"while {self.step} ({spent})"]
        if self.step.doing is Doing.READING:
            return lines
        if self.step.doing is Doing.FINDING_CLASH:
            lines.append("the warnings above name what several activities want at the same time: begin there")
        elif self.step.section is not None:
            lines.append(
                f"if this step always takes the time, make section {self.step.section} smaller (fewer "
                'activities in one block, hardware with faulty="false") or check a mission with it alone'
            )
        elif others := [engine for engine in ENGINES if engine not in self.running]:
            lines.append(f"another engine may be quicker: --engine {' or '.join(others)}")
        return lines


_heard: list[UnderWay] = []
"""Listeners, the innermost last. After an interruption (Ctrl-C) those that listened then are still here."""


@contextmanager
def listening() -> Iterator[UnderWay]:
    """Listens to some work.

    Yields:
        Who listens.
    """
    heard = UnderWay()
    _heard.append(heard)
    try:
        with heard_by(heard):
            yield heard
        _heard.remove(heard)
    except Exception:
        _heard.remove(heard)
        raise


@contextmanager
def progress_on_terminal(quiet: bool = False) -> Iterator[None]:
    """A line on standard error that shows which step is under way and how far it is, where a person watches.

    Args:
        quiet: Whether nothing is shown; what an interruption ends is named all the same.
    """
    with listening() as heard:
        if quiet or sys.stderr is None or not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
            yield
            return
        with _shown(heard):
            yield


@contextmanager
def _shown(heard: UnderWay) -> Iterator[None]:
    """Shows a line again and again, after a second, and wipes it at the end."""
    from shutil import get_terminal_size  # which loads what packs and unpacks archives

    ended = threading.Event()
    wiped = "\r\x1b[K"

    def show() -> None:
        if ended.wait(SILENT_SECONDS):
            return
        while not ended.wait(_TICK):
            width = get_terminal_size().columns - 1
            sys.stderr.write(f"\r{heard.line()[:width]}\x1b[K")
            sys.stderr.flush()
        sys.stderr.write(wiped)
        sys.stderr.flush()

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(timeout=1)


def interrupted() -> list[str]:
    """What is said of the work that an interruption has ended, in lines."""
    return _heard[-1].interrupted() if _heard else []


def exploring(states: int, edges: int, seconds: float) -> str:
    """How far an exploration of unknown size is."""
    rate = f"{states / max(seconds, 1e-9):,.0f} states a second"
    return f"{states:,} states, {edges:,} edges, {rate}, {duration(seconds)}"


def duration(seconds: float) -> str:
    """Seconds as a person says them.

    >>> duration(3.6), duration(150), duration(7300)
    ('4 s', '2 min 30 s', '2 h 1 min')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
