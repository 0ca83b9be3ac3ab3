"""The package: its extras mean what they say, its versions agree, and a wheel alone does the main job."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
from pathlib import Path
from typing import Any

import pytest

import mcpn
from tests.conftest import ROOT

PYPROJECT = ROOT / "pyproject.toml"
pytestmark = pytest.mark.skipif(not PYPROJECT.is_file(), reason="needs the checkout or a source distribution")
USERS = ("distributed", "pictures", "pyeda", "report", "risk", "testing")
"""The extras that users take; the others are for work on mcpn itself."""


def project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads(PYPROJECT.read_text())["project"]
    return found


def test_every_extra_that_is_spoken_of_exists_and_every_users_extra_is_spoken_of() -> None:
    texts = [
        *(ROOT / "mcpn").rglob("*.py"),
        *(ROOT / "docs").rglob("*.md"),
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
    ]
    spoken = {
        extra
        for path in texts
        for names in re.findall(r"(?:mcpn|\.)\[([a-z, ]+)\]", path.read_text())
        for extra in re.split(r",\s*", names)
    }
    extras = set(project()["optional-dependencies"])
    assert spoken <= extras
    assert set(USERS) <= spoken


def test_the_tests_bring_what_everybody_runs_and_no_more() -> None:
    """What brings worlds, Storm or a browser is left to ``test-all``, which has all of ``test``."""
    extras = project()["optional-dependencies"]

    def brought(extra: str) -> set[str]:
        inner = [name for line in extras[extra] for name in re.findall(r"^mcpn\[(.*)\]", line)]
        own = {re.split(r"[>\[<=; ]", line)[0] for line in extras[extra] if not line.startswith("mcpn[")}
        return own.union(*(brought(name) for names in inner for name in names.split(",")))

    heavy = {"pandas", "playwright", "pyrobosim", "stormpy", "eclipse-zenoh", "matplotlib", "mypy"}
    assert not heavy & brought("test")
    assert heavy | brought("test") <= brought("test-all")


def test_one_version_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text()
    (cited,) = re.findall(r"^version: (\S+)$", citation, re.MULTILINE)
    assert project()["version"] == mcpn.__version__ == cited


def test_every_dependency_has_a_lower_bound() -> None:
    bounds = subprocess.run(
        [sys.executable, str(ROOT / ".ci" / "lower_bounds.py")], capture_output=True, text=True, check=True
    ).stdout.split()
    wanted = {re.split(r"[>\[]", line)[0] for line in project()["dependencies"]}
    assert wanted <= {line.split("==")[0] for line in bounds}


@pytest.mark.slow
def test_a_wheel_alone_does_the_main_job(tmp_path: Path) -> None:
    """From sources to a source distribution, to a wheel, to a fresh environment that finds no compiler."""
    if importlib.util.find_spec("build") is None:
        pytest.skip("needs mcpn[packaging]")
    source = tmp_path / "source"
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".git", "*.so", "build", "dist", ".*_cache"))
    subprocess.run([sys.executable, "-m", "build", "-o", tmp_path / "dist", source], check=True, timeout=900)
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    if importlib.util.find_spec("auditwheel") is not None:
        shown = subprocess.run(
            [sys.executable, "-m", "auditwheel", "show", wheel], capture_output=True, text=True, check=True
        )
        assert '"manylinux_2_' in shown.stdout
    venv.create(tmp_path / "fresh", with_pip=True)
    python = tmp_path / "fresh" / "bin" / "python"
    subprocess.run(
        [python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", wheel], check=True, timeout=600
    )
    nowhere = {**os.environ, "PATH": str(tmp_path / "fresh" / "bin"), "CC": "false", "CXX": "false"}
    nowhere.pop("PYTHONPATH", None)
    done = subprocess.run(
        [python, ROOT / ".ci" / "main_job.py"],
        cwd=tmp_path,
        env=nowhere,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the main job is done" in done.stdout
