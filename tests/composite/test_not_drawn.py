"""What asks a mission of many sections by types never draws the net of the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Never

import pytest

from experiments.growth.growth import of_natural
from mcpn.cli.line import run
from mcpn.mission.writer import save_mission
from mcpn.nets.numbering import Nodes

COMMANDS = (
    ("check",),
    ("check", "--json"),
    ("causes",),
    ("causes", "--json"),
    ("controller", "--form", "modular", "--output", "made"),
    ("controller", "--form", "hierarchical", "--output", "made"),
)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """All nodes of a net that has copies are refused."""

    def refused(nodes: Nodes[object]) -> Never:
        raise AssertionError(f"all {len(nodes)} nodes are drawn")

    monkeypatch.setattr(Nodes, "_every", refused)


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_no_command_draws_all(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    save_mission(of_natural("sites")(25), "mission.xml")
    assert run([command[0], "mission.xml", *command[1:]]) in (0, 1)


@pytest.mark.usefixtures("drawn")
def test_the_fixture_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    save_mission(of_natural("sites")(2), "mission.xml")
    assert run(["check", "mission.xml", "--engine", "symbolic"]) not in (0, 1)
    assert "nodes are drawn" in capsys.readouterr().err
