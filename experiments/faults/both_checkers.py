"""What the checkers of certificates prove, those in Python and those in C++ of ``tests/certificates``."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from mcpn.certificates import certcheck, corecheck, ctlcheck, diagcheck, furthercheck
from mcpn.certificates.sections import sectioncheck

SOURCES = Path(__file__).resolve().parents[2] / "tests" / "certificates" / "second"
PROGRAMS: dict[str, tuple[ModuleType, str]] = {
    "claims": (certcheck, "checker"),
    "core": (corecheck, "core_checker"),
    "diagrams": (diagcheck, "diagram_checker"),
    "further": (furthercheck, "further_checker"),
    "sections": (sectioncheck, "section_checker"),
}
"""By entry the program in Python that reads it, and the one in C++."""
NOTHING = {"format": "mcpn-certificate", "version": 1, "mission": "m", "claims": [], "trusted": []}
"""An entry ``claims.json`` that claims nothing."""
MOST, SECONDS = 200_000, 60


@contextmanager
def written(entries: Mapping[str, Any]) -> Iterator[str]:
    """The path of a certificate with some entries, and no claims where there are none."""
    with tempfile.NamedTemporaryFile(delete=False) as file, zipfile.ZipFile(file, "w") as archive:
        for name, document in {"claims": NOTHING, **entries}.items():
            archive.writestr(f"{name}.json", json.dumps(document))
    try:
        yield file.name
    finally:
        os.unlink(file.name)


@cache
def compiled(name: str) -> Path:
    """A program in C++."""
    made = Path(tempfile.mkdtemp()) / name
    subprocess.run(["c++", "-O2", "-std=c++17", SOURCES / f"{name}.cpp", "-o", made], check=True)
    return made


def proved(of: str, entries: Mapping[str, Any], second: bool = False) -> tuple[set[str], set[str]]:
    """The keys of the claims that the programs for an entry prove, each by itself.

    Args:
        of: The entry.
        entries: Those of a certificate, without ``.json``.
        second: Whether the program in C++ is asked, too; else the same is given twice.
    """
    with written(entries) as path:
        first = _by_python(of, path)
        return first, _by_the_second(PROGRAMS[of][1], path) if second else first


def accepted(
    net: Mapping[str, Any], controller: Mapping[str, Any], second: bool = False
) -> tuple[set[str], set[str]]:
    """As :func:`proved`, of a controller beside a net: its one key is ``controller``."""
    with written({"net": net}) as path, tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(controller, file)
        file.flush()
        try:
            report = ctlcheck.checked(path, file.name, most=MOST, seconds=SECONDS)
        except (certcheck.Malformed, certcheck.Limit):
            report = []
        first = {key for how, key, _ in report if how == "proved"}
        return first, _by_the_second("controller_checker", path, file.name) if second else first


def by_the_second_of_sections(core: Mapping[str, Any], controller: Mapping[str, Any]) -> set[str]:
    """What the program in C++ proves of a controller beside a mission of sections, as of :func:`accepted`."""
    with written({"core": core}) as path, tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(controller, file)
        file.flush()
        return _by_the_second("section_controller_checker", path, file.name)


def _by_python(of: str, path: str) -> set[str]:
    try:
        found = PROGRAMS[of][0].checked(path, most=MOST, seconds=SECONDS)
    except (certcheck.Malformed, certcheck.Limit):
        return set()
    return {key for how, key, _ in found if how == "proved"}


def _by_the_second(name: str, *paths: str) -> set[str]:
    run = subprocess.run(
        [compiled(name), *paths, "--seconds", str(SECONDS)], check=False, capture_output=True, text=True
    )
    lines = run.stdout.splitlines()
    found = {line.removeprefix("proved ") for line in lines if line.startswith("proved ")}
    return {"controller"} if name.endswith("controller_checker") and found else found
