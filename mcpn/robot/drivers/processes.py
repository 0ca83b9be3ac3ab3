"""Drivers that are processes, each marked, in a group of its own, so that all that it starts ends with it."""

from __future__ import annotations

import asyncio
import logging
import os
import secrets
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from mcpn.robot.drivers import warden
from mcpn.robot.drivers.inbox import LONGEST, PAUSE, Inbox, Splitter
from mcpn.robot.drivers.warden import ProcessGroup, line_of, started_at

NOT_STARTED = "not_started"
"""How a driver ends that could not be started."""
LAST_WORDS = 0.5
"""Seconds in which what a process wrote before its end is read; a child of it may keep its output open."""
PIECE = 1 << 14
"""Bytes that are read of one process before others have their turn."""
HELD = 'word=$1; shift; shopt -s execfail 2>/dev/null; trap "echo $word" EXIT; '
HELD += f'read -r mark && export {warden.MARK}="$mark" && exec "$@" </dev/null'
"""What a shell is told, which becomes the driver once the warden knows its number, and else ends.

Where it cannot become the driver it prints the word, which no driver knows (the trap does it in most shells,
in bash where ``execfail`` is on)."""

_log = logging.getLogger("mcpn.robot.drivers")


def program_of(folder: Path, name: str) -> str | None:
    """The program that a driver in a folder calls so: found from there with a ``/``, else by PATH."""
    return shutil.which(str(folder.resolve() / name) if "/" in name else name)


class Warden:
    """The processes of one controller, and the process that ends them when the controller is gone.

    Args:
        changed: Called when a process is about to begin, so that its number can be kept.
    """

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self.rows: dict[int, ProcessGroup] = {}
        self._changed = changed
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def row(self) -> ProcessGroup | None:
        """The warden itself."""
        return None if self._process is None else row_of(self._process.pid, signal.SIGKILL, 0.0)

    def watch(self, row: ProcessGroup) -> None:
        """Tells it of a process that is about to begin."""
        self.rows[row.number] = row
        self._tell(line_of(row))
        self._changed()

    def forget(self, number: int) -> None:
        """Tells it of a process that has been ended, with its group."""
        if self.rows.pop(number, None) is not None:
            self._tell(f"- {number}\n")

    def _tell(self, line: str) -> None:
        """Writes to it; one that is gone has a successor, which is told all."""
        if self._process is not None and self._write(line):
            return
        if self._process is not None:
            _log.warning("somebody ended the warden of the drivers; another one is started")
            self.close()
        self._process = subprocess.Popen(
            [sys.executable, "-I", "-S", warden.__file__, str(os.getpid())],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            bufsize=0,
        )
        assert self._process.stdout is not None
        self._process.stdout.readline()  # from here on no signal but SIGKILL ends it
        self._write("".join(map(line_of, self.rows.values())))

    def _write(self, text: str) -> bool:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(text.encode())
        except OSError:
            return False
        return self._process.poll() is None

    def close(self) -> None:
        """Lets it end, which it does when all that it knows of has ended."""
        if self._process is not None:
            for stream in (self._process.stdin, self._process.stdout):
                assert stream is not None
                with suppress(OSError):
                    stream.close()
            self._process.wait()
            self._process = None


def row_of(number: int, stop: signal.Signals, grace: float) -> ProcessGroup | None:
    """A process that runs; ``None`` if it does not."""
    since = started_at(number)
    return None if since is None else ProcessGroup(number, since, int(stop), grace)


