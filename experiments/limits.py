"""One measurement in a process of its own, within its time and memory; for the scripts beside it."""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable
from typing import Any

from mcpn.answers.compare import peak_megabytes

Result = dict[str, Any]


def _child(work: Callable[..., Result], arguments: tuple[Any, ...], gib: int, pipe: Any) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (gib << 30, gib << 30))
    started = time.perf_counter()
    try:
        found = work(*arguments)
    except Exception as error:
        pipe.send({"gave_up": str(error).split("\n")[0][:60] or type(error).__name__})
        return
    found.setdefault("seconds", time.perf_counter() - started)
    found["megabytes"] = peak_megabytes()
    pipe.send(found)


def measured(work: Callable[..., Result], *arguments: Any, seconds: float = 60, gib: int = 4) -> Result:
    """What some work finds, with its seconds and megabytes, or why it gave up.

    Args:
        work: A function; the process is a fork of this one, so that nothing is imported again.
        arguments: Its arguments.
        seconds: The longest that it may take.
        gib: The most memory.
    """
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("fork").Process(target=_child, args=(work, arguments, gib, there))
    process.start()
    result = here.recv() if here.poll(seconds + 3) else {"gave_up": f"more than {seconds:g} s"}
    process.kill()
    process.join()
    return dict(result)
