"""The command line in this process: what tests run of it."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
from typing import Any

from mcpn.cli.line import run


@dataclass(frozen=True)
class Outcome:
    """What one run of the command line did."""

    returncode: int
    stdout: str
    stderr: str


def mcpn(*arguments: object) -> Outcome:
    """Runs a command; tests/test_process.py has what takes a process of its own."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run([str(argument) for argument in arguments])
    return Outcome(code, out.getvalue(), err.getvalue())


def output(*arguments: object, code: int = 0) -> Any:
    """The one JSON value of a command, which says nothing else."""
    found = mcpn(*arguments, "--json")
    assert found.returncode == code, found.stderr
    assert found.stderr == ""
    return json.loads(found.stdout)
