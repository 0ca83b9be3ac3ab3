"""What a run leaves in files: a journal and a snapshot. A disk that is full does not end a mission."""

from __future__ import annotations

import logging
import os
import stat
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.files import sync_folder, write_atomically

_log = logging.getLogger("mcpn.drivers")

MOST_WAITING = 64 << 20
"""Bytes of a journal that wait for room on the disk."""


class Record:
    """A file of a run; one that cannot be written is told of, and tried again with the next event.

    Args:
        kind: What it is called.
        path: Where it is.
        failed: Told what cannot be written, once until it can be again.
    """

    def __init__(self, kind: str, path: Path, failed: Callable[[str], None]) -> None:
        self.kind, self.path, self._failed = kind, path, failed
        self.lost = False
        """Whether what is on the disk is not all that there is to record."""

    def attempt(self, write: Callable[[], None]) -> None:
        """Writes, or notes that it cannot be done."""
        try:
            write()
        except (OSError, InputError) as error:
            if not self.lost:
                self.lost = True
                why = error.problems[0].message if isinstance(error, InputError) else _why(error)
                self._failed(f"the {self.kind} {self.path} {why}")
        else:
            if self.lost:
                self.lost = False
                _log.warning("the %s %s is written again, and is whole", self.kind, self.path)


def _why(error: OSError | ValueError) -> str:
    return f"cannot be written: {getattr(error, 'strerror', None) or error}"


class JournalFile(Record):
    """A journal on the disk; what a full disk does not take waits, so that the file is whole once it does.

    Args:
        path: Where it is.
        goes_on: Whether it is written on behind what stands there.
        failed: As of :class:`Record`.

    Raises:
        InputError: It cannot be opened.
    """

    def __init__(self, path: Path, goes_on: bool, failed: Callable[[str], None]) -> None:
        super().__init__("journal", path, failed)
        self._waiting = bytearray()
        self._overflown = False
        how = os.O_WRONLY | os.O_CREAT | (os.O_APPEND if goes_on else os.O_TRUNC)
        try:
            self._handle = os.open(path, how, 0o666)
            if self._is_on_disk():
                sync_folder(path.parent)
        except (OSError, ValueError) as error:
            raise InputError.at(Source(str(path)), _why(error)) from None

    def write(self, text: str) -> None:
        """Takes a line."""
        if len(self._waiting) + len(text) > MOST_WAITING:
            self._overflown = True
        if not self._overflown:  # a journal ends at a gap: nothing stands behind it
            self._waiting += text.encode()

    def flush(self) -> None:
        """Writes what waits, to the disk."""
        self.attempt(self._flush)

    def _flush(self) -> None:
        while self._waiting:
            del self._waiting[: os.write(self._handle, self._waiting)]
        if self._overflown:
            raise OSError("too much waited for room on the disk")
        if self._is_on_disk():
            os.fsync(self._handle)

    def _is_on_disk(self) -> bool:
        """Whether it is no pipe or terminal."""
        return stat.S_ISREG(os.fstat(self._handle).st_mode)

    def close(self) -> None:
        """Tries a last time to write what waits."""
        if self.lost:
            self.flush()
        with suppress(OSError):
            os.close(self._handle)


class SnapshotFile(Record):
    """A snapshot on the disk.

    Args:
        path: Where it is.
        text: Gives it.
        failed: As of :class:`Record`.

    Raises:
        InputError: It cannot be written before the start.
    """

    def __init__(self, path: Path, text: Callable[[], str], failed: Callable[[str], None]) -> None:
        super().__init__("snapshot", path, failed)
        self._text = text
        self._write()

    def save(self) -> None:
        """Writes it."""
        self.attempt(self._write)

    def _write(self) -> None:
        write_atomically(self.path, self._text(), durable=True)
