"""Shows progress on one line of standard error, on a terminal, for work of more than a second."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mcpn.steps import HEARERS, Doing, WorkStep

SILENT_SECONDS = 1.0
"""Work that ends sooner shows no progress."""

_TICK = 0.25


@contextmanager
def progress_on_terminal(
    describe: Callable[[int, int, float], str],
) -> Iterator[Callable[[int, int], None] | None]:
    """A line on standard error that says how far the work is, after a second, where a person watches.

    Args:
        describe: Says so from the two numbers of a progress callback and the seconds since the start.

    Yields:
        The callback, or ``None`` where nobody watches.
    """
    if sys.stderr is None or not sys.stderr.isatty() or os.environ.get("TERM") == "dumb":
        yield None
        return
    from shutil import get_terminal_size  # which loads what packs and unpacks archives

    started = time.monotonic()
    latest = (0, 0)
    ended = threading.Event()

    def show() -> None:
        wait = SILENT_SECONDS
        while not ended.wait(wait):
            wait = _TICK
            text = describe(*latest, time.monotonic() - started)
            width = get_terminal_size().columns - 1
            sys.stderr.write(f"\r{text[:width]}\x1b[K")
            sys.stderr.flush()
        if time.monotonic() - started > SILENT_SECONDS:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def update(one: int, other: int) -> None:
        nonlocal latest
        latest = one, other

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield update
    finally:
        ended.set()
        thread.join(timeout=1)


class UnderWay:
    """Keeps the step that was announced last (:mod:`mcpn.steps`), and since when it is under way."""

    def __init__(self) -> None:
        self.step: WorkStep | None = None
        self.since = self.started = time.monotonic()
        self._before = (0, 0)
        self._latest = (0, 0)

    def hear(self, step: WorkStep) -> None:
        """Begins a step; numbers that were told before are not its own."""
        self.step, self.since, self._before = step, time.monotonic(), self._latest

    def telling(self, told: Callable[[int, int, float], str]) -> Callable[[int, int, float], str]:
        """What a line says: the step, and how far it is where it has told numbers of its own.

        Args:
            told: Says what the two numbers of a progress callback mean.
        """

        def line(one: int, other: int, seconds: float) -> str:
            self._latest = one, other
            if self.step is None:
                return told(one, other, seconds)
            spent = time.monotonic() - self.since
            if told is sections or self._latest == self._before:
                return f"{self.step}, {duration(spent)}; {duration(seconds)} in all"
            return f"{self.step}: {told(one, other, spent)}"

        return line

    def interrupted(self) -> list[str]:
        """What is said of work that ends before its time: the step, and what to try."""
        if self.step is None:
            return []
        now = time.monotonic()
        spent = f"{duration(now - self.since)} of {duration(now - self.started)}"
        lines = [f"while {self.step} ({spent})"]
        if self.step.doing is Doing.FINDING_CLASH:
            lines.append("the warnings above name what several activities want at the same time: begin there")
        elif self.step.section is not None:
            lines.append(
                f"if this step always takes the time, make section {self.step.section} smaller (fewer "
                'activities in one block, hardware with faulty="false") or check a mission with it alone'
            )
        else:
            lines.append("another engine may be quicker: --engine local, symbolic or explicit")
        return lines


_heard: list[UnderWay] = []
"""Listeners, the innermost last. After an interruption (Ctrl-C) those that listened then are still here."""


@contextmanager
def listening() -> Iterator[UnderWay]:
    """Hears the steps of some work.

    Yields:
        Who hears them.
    """
    heard = UnderWay()
    HEARERS.append(heard.hear)
    _heard.append(heard)
    try:
        yield heard
        _heard.remove(heard)
    except Exception:
        _heard.remove(heard)
        raise
    finally:
        HEARERS.remove(heard.hear)


def interrupted() -> list[str]:
    """What is said of the work that an interruption has ended, in lines."""
    return _heard[-1].interrupted() if _heard else []


class Steps:
    """Which step of some work is under way, and how far it is where it has a count.

    Args:
        heard: Who hears the steps within it.
    """

    def __init__(self, heard: UnderWay | None = None) -> None:
        self.heard = heard
        self._name, self._since = "reading", time.monotonic()
        self._told: Callable[[int, int, float], str] | None = None
        self._at = (0, 0)

    def begin(self, name: str, told: Callable[[int, int, float], str] | None = None) -> None:
        """Begins a step.

        Args:
            name: What it finds.
            told: Says what the two numbers of :meth:`at` mean: :func:`counted` or :func:`exploring`; ``None``
                where the step has no count.
        """
        self._name, self._since, self._told, self._at = name, time.monotonic(), told, (0, 0)

    def at(self, one: int, other: int) -> None:
        """Says how far the step is: a progress callback."""
        self._at = one, other

    def line(self, seconds: float) -> str:
        """The step and how far it is, after so many seconds of the whole work."""
        spent = time.monotonic() - self._since
        if self.heard is not None and self.heard.step is not None and self.heard.since >= self._since:
            how_far = f"{self._name}: {self.heard.step}, {duration(time.monotonic() - self.heard.since)}"
        elif self._told is None or self._at == (0, 0):
            how_far = f"{self._name}, {duration(spent)}"
        else:
            how_far = f"{self._name}: {self._told(*self._at, spent)}"
        return f"{how_far}; {duration(seconds)} in all"


@contextmanager
def steps_on_terminal() -> Iterator[Steps]:
    """A line on standard error that says which step of the work is under way, where a person watches.

    Yields:
        What is told of each step as it begins, and how far it is.
    """
    with listening() as heard:
        steps = Steps(heard)
        with progress_on_terminal(lambda _one, _other, seconds: steps.line(seconds)):
            yield steps


def exploring(states: int, edges: int, seconds: float) -> str:
    """How far an exploration of unknown size is."""
    if not states:
        return f"exploring, {duration(seconds)}"
    rate = f"{states / seconds:,.0f} states a second"
    return f"exploring: {states:,} states, {edges:,} edges, {rate}, {duration(seconds)}"


def counted(done: int, total: int, seconds: float) -> str:
    """How far work in equal parts is, and how long the rest may take at this pace."""
    left = f", about {duration(seconds * (total - done) / done)} left" if 0 < done < total else ""
    return f"{done:,} of {total:,}, {duration(seconds)}{left}"


def sections(done: int, total: int, seconds: float) -> str:
    """How far work on sections is, which announces each as a step."""
    return f"{counted(done, total, seconds)}" if total else f"reading, {duration(seconds)}"


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