class ProcessDriver:
    """One run of a command.

    Args:
        name: What it is called in messages.
        command: Its arguments.
        folder: Where it runs.
        inbox: Takes each line of its standard output.
        ended: Told its exit status when it has ended by itself: negative where a signal ended it.
        stop: The signal that asks it to end.
        grace: Seconds that it may take to end.
        keeper: Told when it is started and ended.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        folder: Path,
        inbox: Inbox,
        ended: Callable[[str, Exception | None], None],
        stop: signal.Signals,
        grace: float,
        keeper: Warden,
    ) -> None:
        self._name, self._command, self._folder = name, command, folder
        self._inbox, self._ended, self._signal = inbox, ended, stop
        self._grace, self._warden = grace, keeper
        self._process: subprocess.Popen[bytes] | None = None
        self._row: ProcessGroup | None = None
        self._over = asyncio.Event()
        self._read_all = asyncio.Event()
        self._splitter = Splitter(LONGEST, self._too_long)
        self._told_too_long = False
        self._word = secrets.token_hex(16)
        self._became_it = True

    async def start(self) -> None:
        """Starts it: first a shell that waits, which the warden hears of, then the command in its place.

        So there is no moment in which a driver runs of which the warden does not know.

        Raises:
            OSError: It cannot be started.
        """
        program = self._command[0]
        if program_of(self._folder, program) is None:
            raise FileNotFoundError(f"no program {program!r} is found")
        loop = asyncio.get_running_loop()
        self._process = process = subprocess.Popen(
            ["/bin/sh", "-c", HELD, "sh", self._word, *self._command],
            cwd=self._folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
            bufsize=0,
        )
        assert process.stdin is not None
        assert process.stdout is not None
        self._row = row_of(process.pid, self._signal, self._grace)
        if self._row is not None:
            self._warden.watch(self._row)
        os.set_blocking(process.stdout.fileno(), False)
        loop.add_reader(process.stdout.fileno(), self._read)
        threading.Thread(target=self._wait, args=(process, loop), daemon=True).start()
        with suppress(OSError), process.stdin as held:
            held.write(f"{'' if self._row is None else self._row.mark}\n".encode())

    def _read(self) -> None:
        """Reads a piece; where too many lines wait, nothing is read, so that the process waits too."""
        assert self._process is not None
        assert self._process.stdout is not None
        output, loop = self._process.stdout, asyncio.get_running_loop()
        if output.closed:
            return
        if self._inbox.full:
            loop.remove_reader(output.fileno())
            loop.call_later(PAUSE, self._read)
            return
        try:
            data = os.read(output.fileno(), PIECE)
        except BlockingIOError:
            data = None
        except OSError:
            data = b""
        if data is not None:
            for line in self._splitter.lines(data):
                if line == self._word:
                    self._became_it = False
                else:
                    self._inbox.put(line)
        if data == b"":
            self._close()
        else:
            loop.add_reader(output.fileno(), self._read)

    def _close(self) -> None:
        """Stops reading."""
        assert self._process is not None
        assert self._process.stdout is not None
        if not self._process.stdout.closed:
            asyncio.get_running_loop().remove_reader(self._process.stdout.fileno())
            self._process.stdout.close()
        self._read_all.set()

    def _too_long(self) -> None:
        if not self._told_too_long:
            self._told_too_long = True
            _log.warning(
                "%s: a line has more than %d bytes: it is left out, and so are others like it",
                self._name,
                LONGEST,
            )

    def _wait(self, process: subprocess.Popen[bytes], loop: asyncio.AbstractEventLoop) -> None:
        status = process.wait()
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(lambda: loop.create_task(self._has_ended(status)))

    async def _has_ended(self, status: int) -> None:
        self._over.set()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._read_all.wait(), LAST_WORDS)
        if self._became_it:
            self._inbox.put(lambda: self._ended(str(status), None))
        else:
            error = OSError(f"the program {self._command[0]!r} cannot be run")
            self._inbox.put(lambda: self._ended(NOT_STARTED, error))

    def _send(self, number: signal.Signals) -> None:
        """Sends a signal to the process and all that it has started; to no stranger of its number."""
        if self._row is not None:
            warden.send(self._row, number)

    def kill(self) -> None:
        """Ends its group at once, also if asked a hundred times a second; :meth:`stop` ends the rest."""
        if self._process is not None and not self._over.is_set():
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)

    async def _nothing_left(self) -> bool:
        """Kills what is left of it and of all that it has started, until nothing is.

        A signal is no end: a killed process runs until the system takes it away, and its hardware is its own.
        """
        loop = asyncio.get_running_loop()
        until = loop.time() + warden.KILLED
        while self._row is not None and warden.is_left(self._row):
            if loop.time() > until:
                return False
            self._send(signal.SIGKILL)
            await asyncio.sleep(warden.LOOK)
        with suppress(TimeoutError):
            await asyncio.wait_for(self._over.wait(), warden.KILLED)
        return self._over.is_set()

    async def stop(self, grace: float) -> bool:
        """Asks it to end, waits, and then ends it and all that it has started, and waits for that too.

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
        if not await self._nothing_left():
            _log.error("%s cannot be killed", self._name)
        self._close()
        self._warden.forget(self._process.pid)
        return asked
