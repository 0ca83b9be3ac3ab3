"""What a run leaves in files: a journal and a snapshot. A disk that is full does not end a mission."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.files import no_regular_file, sync_folder, why_not_written, write_atomically
from mcpn.robot.runtime.journal import Journal

_log = logging.getLogger("mcpn.robot.drivers")

MOST_WAITING = 64 << 20
"""Bytes of a journal that wait for room on the disk."""


class Record:
    """A file of a run; one that cannot be written is reported, and tried again with the next event.

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
                why = (
                    error.problems[0].message
                    if isinstance(error, InputError)
                    else why_not_written(self.path, error)
                )
                self._failed(f"the {self.kind} {self.path} {why}")
        else:
            if self.lost:
                self.lost = False
                _log.warning("the %s %s is written again, and is complete", self.kind, self.path)


class JournalFile(Record):
    """A journal on the disk; what a full disk does not take waits, so that the file is whole once it does.

    Args:
        path: Where it is.
        goes_on: Whether it is written on behind what stands there.
        failed: As of :class:`Record`.

    Raises:
        InputError: It cannot be opened, or is no regular file, so that what it takes is on no disk.
    """

    def __init__(self, path: Path, goes_on: bool, failed: Callable[[str], None]) -> None:
        super().__init__("journal", path, failed)
        self._waiting = bytearray()
        self._overflown = False
        how = os.O_WRONLY | os.O_CREAT | os.O_NONBLOCK | (os.O_APPEND if goes_on else os.O_TRUNC)
        try:
            if (found := no_regular_file(path)) is not None:
                raise InputError.at(Source(str(path)), f"a journal is a file on a disk, found {found}")
            self._handle = os.open(path, how, 0o666)
            sync_folder(path.parent)
        except (OSError, ValueError) as error:
            raise InputError.at(Source(str(path)), why_not_written(path, error)) from None

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
            raise OSError("too much waited for space on the disk")
        os.fsync(self._handle)

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


class Records:
    """The records of a run, and what becomes of the run where one cannot be written.

    Args:
        must: Whether the run is then ended.
        told: Called with a sentence then.
    """

    def __init__(self, must: bool, told: Callable[[str], None] | None) -> None:
        self._must, self._told = must, told
        self._end: Callable[[], None] | None = None
        self._journal: JournalFile | None = None
        self._snapshot: SnapshotFile | None = None

    def journal_of(self, path: Path, resumed: int | None) -> Journal:
        """A journal in a file; give it to :meth:`mcpn.robot.runtime.Controller.observe`.

        Args:
            path: The file.
            resumed: The last event of the run that is gone on with, if one is.

        Raises:
            InputError: It cannot be opened.
        """
        self._journal = JournalFile(path, resumed is not None, self._failed)
        journal = Journal(self._journal)
        if resumed is not None:
            journal.resumed(resumed)
        return journal

    def snapshot_of(self, path: Path, text: Callable[[], str]) -> None:
        """Keeps a snapshot in a file.

        Raises:
            InputError: It cannot be written.
        """
        self._snapshot = SnapshotFile(path, text, self._failed)

    def begin(self, end: Callable[[], None]) -> None:
        """Notes that the run begins.

        Args:
            end: Ends it in order.

        Raises:
            InputError: A record is lost already, and must not be.
        """
        self._end = end
        for record in self._all:
            if record.lost and self._must:
                raise InputError.at(
                    Source(str(record.path)), "not everything can be recorded: nothing is run"
                )

    def save(self) -> None:
        """Writes the snapshot, if one is kept."""
        if self._snapshot is not None:
            self._snapshot.save()

    def close(self) -> None:
        """Tries a last time to write what the journal lacks."""
        if self._journal is not None:
            self._journal.close()

    @property
    def _all(self) -> list[Record]:
        return [record for record in (self._journal, self._snapshot) if record is not None]

    @property
    def lost(self) -> list[str]:
        """Which records are not whole."""
        return [record.kind for record in self._all if record.lost]

    def _failed(self, what: str) -> None:
        """Tells of a record that cannot be written."""
        _log.error("%s; %s", what, "the run is ended" if self._must else "the run goes on")
        if self._told is not None:
            self._told(f"{what}.")
        if self._must and self._end is not None:
            self._end()
