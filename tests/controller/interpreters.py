"""Independent SCXML interpreters: Qt's, python-statemachine's and SCION, each given lines of events."""

from __future__ import annotations

import contextlib
import io
import json
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

Answers = list[tuple[list[str], set[str]]]
"""For each event the labels logged, and the active states that have no children."""


def qt(path: Path, events: list[str]) -> Answers:
    """QScxmlStateMachine of PySide6."""
    return [(labels, set(states)) for labels, states, _ in qt_rows(path, events)]


def qt_rows(path: Path, events: list[str]) -> list[tuple[list[str], list[str], list[str]]]:
    """The same, and for each label what its expression says."""
    if find_spec("PySide6") is None:
        pytest.skip("needs PySide6")
    program = Path(__file__).with_name("qt_program.py")
    run = subprocess.run(
        [sys.executable, str(program), str(path)],
        input="\n".join(events) + "\n",
        capture_output=True,
        text=True,
        timeout=240,
        env={**os.environ, "QT_LOGGING_RULES": "*.debug=false;*.info=false"},
    )
    assert run.returncode == 0, run.stderr
    return [(labels, states, data) for labels, states, data in map(json.loads, run.stdout.splitlines())]


def scion(path: Path, events: list[str]) -> Answers:
    """SCION, on Node.js; it is found where ``NODE_PATH`` says."""
    if scion_version() is None:
        pytest.skip("needs node and @scion-scxml/scxml (npm), in a folder that NODE_PATH names")
    program = Path(__file__).with_name("scion_program.js")
    run = subprocess.run(
        ["node", str(program), str(path)],
        input="\n".join(events) + "\n",
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return [(labels, set(states)) for labels, states in map(json.loads, run.stdout.splitlines())]


def scion_version() -> str | None:
    """The version of SCION, where it is installed."""
    if shutil.which("node") is None or "NODE_PATH" not in os.environ:
        return None
    asked = 'console.log(require("@scion-scxml/scxml/package.json").version)'
    run = subprocess.run(["node", "-e", asked], capture_output=True, text=True, check=False)
    return run.stdout.strip() or None


def python_statemachine(path: Path, events: list[str]) -> Answers:
    """The interpreter of python-statemachine."""
    pytest.importorskip("statemachine.io.scxml.processor", reason="needs python-statemachine")
    from mcpn.robot.bench.scxml_replay import answer, interpreted

    processor = interpreted(path.read_text())
    found: Answers = []
    machine: Any = None
    for event in ["", *events]:
        if event:
            labels, active = answer(machine, event)
            found.append((labels, set(active)))
        else:
            with contextlib.redirect_stdout(io.StringIO()):
                machine = processor.start()
    return found
