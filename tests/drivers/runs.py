"""Runs of ``mcpn run`` as processes, for tests that kill them."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.conftest import interruptible
from tests.drivers.robots import MISSION, NEVER, alive, numbers

ROBOT = Path(__file__).with_name("robot.py")


class Runs:
    """Runs in a folder; what they leave ends with :meth:`close`.

    Args:
        folder: Where they run.
        drivers: The file of drivers; ``{robot}`` stands for the program that plays a part.
        mission: The mission.
    """

    def __init__(self, folder: Path, drivers: str, mission: str = MISSION) -> None:
        self.folder, self._runs = folder, list[subprocess.Popen[str]]()
        (folder / "mission.xml").write_text(mission)
        text = drivers.replace("{never}", json.dumps(NEVER)).replace("{robot}", str(ROBOT))
        (folder / "drivers.toml").write_text(text)

    def start(
        self, *options: str, before: Callable[[], object] = interruptible, **how: Any
    ) -> subprocess.Popen[str]:
        """Starts one."""
        arguments = ["run", "mission.xml", "--drivers", "drivers.toml", *options]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | how
        run = subprocess.Popen(
            [sys.executable, "-m", "mcpn.cli", *arguments],
            cwd=self.folder,
            text=True,
            preexec_fn=before,
            **pipes,
        )
        self._runs.append(run)
        return run

    def runs(self, part: str) -> list[int]:
        """The processes of a part that run."""
        return [number for number in numbers(self.folder, part) if alive(number)]

    @property
    def left(self) -> list[int]:
        """All processes of the robot that run."""
        return [number for number in numbers(self.folder) if alive(number)]

    def close(self) -> None:
        """Ends all."""
        for run in self._runs:
            run.kill()
        for number in self.left:
            os.kill(number, signal.SIGKILL)
        for run in self._runs:
            run.communicate()


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        number: int = found.getsockname()[1]
        return number


def answers(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), 1).close()
    except OSError:
        return False
    return True
