"""How far work is, on one line of standard error, where a person watches and it takes more than a second."""

from __future__ import annotations

import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SILENT_SECONDS = 1.0
"""What ends sooner shows no progress."""

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
    started = time.monotonic()
    latest = (0, 0)
    ended = threading.Event()

    def show() -> None:
        wait = SILENT_SECONDS
        while not ended.wait(wait):
            wait = _TICK
            text = describe(*latest, time.monotonic() - started)
            width = shutil.get_terminal_size().columns - 1
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


@contextmanager
def steps_on_terminal() -> Iterator[Callable[[str], None]]:
    """A line on standard error that says which step of the work is under way, where a person watches.

    Yields:
        What is called with the name of each step as it begins.
    """
    now = ("reading", time.monotonic())

    def say(_one: int, _other: int, seconds: float) -> str:
        name, since = now
        return f"{name}, {duration(time.monotonic() - since)}; {duration(seconds)} in all"

    def begins(step: str) -> None:
        nonlocal now
        now = step, time.monotonic()

    with progress_on_terminal(say):
        yield begins


def exploring(states: int, edges: int, seconds: float) -> str:
    """How far an exploration of unknown size is."""
    if not states:
        return f"exploring, {duration(seconds)}"
    rate = f"{states / seconds:,.0f} states a second"
    return f"exploring: {states:,} states, {edges:,} edges, {rate}, {duration(seconds)}"


def sections(done: int, total: int, seconds: float) -> str:
    """How far work on sections is, and how long the rest may take at this pace."""
    if not total:
        return f"sections on their own, {duration(seconds)}"
    left = f", about {duration(seconds * (total - done) / done)} left" if done else ""
    return f"sections on their own, and junctions: {done:,} of {total:,}, {duration(seconds)}{left}"


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
