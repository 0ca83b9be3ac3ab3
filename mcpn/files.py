"""Reading untrusted files with a bound, writing files whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Mapping
from errno import ENOTDIR
from pathlib import Path

from mcpn.errors import InputError, Source

MAX_FILE_BYTES = 256 << 20


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


def write_atomically(path: Path, data: bytes | str) -> None:
    """Writes a file whole or not at all: beside its name first, then renamed.

    Args:
        path: Where; an existing file is replaced.
        data: What; text is written as UTF-8.

    Raises:
        InputError: It cannot be written; what stood there before is untouched.
    """
    from tempfile import mkstemp  # imported late: it loads modules for archives

    try:
        content = data.encode() if isinstance(data, str) else data
        handle, beside = mkstemp(prefix=f".{path.name}.", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(beside, 0o666 & ~umask)
            os.replace(beside, path)
        except BaseException:
            os.unlink(beside)
            raise
    except (OSError, ValueError) as error:  # ValueError: half a character in the text, a NUL in the path
        what = getattr(error, "strerror", None) or error
        raise InputError.at(Source(str(path)), f"cannot be written: {what}") from error


def write_folder(folder: Path, files: Mapping[str, bytes | str]) -> None:
    """Writes files into a folder, which is made where there is none; a refusal leaves no new folder.

    Args:
        folder: Where; files of other names in it stay.
        files: What, by name.

    Raises:
        InputError: The folder cannot be made, or a file cannot be written.
    """
    made: list[Path] = []
    try:
        for directory in reversed((folder, *folder.parents)):
            if not directory.exists():
                directory.mkdir()
                made.append(directory)
        if not folder.is_dir():
            raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR))
        written: list[Path] = []
        try:
            for name, data in files.items():
                write_atomically(folder / name, data)
                written.append(folder / name)
        except BaseException:
            if made:
                for path in written:
                    path.unlink()
            raise
    except BaseException as error:
        for directory in reversed(made):
            directory.rmdir()
        if isinstance(error, OSError | ValueError):
            what = getattr(error, "strerror", None) or error
            raise InputError.at(Source(str(folder)), f"cannot be made a directory: {what}") from error
        raise
