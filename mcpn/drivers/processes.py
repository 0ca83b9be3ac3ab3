"""Drivers that are processes, each in a group of its own, so that all that it starts ends with it."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

LAST_WORDS = 0.5
"""Seconds in which what a process wrote before its end is read; a child of it may keep its output open."""


class ProcessDriver:
    """One run of a command.

    Args:
        command: Its arguments.
        folder: Where it runs.
        said: Told each line of its standard output, on a thread of its own.
        ended: Told its exit status when it has ended by itself: negative where a signal ended it.
        stop: The signal that asks it to end.
    """

    def __init__(
        self,
        command: Sequence[str],
        folder: Path,
        said: Callable[[str], None],
        ended: Callable[[str, Exception | None], None],
        stop: signal.Signals,
    ) -> None:
        self._command, self._folder = command, folder
        self._said, self._ended, self._signal = said, ended, stop
        self._process: subprocess.Popen[bytes] | None = None
        self._over = asyncio.Event()

    async def start(self) -> None:
        """Starts it.

        Raises:
            OSError: It cannot be started.
        """
        loop = asyncio.get_running_loop()
        self._process = process = subprocess.Popen(
            self._command,
            cwd=self._folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        reading = threading.Thread(target=self._read, args=(process,), daemon=True)
        reading.start()
        threading.Thread(target=self._wait, args=(process, reading, loop), daemon=True).start()

    def _read(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        with suppress(OSError):
            for line in process.stdout:
                self._said(line.decode(errors="replace").rstrip("\r\n"))

    def _wait(
        self, process: subprocess.Popen[bytes], reading: threading.Thread, loop: asyncio.AbstractEventLoop
    ) -> None:
        status = process.wait()
        reading.join(LAST_WORDS)

        def over() -> None:
            self._over.set()
            self._ended(str(status), None)

        with suppress(RuntimeError):
            loop.call_soon_threadsafe(over)

    def _send(self, number: signal.Signals) -> None:
        """Sends a signal to the process and all that it has started."""
        assert self._process is not None
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, number)

    def kill(self) -> None:
        """Ends it and all that it has started, at once."""
        if self._process is not None:
            self._send(signal.SIGKILL)

    async def stop(self, grace: float) -> bool:
        """Asks it to end, waits, and then ends it and all that it has started.

        Returns:
            Whether it ended when it was asked to.
        """
        if self._process is None:
            return True
        if not self._over.is_set():
            self._send(self._signal)
        try:
            await asyncio.wait_for(self._over.wait(), grace)
            asked = True
        except TimeoutError:
            asked = False
        self._send(signal.SIGKILL)
        if not asked:
            await self._over.wait()
        return asked
