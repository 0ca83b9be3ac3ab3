"""What ends the process that does it, or is ended with it; a module of its own, for each imports it."""

from __future__ import annotations

import os
import signal
import struct
import sys
import time
from pathlib import Path


def die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def wait(begun: Path) -> None:
    begun.touch()
    time.sleep(60)


def begin_result(begun: Path) -> None:
    """Writes the length of a result and the first bytes, as a process does that has a large one."""
    frame = sys._getframe()
    while "result_queue" not in frame.f_locals:
        assert frame.f_back is not None
        frame = frame.f_back
    os.write(frame.f_locals["result_queue"]._writer.fileno(), struct.pack("!i", 1000) + b"first")
    wait(begun)
