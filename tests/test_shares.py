"""Properties that mostly look away fail, in the quick profile too."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ROOT
from tests.shares import CEILING, most

PROPERTIES = """
from itertools import count
from hypothesis import given, settings, strategies as st
from tests.shares import returns_early

def leaving(share, examples=10):
    counted = count()

    @settings(max_examples=examples)
    @given(st.integers())
    def test(number):
        if next(counted) < share * examples:
            returns_early("odd")

    return test

test_half = leaving(0.5)
test_most = leaving(0.8, 40)
test_all_of_few = leaving(1, 5)
"""


def test_a_property_that_mostly_returns_early_fails(tmp_path: Path) -> None:
    (tmp_path / "test_some.py").write_text(PROPERTIES)
    command = [sys.executable, "-m", "pytest", "-q", "-rf", "-p", "tests.conftest", "-p", "no:cacheprovider"]
    environment = {**os.environ, "HYPOTHESIS_PROFILE": "smoke", "PYTHONPATH": str(tmp_path)}
    # At the end of the path: the package that is installed is tested, not the checkout's.
    (tmp_path / "sitecustomize.py").write_text(f"import sys; sys.path.append({str(ROOT)!r})")
    found = subprocess.run(
        [*command, "test_some.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    failed = sorted(line.split()[1] for line in found.stdout.splitlines() if line.startswith("FAILED "))
    assert failed == ["test_some.py::test_all_of_few", "test_some.py::test_most"], found.stdout
    assert "returned early for 32 of 40 examples: 32 odd" in found.stdout


@pytest.mark.parametrize(("examples", "fails"), [(5, 5), (10, 10), (40, 31), (200, 134)])
def test_the_ceiling_is_near_the_share(examples: int, fails: int) -> None:
    assert fails - 1 <= most(examples, CEILING) < fails
