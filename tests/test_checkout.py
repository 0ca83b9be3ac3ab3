"""A checkout: its folder shadows the installed package, and holds no kernel."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import mcpn
from tests.conftest import ROOT

INSTALLED = Path(mcpn.__file__).resolve().parent
ASKED = "import mcpn; print(mcpn.__file__, mcpn.open('experiments/ulysse/mission.xml').states().states)"


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """The package's sources without what is built, beside the missions."""
    clone = tmp_path / "clone"
    shutil.copytree(
        ROOT / "mcpn", clone / "mcpn", ignore=shutil.ignore_patterns("_kernel.*.so", "__pycache__")
    )
    (clone / "experiments").symlink_to(ROOT / "experiments")
    return clone


def run(clone: Path, path: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Runs Python in the clone with one more folder to import from."""
    unsafe = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    command = [sys.executable, *arguments]
    env = {**unsafe, "PYTHONPATH": str(path)}
    return subprocess.run(command, cwd=clone, env=env, capture_output=True, text=True, check=False)


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """A folder as ``pip install .`` fills it."""
    site = tmp_path / "site"
    site.mkdir()
    shutil.copytree(INSTALLED, site / "mcpn", ignore=shutil.ignore_patterns("__pycache__"))
    return site


def test_it_runs_with_the_installed_kernel(clone: Path, site: Path) -> None:
    found = run(clone, site, "-c", ASKED)
    assert found.stdout.split() == [str(clone / "mcpn" / "__init__.py"), "44299"], found.stderr


ALONE = """
import sys
from pathlib import Path
sys.path[1:] = [p for p in sys.path[1:] if p == sys.argv[1] or not Path(p, "mcpn").is_dir()]
import mcpn._kernel
"""
"""Asks for the kernel where no mcpn but those of the test can be imported."""


def test_a_kernel_of_another_version_is_not_taken(clone: Path, site: Path) -> None:
    assert run(clone, site, "-c", ALONE, str(site)).stderr == ""
    with (site / "mcpn" / "_kernel.pyi").open("a") as file:
        file.write("def of_tomorrow() -> None: ...\n")
    found = run(clone, site, "-c", ALONE, str(site))
    told = f"and the one that is installed in {site / 'mcpn'} is of another version: run pip install ."
    assert told in found.stderr.splitlines()[-1]


def test_without_one_a_sentence_says_what_to_do(clone: Path, tmp_path: Path) -> None:
    found = run(clone, tmp_path, "-c", ALONE, "")
    told = found.stderr.splitlines()[-1]
    assert told.startswith(f"mcpn.errors.LimitError: {clone / 'mcpn'} needs the compiled kernel")
    assert f", which is not built there: run pip install . in {clone}, with the Python that runs" in told
