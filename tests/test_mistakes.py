"""Natural mistakes, from the page mistakes.toml: where, what was found, the word that helps."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.commands import mcpn

PAGE = tomllib.loads(Path(__file__).with_name("mistakes.toml").read_text())
MISTAKES: list[dict[str, Any]] = PAGE["mistake"]
FILES = {"mission.xml": PAGE["mission"], "drivers.toml": PAGE["drivers"], "tree.xml": PAGE["tree"]}
COMMANDS = {
    "mission.xml": ["check", "mission.xml"],
    "drivers.toml": ["run", "mission.xml", "--drivers", "drivers.toml", "--check"],
    "tree.xml": ["check", "tree.xml"],
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What is right, before a mistake is made."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_without_a_mistake_nothing_is_wrong() -> None:
    for command in COMMANDS.values():
        assert mcpn(*command, "--unverified" if "run" in command else "--json").returncode in (0, 1)


@pytest.mark.parametrize(
    "mistake", MISTAKES, ids=lambda mistake: mistake.get("new") or " ".join(mistake["command"])
)
def test_a_mistake_is_told(mistake: dict[str, Any]) -> None:
    name = mistake.get("in", "mission.xml")
    if "old" in mistake:
        assert FILES[name].count(mistake["old"]) == 1
        Path(name).write_text(FILES[name].replace(mistake["old"], mistake["new"]))
    found = mcpn(*mistake.get("command", COMMANDS[name]))
    assert found.returncode == 2, found.stdout
    if "line" in mistake:
        told = [line for line in found.stderr.splitlines() if line.startswith("error: ")]
        at = f"error: {name}:{mistake['line']}: "
        assert any(line.startswith(at) for line in told), found.stderr
    for text in mistake["says"]:
        assert text in found.stderr, found.stderr
