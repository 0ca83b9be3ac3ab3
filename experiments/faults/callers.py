"""A plugin of pytest: which functions of mcpn each test calls, and how long it takes; for ``mutants.py``.

``python -m pytest -p callers --callers FILE`` writes a line of JSON for each test that passed.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest

_seen: dict[int, CodeType] = {}
_calls: dict[str, list[Any]] = {}


def _note(frame: FrameType, event: str, argument: object) -> None:
    """Notes what is called; lines are not followed."""
    code = frame.f_code
    _seen[id(code)] = code


def function_of(code: CodeType) -> str:
    """The function or method around some code, by its names; a comprehension is part of one."""
    return ".".join(part for part in code.co_qualname.split(".") if not part.startswith("<"))


def _called(config: pytest.Config) -> dict[str, list[str]]:
    """By file of mcpn, the functions noted since this was last asked."""
    root, found = f"{config.rootpath}/", dict[str, set[str]]()
    for code in _seen.values():
        if code.co_filename.startswith(f"{root}mcpn/"):
            found.setdefault(code.co_filename.removeprefix(root), set()).add(function_of(code))
    _seen.clear()
    return {path: sorted(names) for path, names in found.items()}


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Iterator[None]:
    """Follows the import of all tests."""
    sys.settrace(_note)  # type: ignore[arg-type]
    try:
        return (yield)
    finally:
        sys.settrace(None)
        _calls[""] = [0.0, _called(session.config)]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the name of the file."""
    parser.addoption("--callers", help="the file for what each test calls")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Follows one test with its fixtures."""
    begun = time.perf_counter()
    threading.settrace(_note)  # type: ignore[arg-type]
    sys.settrace(_note)  # type: ignore[arg-type]
    try:
        return (yield)
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        _calls[item.nodeid] = [time.perf_counter() - begun, _called(item.config)]


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """What is skipped notices nothing."""
    if report.skipped:
        _calls.pop(report.nodeid, None)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Writes what was noted."""
    if file := session.config.getoption("--callers"):
        Path(file).write_text("".join(json.dumps([name, *row]) + "\n" for name, row in _calls.items()))
