"""Reading untrusted files with a bound; writing files whole or not at all, and never over what was read."""

from __future__ import annotations

import os
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from errno import EACCES, EEXIST, EISDIR, ENOENT, ENOTDIR, ENOTEMPTY, EPERM
from pathlib import Path

from mcpn.errors import InputError, Source

MAX_FILE_BYTES = 256 << 20

AT_A_TIME = 1 << 20
"""Bytes or characters of a file that are written together."""

MOST_OF_NAME = 200
"""Bytes of a name up to which the name beside it holds it whole."""

AT_FDCWD, RENAME_EXCHANGE = -100, 2
"""Of Linux: paths are those of this process; two files change their names."""

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
            found = no_regular_file(path) or "no such file"
            raise InputError.at(Source(str(path)), f"expected a file, found {found}")
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        raise InputError.at(Source(str(path)), f"cannot be read: {error}") from error
    if len(data) > limit:
        raise InputError.at(Source(str(path)), f"larger than {limit} bytes, the limit for such a file")
    return data


def file_inside(name: str, folder: Path, root: Path) -> Path:
    """The file that a text in another file names. Nothing else decides which files may be read for a file.

    Args:
        name: What the text says, relative to the folder.
        folder: Where the file with the text is.
        root: The directory that the file must be in when links are followed.

    Raises:
        OutsideError: It is not in that directory.
        InputError: It is no regular file, or no file can have the name.
    """
    try:
        path = folder / name
        inside = path.resolve().is_relative_to(root.resolve())
        found = None if path.is_file() else no_regular_file(path) or "no such file"
    except (OSError, ValueError, RuntimeError) as error:  # too long, a NUL, a loop of links
        why = getattr(error, "strerror", None) or error
        raise InputError.at(None, f"{name[:80]!r}: {why}") from error
    if not inside or ":" in name.split("/")[0]:
        raise OutsideError.at(None, f"{name} is outside of {root}")
    if found is not None:
        raise InputError.at(None, f"{name}: {found}")
    return path


class OutsideError(InputError):
    """A file names another one that may not be read for it: it is in another directory."""


def no_regular_file(path: Path) -> str | None:
    """What a path is that is there and is no regular file."""
    if not path.exists() or path.is_file():
        return None
    return "a directory" if path.is_dir() else "no regular file"


def why_not_written(path: Path, error: OSError | ValueError) -> str:
    """What keeps a file from being written, in a sentence that says what is to be changed."""
    if isinstance(error, UnicodeError):
        why = "its text has half a character, which UTF-8 cannot encode"
    elif isinstance(error, ValueError):
        why = "no name of a file has a NUL"
    elif error.errno in (ENOENT, ENOTDIR) and not path.parent.is_dir():
        found = "is no directory" if path.parent.exists() else "is not there"
        why = f"the directory {path.parent} {found}"
    elif error.errno == EISDIR or (error.errno in (ENOTEMPTY, EEXIST) and path.is_dir()):
        why = "it is a directory"
    elif error.errno in (EACCES, EPERM) and not os.access(path.parent, os.W_OK | os.X_OK):
        why = f"nothing may be written into the directory {path.parent}"
    else:
        why = error.strerror or str(error)
    return f"cannot be written: {why}"


def keep_apart(written: Iterable[Path | None], read: Iterable[str | Path], made: Path | None = None) -> None:
    """Refuses to write over what was read, two things into one file, and where no file can be.

    A command asks before it works, so that no answer is lost, nor one of two files written.

    Args:
        written: Where a command writes; nothing is written where it is ``None``.
        read: What it was given and has read.
        made: A directory that the command makes.

    Raises:
        InputError: A file would be lost, or its directory is not there, or it is a directory.
    """
    taken = {Path(each).resolve(): "it is read" for each in read}
    for path in filter(None, written):
        if path.parent != made and not path.parent.is_dir():
            raise InputError.at(Source(str(path)), why_not_written(path, OSError(ENOENT, "")))
        if path.is_dir():
            raise InputError.at(Source(str(path)), why_not_written(path, OSError(EISDIR, "")))
        if why := taken.get(path.resolve()):
            raise InputError.at(Source(str(path)), f"cannot be written: {why} by this command")
        taken[path.resolve()] = "something else is written there"


def _beside(path: Path) -> Path:
    """A name beside a path that says who writes there: this machine and this process."""
    return path.with_name(f"{_begin(path)}{os.getpid()}-{os.urandom(4).hex()}.tmp")


def _begin(path: Path) -> str:
    """How names beside a path begin; those of long names are cut, for 255 bytes is the most a name has."""
    name = path.name if len(os.fsencode(path.name)) < MOST_OF_NAME else os.fsencode(path.name)[:60].hex()
    return f".{name}.{_machine()}-"


def _machine() -> str:
    return f"{zlib.crc32(os.uname().nodename.encode()):08x}"


