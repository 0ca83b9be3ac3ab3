"""What a Python user types first: it is there, it is loaded when it is used, its examples are true."""

from __future__ import annotations

import doctest
import subprocess
import sys
from importlib import import_module

import pytest

import mcpn
from tests.conftest import ROOT


@pytest.mark.parametrize("name", ["mcpn", "mcpn.face", "mcpn.check", "mcpn.controller"])
def test_the_examples_are_true(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(import_module(name))
    assert found.attempted >= 3
    assert found.failed == 0


def test_every_name_is_there_and_can_be_called() -> None:
    for name in ("read_mission", "check", "states", "ctl", "causes", "controller"):
        assert name in dir(mcpn)
        assert callable(getattr(mcpn, name))
    with pytest.raises(AttributeError, match="no attribute 'verify'"):
        mcpn.verify  # noqa: B018


def test_rooms_can_be_called_whatever_was_imported_first() -> None:
    first = "import mcpn.check.logic.language, mcpn.controller.machine, mcpn"
    second = "print(callable(mcpn.check), callable(mcpn.controller), callable(mcpn.ctl))"
    run = subprocess.run(
        [sys.executable, "-c", f"{first}\n{second}"], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["True"] * 3


def test_the_package_itself_loads_nothing() -> None:
    script = "import sys, mcpn\nprint(*sorted(m for m in sys.modules if m[:4] == 'mcpn' or m == 'numpy'))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["mcpn"]
