"""Reading untrusted files with a bound, writing files whole or not at all."""

from __future__ import annotations

import os
import tempfile
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
    try:
        content = data.encode() if isinstance(data, str) else data
        handle, beside = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
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