def _sweep(path: Path) -> None:
    """Removes what processes that were killed have left beside a path; once in a process."""
    if path in _swept:
        return
    _swept.add(path)
    begin = _begin(path)
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
        from shutil import rmtree  # which loads what packs and unpacks archives

        rmtree(path, ignore_errors=True)
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
        if found := no_regular_file(path):  # a device or a pipe would be replaced by a file
            raise InputError.at(Source(str(path)), f"cannot be written: it is {found}")
        beside = _beside(path)
        _sweep(path)
        try:
            _write(beside, data, durable)
            os.replace(beside, path)
        except BaseException:  # an interruption may come at any line, also behind the renaming
            _remove(beside)
            raise
        if durable:
            sync_folder(path.parent)
    except (OSError, ValueError) as error:  # ValueError: half a character in the text, a NUL in the path
        raise InputError.at(Source(str(path)), why_not_written(path, error)) from error


def _write(path: Path, content: bytes | str, durable: bool) -> None:
    """Writes a new file, with the permissions that the process gives to new files.

    A long text is encoded part by part, so that its bytes are not in memory beside it.
    """
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
        for begin in range(0, len(content), AT_A_TIME):
            part = content[begin : begin + AT_A_TIME]
            file.write(part.encode() if isinstance(part, str) else part)
        if durable:
            file.flush()
            os.fsync(file.fileno())


def write_folder(folder: Path, files: Mapping[str, bytes | str]) -> None:
    """Writes files into a folder, all of them or none.

    They are written into a folder beside first. Where the folder is new this one gets its name. Where it
    holds nothing but files that are replaced, the two change their names at once, if the system can do that,
    so that at every moment all files are the old ones or all are the new ones. Else files are renamed into it
    one after the other, which an interruption does not end half-way (SIGKILL or a loss of power between two
    of these renamings does).

    Args:
        folder: Where; it is made where there is none, and files of other names in it stay.
        files: What, by name.

    Raises:
        InputError: The folder cannot be made, or a file cannot be written.
    """
    made: list[Path] = []
    at = folder
    try:
        for at in reversed((folder, *folder.parents)):
            if at != folder and not at.exists():
                at.mkdir()
                made.append(at)
        if not folder.exists():
            with _filled_beside(folder, folder, files) as beside:
                beside.rename(folder)
        elif not folder.is_dir():
            raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR))
        elif not (_is_replaced(folder, files.keys()) and _swapped(folder, files)):
            inside = folder / "set"  # within the folder, so that both are of one file system
            with _filled_beside(inside, folder, files) as beside:
                _place(beside, folder, list(files))
    except BaseException as error:
        for directory in reversed(made):
            with suppress(OSError):
                directory.rmdir()
        if isinstance(error, OSError | ValueError):
            file = next((parent for parent in (at, *at.parents) if parent.is_file()), None)
            why = getattr(error, "strerror", None) or error if file is None else f"{file} is a file"
            raise InputError.at(Source(str(at)), f"cannot be made a directory: {why}") from error
        raise


@contextmanager
def _filled_beside(near: Path, folder: Path, contents: Mapping[str, bytes | str]) -> Iterator[Path]:
    """A folder beside a path with files that are to be in another folder; it is removed in the end."""
    beside = _beside(near)
    _sweep(near)
    try:
        beside.mkdir()
        for name, content in contents.items():
            try:
                _write(beside / name, content, durable=False)
            except (OSError, ValueError) as error:
                raise InputError.at(
                    Source(str(folder / name)), why_not_written(folder / name, error)
                ) from error
        yield beside
    finally:
        _remove(beside)


def _swapped(folder: Path, contents: Mapping[str, bytes | str]) -> bool:
    """Puts a new folder in the place of one at once; ``False`` where it cannot be done so."""
    from shutil import copymode

    try:
        with _filled_beside(folder, folder, contents) as beside:
            copymode(folder, beside)
            return _exchanged(beside, folder)
    except OSError:  # nothing may be made beside the folder
        return False


def _is_replaced(folder: Path, names: Collection[str]) -> bool:
    """Whether a folder holds nothing but files of some names, and can be replaced as a whole.

    Somebody who stands in it, or has made a link of its name, would otherwise be left with the old one.
    """
    if folder.is_symlink() or folder.name in ("", "..") or folder.resolve() == Path.cwd():
        return False
    found = folder.stat()
    return (found.st_uid, found.st_gid) == (os.geteuid(), os.getegid()) and all(
        entry.name in names and entry.is_file(follow_symlinks=False) for entry in os.scandir(folder)
    )


def _exchanged(new: Path, old: Path) -> bool:
    """Has two folders change their names at once; ``False`` where the system cannot, which Linux can."""
    import ctypes

    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    return bool(rename(AT_FDCWD, os.fsencode(new), AT_FDCWD, os.fsencode(old), RENAME_EXCHANGE) == 0)


def _place(beside: Path, folder: Path, names: list[str]) -> None:
    """Renames files into a folder; one that is a directory there is found before the first is renamed."""
    for name in names:
        if (folder / name).is_dir():
            error = IsADirectoryError(EISDIR, os.strerror(EISDIR))
            raise InputError.at(Source(str(folder / name)), why_not_written(folder / name, error))
    try:
        for name in names:
            os.replace(beside / name, folder / name)
    except KeyboardInterrupt:
        for name in names:
            with suppress(FileNotFoundError):  # it has been renamed
                os.replace(beside / name, folder / name)
        raise
