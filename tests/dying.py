"""What ends the process that does it; a module of its own, for each new process imports it."""

from __future__ import annotations

import os
import signal


def die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
