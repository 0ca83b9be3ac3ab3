"""What `check` of a mission loads: its own questions' modules, records in place of compiled dataclasses."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "mcpn"
MISSION = PACKAGE.parent / "experiments" / "ulysse" / "mission.xml"
MOST_MODULES = 230
"""Modules of mcpn: of what is asked of every mission, and what this one has."""
STANDARD = {
    "mcpn.answers.verdicts.mission": {"Verdict", "MissionCheck"},  # which the page of the API shows
    "mcpn.errors": {"Source"},  # which records stand behind
}
"""Dataclasses whose methods the standard library compiles in each check."""


@cache
def loaded() -> frozenset[str]:
    script = (
        "import sys\n"
        "from mcpn.cli.line import run\n"
        f"assert run(['check', {str(MISSION)!r}]) == 0\n"
        "print('loaded', *(name for name in sys.modules if name.partition('.')[0] == 'mcpn'))\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return frozenset(run.stdout.splitlines()[-1].split()[1:])


def compiled_at_once(module: str) -> set[str]:
    """The classes of a module that are dataclasses of the standard library."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    if not file.exists():  # the kernel
        return set()
    return {
        node.name
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ClassDef)
        and any(ast.unparse(each).startswith("dataclass") for each in node.decorator_list)
    }


def test_no_further_module_is_loaded_than_a_check_has_use_for() -> None:
    assert len(loaded()) <= MOST_MODULES


def test_a_check_runs_no_controller_and_writes_no_certificate() -> None:
    rooms = ("mcpn.robot.", "mcpn.controller.", "mcpn.certificates.", "mcpn.trees.", "mcpn.editor.")
    assert [name for name in sorted(loaded()) if name.startswith(rooms)] == []


def test_what_every_check_loads_is_compiled_as_it_is_called() -> None:
    found = {module: names for module in loaded() if (names := compiled_at_once(module))}
    assert found == STANDARD
