"""One measurement in a process of its own, within its time and memory."""

from __future__ import annotations

import math
import multiprocessing
import resource
import signal
import time
from collections.abc import Callable
from typing import Any

from mcpn.answers.compare import peak_megabytes

Result = dict[str, Any]

PATIENCE = 20
"""How many times its CPU seconds some work may take by the clock on the wall."""


def _child(
    work: Callable[..., Result], arguments: tuple[Any, ...], seconds: float, gib: int, pipe: Any
) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (gib << 30, gib << 30))
    started = time.process_time()
    most = math.ceil(started + seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))
    try:
        found = work(*arguments)
    except Exception as error:
        pipe.send({"gave_up": str(error).split("\n")[0][:60] or type(error).__name__})
        return
    found.setdefault("seconds", time.process_time() - started)
    found["megabytes"] = peak_megabytes()
    pipe.send(found)


def measured(work: Callable[..., Result], *arguments: Any, seconds: float = 60, gib: int = 4) -> Result:
    """What some work finds, with its CPU seconds and megabytes, or why it gave up.

    Args:
        work: A function; the process is a fork of this one, so that nothing is imported again.
        arguments: Its arguments.
        seconds: The most CPU time that it may take; by the clock on the wall it may take more.
        gib: The most memory.
    """
    here, there = multiprocessing.Pipe(duplex=False)
    given = (work, arguments, seconds, gib, there)
    process = multiprocessing.get_context("fork").Process(target=_child, args=given)
    process.start()
    there.close()  # so that its end is seen here
    result: Result = {"gave_up": f"more than {seconds:g} s"}
    if here.poll(PATIENCE * seconds + 3):
        try:
            result = here.recv()
        except EOFError:
            process.join()
            if process.exitcode not in (-signal.SIGXCPU, -signal.SIGKILL):
                result = {"gave_up": f"ended with {process.exitcode}"}
    process.kill()
    process.join()
    return result
