"""The script that says what coverage fell, on figures made by hand."""

from __future__ import annotations

import importlib.util
from types import ModuleType
from typing import Any

import pytest

from tests.conftest import ROOT

SCRIPT = ROOT / ".ci" / "coverage.py"
pytestmark = pytest.mark.skipif(not SCRIPT.is_file(), reason="needs the checkout")


@pytest.fixture
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("coverage_figures", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def summary(*counts: int) -> dict[str, Any]:
    keys = ("covered_lines", "missing_lines", "covered_branches", "missing_branches")
    return {"summary": dict(zip(keys, counts, strict=True))}


def test_figures_are_by_room(script: ModuleType) -> None:
    files = {
        "/a/mcpn/nets/petri.py": summary(3, 1, 1, 1),
        "/a/mcpn/nets/formats/pnml.py": summary(3, 1, 0, 0),
        "/a/mcpn/study.py": summary(0, 1, 0, 0),
    }
    assert script.by_room({"files": files}) == {
        "mcpn": {"lines": 0.0, "branches": 100.0},
        "nets": {"lines": 75.0, "branches": 50.0},
    }


def test_what_fell_is_told(script: ModuleType) -> None:
    kept = {"net": {"lines": 80.0, "branches": 50.0}, "gone": {"lines": 10.0, "branches": 10.0}}
    found = {"net": {"lines": 79.9, "branches": 49.0}, "new": {"lines": 1.0, "branches": 1.0}}
    assert script.fallen(kept, found) == ["net: branches fell from 50.0 to 49.0 percent"]
