"""What tests of drivers share: runs as processes, a broker."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.drivers.robots import until
from tests.drivers.runs import Runs, answers, free_port


@pytest.fixture
def runs_of(tmp_path: Path) -> Iterator[Callable[..., Runs]]:
    """Makes a folder of runs, from a file of drivers; what they leave is ended."""
    every: list[Runs] = []

    def make(drivers: str, **how: str) -> Runs:
        every.append(Runs(tmp_path, drivers, **how))
        return every[-1]

    yield make
    for runs in every:
        runs.close()


@pytest.fixture
def broker() -> Iterator[int]:
    """The port of a broker."""
    program = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")
    if program is None:
        pytest.skip("needs mosquitto, a broker for MQTT")
    port = free_port()
    run = subprocess.Popen([program, "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        until(lambda: answers(port) or run.poll() is not None, 20)
        assert run.poll() is None
        yield port
    finally:
        run.terminate()
        run.wait()
