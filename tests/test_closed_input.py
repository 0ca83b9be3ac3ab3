"""A closed standard input is a sentence and exit code 2, wherever events or a log are read from it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.commands import mcpn
from tests.conftest import ROOT

ULYSSE = ROOT / "experiments" / "ulysse" / "mission.xml"


@pytest.mark.parametrize("what", ["simulate", "runtime", "generated"])
def test_a_closed_standard_input_is_said(what: str, tmp_path: Path) -> None:
    command = ["-m", "mcpn.cli", "simulate", str(ULYSSE)]
    if what == "runtime":
        assert mcpn("monitor", ULYSSE, "-o", tmp_path).returncode == 0
        (monitors,) = tmp_path.glob("*.json")
        command = ["-m", "mcpn.robot.runtime", str(monitors)]
    elif what == "generated":
        assert mcpn("controller", ULYSSE, "--target", "python", "-o", tmp_path).returncode == 0
        command = [str(next(tmp_path.glob("*.py")))]
    closed = ["sh", "-c", 'exec "$@" <&-', "sh", sys.executable, *command]
    found = subprocess.run(closed, capture_output=True, text=True, timeout=120)
    assert found.returncode == 2, found.stderr
    assert "closed: expected" in found.stderr
    assert "Traceback" not in found.stderr
