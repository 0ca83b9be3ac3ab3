"""Ends the processes of a robot when their controller is gone.

Run as a program it is the warden of one controller, which holds the other end of its standard input and
writes there which processes it starts and ends. When that end closes, or the parent is another one, the
controller is gone (killed by SIGKILL, at the worst), and the warden ends what is left. A pipe does this on
every system, and unlike PR_SET_PDEATHSIG of Linux it reaches the processes that a driver has started itself.
A stand-in, which the warden starts and tells the same, does so where both of them are killed.
This module needs nothing but Python, so that the warden is small and starts at once.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

LOOK = 0.02
"""Seconds between two looks whether a process has ended."""
KILLED = 2.0
"""Seconds that a process is waited for after SIGKILL, which one that hangs in the kernel outlives."""
PARENT = 1.0
"""Seconds between two looks whether the parent is the same: a child of it may hold the pipe open."""
MARK = "MCPN_DRIVER"
"""The variable by which what a driver has started is found, in whatever session it is (on Linux)."""


@dataclass(frozen=True)
class ProcessGroup:
    """A process that leads a group of its own.

    Args:
        number: Its number.
        since: When it started; with the number it names one process, also after the number is given again.
        stop: The signal that asks it to end.
        grace: Seconds that it may take to end.
    """

    number: int
    since: str
    stop: int
    grace: float

    @property
    def mark(self) -> str:
        """What :data:`MARK` is in the process, and in all that it starts."""
        return f"{self.number}/{self.since}"


def started_at(number: int) -> str | None:
    """When a process started, as the system says it; ``None`` if it has ended.

    On Linux these are ticks since the boot, with the boot's name before them.
    """
    try:
        said = Path(f"/proc/{number}/stat").read_text(encoding="utf-8", errors="replace")
        fields = said.rpartition(")")[2].split()
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return None if fields[0] in "ZX" else f"{boot}:{fields[19]}"
    except FileNotFoundError:
        if Path("/proc/self/stat").exists():
            return None
    except ProcessLookupError:  # it ended while it was read
        return None
    told = subprocess.run(
        ["ps", "-o", "lstart=", "-p", str(number)], capture_output=True, text=True, check=False
    )
    return "_".join(told.stdout.split()) or None


def _boot() -> str | None:
    """The boot's name, on Linux."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return None


def _group_is_there(number: int) -> bool:
    try:
        os.killpg(number, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # all that is left waits to be reaped by somebody else
        return False
    if not Path("/proc/self/stat").exists():
        return True
    return any(_of_group(path, number) for path in Path("/proc").glob("[0-9]*/stat"))


def _of_group(path: Path, number: int) -> bool:
    """Whether a process is of a group, and has not ended."""
    try:
        fields = path.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
    except OSError:
        return False
    # A driver is started in a session of its own, so its group's session has the same number.
    return int(fields[2]) == int(fields[3]) == number and fields[0] not in "ZX"


def _group_is_left(row: ProcessGroup) -> bool:
    """Whether something of a process's group runs, and the group is still that process's."""
    boot = _boot()
    if boot is not None and ":" in row.since and row.since.partition(":")[0] != boot:
        return False  # the machine was started anew since
    now = started_at(row.number)
    return (now is None or now == row.since) and _group_is_there(row.number)


def _outside(row: ProcessGroup) -> list[int]:
    """What a process has started that left its group, as a daemon does, by the mark in its environment."""
    mark, found = f"\0{MARK}={row.mark}\0".encode(), []
    for path in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            number = int(path.parent.name)
            if mark in b"\0" + path.read_bytes() and os.getpgid(number) != row.number:
                found.append(number)
    return found


def is_left(row: ProcessGroup) -> bool:
    """Whether something of a process's group runs, or something that it started and that left the group."""
    return _group_is_left(row) or bool(_outside(row))


def end(rows: Iterable[ProcessGroup]) -> list[ProcessGroup]:
    """Ends processes with all that they have started, one after the other, the last one first.

    Each is asked by its signal, and killed when its grace is over. A process with the same number that
    started at another time is a stranger, and is left alone.

    Returns:
        Those of which something was left.
    """
    found = []
    for row in reversed([*rows]):
        if is_left(row):
            found.append(row)
            send(row, row.stop)
            until = time.monotonic() + row.grace
            while is_left(row) and time.monotonic() < until:
                time.sleep(LOOK)
            until = time.monotonic() + KILLED
            while is_left(row) and time.monotonic() < until:
                send(row, signal.SIGKILL)
                time.sleep(LOOK)
    return found


def send(row: ProcessGroup, which: int) -> None:
    """Sends a signal to a process's group and to what left it; to no stranger of its number."""
    if _group_is_left(row):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(row.number, which)
    for number in _outside(row):
        with suppress(ProcessLookupError, PermissionError):
            os.kill(number, which)


def line_of(row: ProcessGroup) -> str:
    """What tells a warden to watch a process."""
    return f"+ {row.number} {row.since} {row.stop} {row.grace!r}\n"


def _followed(rows: dict[int, ProcessGroup], line: str) -> None:
    verb, number, *rest = line.split()
    if verb == "+":
        since, stop, grace = rest
        rows[int(number)] = ProcessGroup(int(number), since, int(stop), float(grace))
    else:
        rows.pop(int(number), None)


def keep(
    source: int,
    parent: int,
    parent_is: Callable[[], int] = os.getppid,
    told: Callable[[bytes], object] = lambda data: None,
) -> dict[int, ProcessGroup]:
    """Reads what is started and ended, until the writer is gone.

    Args:
        source: The pipe.
        parent: The writer's number.
        parent_is: Tells the number of the parent.
        told: Is given what is read.

    Returns:
        By number, the processes that have not been ended.
    """
    rows: dict[int, ProcessGroup] = {}
    rest = b""
    while True:
        gone = parent_is() != parent
        if select.select([source], [], [], 0 if gone else PARENT)[0]:
            data = os.read(source, 1 << 16)
            if not data:
                break
            told(data)
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                _followed(rows, line.decode())
        elif gone:
            break
    return rows


def main() -> None:
    """Watches; signals that are meant for the controller do not end it."""
    for number in signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP, signal.SIGCHLD}:
        with suppress(OSError, ValueError):
            signal.signal(number, signal.SIG_IGN)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    controller = int(sys.argv[1])
    since, warden = started_at(controller), os.getpid()
    source, sink = os.pipe()
    if os.fork() == 0:
        _stand_in(source, sink, warden, controller, since)
        return
    os.close(source)

    def tell(data: bytes) -> None:
        with suppress(OSError):  # the stand-in has been killed
            os.write(sink, data)

    rows = keep(0, controller, told=tell)
    end(rows.values())
    for ended in rows:
        tell(f"- {ended}\n".encode())


def _stand_in(source: int, sink: int, warden: int, controller: int, since: str | None) -> None:
    """Ends what is left where the warden and the controller are killed; while that runs it has another."""
    os.setsid()
    os.close(sink)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nothing, stream)
    rows = keep(source, warden)
    while rows and since is not None and started_at(controller) == since:
        time.sleep(10 * LOOK)
    end(rows.values())


if __name__ == "__main__":
    main()
