"""The command line as a process: how it begins, and how signals end it; the one room that sees all others.

Heavy modules are imported inside the commands, so that ``mcpn --help`` answers at once. A signal ends the
process with 128 and its number, such as 130 (interrupted) and 143 (terminated); all other exit codes stand in
:mod:`mcpn.cli.exit_codes`.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
from contextlib import suppress
from io import TextIOWrapper
from types import FrameType
from typing import NoReturn

_OTHERS = ("KILL", "STOP", "CHLD", "CONT", "URG", "WINCH", "INFO", "PIPE", "XFSZ", "TSTP", "TTIN", "TTOU")
_FAULTS = ("SEGV", "FPE", "ILL", "BUS", "ABRT", "TRAP", "SYS", "EMT")
SIGNALS = signal.valid_signals() - {
    getattr(signal, f"SIG{name}") for name in (*_OTHERS, *_FAULTS) if hasattr(signal, f"SIG{name}")
}
"""Signals that end a process unless it catches them: not those that nobody can catch, that are ignored or
only suspend it, that Python turns into errors, and that tell of a fault in the process itself."""
WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}

CREATED = 1_000_000
"""Objects created between two searches for garbage in cycles; Python's default is 700.

Answers hold nearly all that is created, hardly any of it in cycles: searching costs time and frees nothing.
"""


ROOM = 256 << 20
"""Bytes that numpy, and scipy, may take to load. OpenBLAS, which is in both, ends a process that has
fewer, or asks for them for ever."""


class _Room:
    """Finds no module, but refuses to import numpy or scipy where the memory for it is not there."""

    @staticmethod
    def find_spec(name: str, _path: object = None, _target: object = None) -> None:
        if name in ("numpy", "scipy"):
            from mmap import mmap

            try:
                mmap(-1, ROOM).close()
            except OSError as error:
                raise MemoryError(
                    f"{name} takes {ROOM >> 20} MB to load, and this process has less"
                ) from error


def main() -> NoReturn:
    """Runs the command line as a process: signals end it cleanly, also while modules are imported."""
    gc.set_threshold(CREATED)
    sys.meta_path.insert(0, _Room)
    _leave_time_for_last_words()
    received: list[int] = []

    def stop(number: int, _frame: FrameType | None) -> None:
        received.append(number)
        signal.signal(number, signal.SIG_DFL)  # a second one does not wait for anything
        raise KeyboardInterrupt

    def swallowed(ignored: sys.UnraisableHookArgs) -> None:
        """Interrupts again, and soon, what was interrupted in a finaliser or a callback of a reference."""
        if received and issubclass(ignored.exc_type, KeyboardInterrupt):
            signal.signal(signal.SIGALRM, stop)
            signal.setitimer(signal.ITIMER_REAL, 0.001)
        else:
            sys.__unraisablehook__(ignored)

    sys.unraisablehook = swallowed
    try:
        for number in SIGNALS:
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                signal.signal(number, stop)
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # what a terminal's encoding does not know
        from mcpn.cli.line import run

        code = run()
    except BaseException:
        # An import or a callback may turn the interruption into an error of its own.
        if not received:
            raise
        code = 128 + received[0]
        word = WORDS.get(received[0]) or f"ended by {signal.strsignal(received[0])}"  # type: ignore[call-overload]
        _say("\n".join((word, *_under_way())))
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)  # the work is done: what is left takes milliseconds
    _leave(code)


def _leave_time_for_last_words() -> None:
    """Lowers a limit on CPU time by a second where the process would be killed at it without a signal before.

    ``ulimit -t`` sets the limit at which the system tells a process and that at which it kills it to the
    same second, and then only kills.
    """
    with suppress(ImportError, OSError, ValueError):  # not every system has such limits
        import resource

        told, killed = resource.getrlimit(resource.RLIMIT_CPU)
        if killed != resource.RLIM_INFINITY and told == killed > 1:
            resource.setrlimit(resource.RLIMIT_CPU, (killed - 1, killed))


def _leave(code: int) -> NoReturn:
    """Ends the process as a whole: to take apart what it holds takes longer than many answers."""
    if sys.gettrace() is None and sys.getprofile() is None:  # else somebody wants to see the end
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):  # it may be full, closed or none
                stream.flush()
        os._exit(code)
    sys.exit(code)


def _under_way() -> list[str]:
    """What was being done, and what to try, where that is known."""
    progress = sys.modules.get("mcpn.report.progress")
    try:
        return [] if progress is None else list(progress.interrupted())
    except Exception:  # the module was being imported
        return []


def _say(words: str) -> None:
    if sys.stderr is not None:
        os.write(sys.stderr.fileno(), f"{words}\n".encode())
