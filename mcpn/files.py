"""Reading untrusted files with a bound, writing files whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
import zlib
from collections.abc import Mapping
from contextlib import suppress
from errno import ENOTDIR
from pathlib import Path

from mcpn.errors import InputError, Source

MAX_FILE_BYTES = 256 << 20

_swept: set[Path] = set()
"""Paths beside which this process has looked for what others have left."""


def read_bounded(path: Path, limit: int = MAX_FILE_BYTES) -> bytes:
    """The bytes of a file.

    Args:
        path: The file.
        limit: How many bytes it may have.

    Raises:
        InputError: It cannot be read, is no regular file, or is larger than the limit.
    """
    try:
        if not path.is_file():
            what = (
                "a directory" if path.is_dir() else "no such file" if not path.exists() else "no regular file"
            )
            raise InputError.at(Source(str(path)), f"expected a file, found {what}")
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        raise InputError.at(Source(str(path)), f"cannot be read: {error}") from error
    if len(data) > limit:
        raise InputError.at(Source(str(path)), f"larger than {limit} bytes, the limit for such a file")
    return data


def _beside(path: Path) -> Path:
    """A name beside a path that says who writes there: this machine and this process."""
    return path.with_name(f".{path.name}.{_machine()}-{os.getpid()}-{secrets.token_hex(4)}.tmp")


def _machine() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}"


def _sweep(path: Path) -> None:
    """Removes what processes that were killed have left beside a path; once in a process."""
    if path in _swept:
        return
    _swept.add(path)
    begin = f".{path.name}.{_machine()}-"
    with suppress(OSError):
        for found in path.parent.iterdir():
            if found.name.startswith(begin) and found.name.endswith(".tmp"):
                number = found.name[len(begin) :].partition("-")[0]
                if number.isascii() and number.isdigit() and not _runs(int(number[:9])):
                    _remove(found)


def _runs(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    except OSError:  # it is somebody else's
        return True
    return True


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(FileNotFoundError):
            path.unlink()


def sync_folder(folder: Path) -> None:
    """Has the system write to the disk which files a folder has."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_atomically(path: Path, data: bytes | str, *, durable: bool = False) -> None:
    """Writes a file whole or not at all: beside its name first, then renamed.

    What processes that were killed have left beside it is removed.

    Args:
        path: Where; an existing file is replaced.
        data: What; text is written as UTF-8.
        durable: Whether it is to be on the disk when this returns, so that a loss of power leaves this
            file or the one before it.

    Raises:
        InputError: It cannot be written; what stood there before is untouched.
    """
    try:
        content = data.encode() if isinstance(data, str) else data
        beside = _beside(path)
        _sweep(path)
        try:
            _write(beside, content, durable)
            os.replace(beside, path)
        except BaseException:  # an interruption may come at any line, also behind the renaming
            _remove(beside)
            raise
        if durable:
            sync_folder(path.parent)
    except (OSError, ValueError) as error:  # ValueError: half a character in the text, a NUL in the path
        what = getattr(error, "strerror", None) or error
        raise InputError.at(Source(str(path)), f"cannot be written: {what}") from error


def _write(path: Path, content: bytes, durable: bool) -> None:
    """Writes a new file, with the permissions that the process gives to new files."""
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
        file.write(content)
        if durable:
            file.flush()
            os.fsync(file.fileno())


def write_folder(folder: Path, files: Mapping[str, bytes | str]) -> None:
    """Writes files into a folder, all of them or none.

    They are written into a folder beside first. Where the folder is new this one gets its name; else the
    files are renamed into it one after the other, which an interruption does not end half-way (SIGKILL
    or a loss of power between two of these renamings does).

    Args:
        folder: Where; it is made where there is none, and files of other names in it stay.
        files: What, by name.

    Raises:
        InputError: The folder cannot be made, or a file cannot be written.
    """
    made: list[Path] = []
    at = folder
    try:
        contents = {name: data.encode() if isinstance(data, str) else data for name, data in files.items()}
        for directory in reversed(folder.parents):
            if not directory.exists():
                directory.mkdir()
                made.append(directory)
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR))
        new = not folder.exists()
        inside = folder / "set"  # within the folder, so that both are of one file system
        beside = _beside(folder if new else inside)
        _sweep(folder if new else inside)
        try:
            beside.mkdir()
            for name, content in contents.items():
                at = folder / name
                _write(beside / name, content, durable=False)
            at = folder
            if new:
                beside.rename(folder)
            else:
                _place(beside, folder, list(contents))
        finally:
            _remove(beside)
    except BaseException as error:
        for directory in reversed(made):
            with suppress(OSError):
                directory.rmdir()
        if isinstance(error, OSError | ValueError):
            what = getattr(error, "strerror", None) or error
            doing = "cannot be made a directory" if at == folder else "cannot be written"
            raise InputError.at(Source(str(at)), f"{doing}: {what}") from error
        raise


def _place(beside: Path, folder: Path, names: list[str]) -> None:
    """Renames files into a folder; one that is a directory there is found before the first is renamed."""
    for name in names:
        if (folder / name).is_dir():
            raise IsADirectoryError(21, f"{name} is a directory")
    try:
        for name in names:
            os.replace(beside / name, folder / name)
    except KeyboardInterrupt:
        for name in names:
            with suppress(FileNotFoundError):  # it has been renamed
                os.replace(beside / name, folder / name)
        raise
