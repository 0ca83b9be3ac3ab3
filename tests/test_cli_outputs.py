"""What commands write replaces neither what they have read nor what else they write."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.commands import mcpn

MISSION = """<mission name="m" xmlns="urn:mcpn:mission:1">
<import href="robot.xml"/>
<objective name="x" activities="go"/>
</mission>
"""
ROBOT = """<robot name="r" xmlns="urn:mcpn:mission:1">
<hardware name="h"/><activity name="go" consumes="h"/></robot>
"""
DRIVERS = '[activities.go]\nprocess = ["true"]\n'
TREE = '<root BTCPP_format="4"><BehaviorTree ID="M"><Go/></BehaviorTree></root>'


def refused(asked: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Asks a command, which writes nothing and says of a file that it cannot be written."""
    monkeypatch.chdir(folder)
    texts = {"mission.xml": MISSION, "robot.xml": ROBOT, "tree.xml": TREE}
    texts |= {"drivers.toml": DRIVERS, "net.net": "net n\npl p (1)\ntr t p -> q\n"}
    for name, text in texts.items():
        Path(name).write_text(text)
    found = mcpn(*asked.split())
    assert found.returncode == 2
    assert "cannot be written: " in found.stderr
    assert {path.name: path.read_text() for path in folder.iterdir()} == texts


@pytest.mark.parametrize(
    "asked",
    [
        "check mission.xml --certificate mission.xml",
        "check mission.xml --certificate robot.xml",
        "check tree.xml --certificate tree.xml",
        "causes mission.xml --certificate mission.xml",
        "causes mission.xml --openpsa robot.xml",
        "causes mission.xml --fmeca new.csv --certificate new.csv",
        "report mission.xml -o new.html --certificate new.html",
        "report mission.xml -o new.html --certificate robot.xml",
        "controller mission.xml -o new --certificate mission.xml",
        "ask mission.xml success --scn robot.xml",
        "tests mission.xml --btcpp tree.xml --tree tree.xml",
        "convert net.net net.net",
        "run mission.xml --drivers drivers.toml --journal mission.xml",
        "run mission.xml --drivers drivers.toml --journal drivers.toml",
        "run mission.xml --drivers drivers.toml --snapshot robot.xml",
        "run mission.xml --drivers drivers.toml --journal new.json --snapshot new.json",
        "run mission.xml --drivers drivers.toml --resume net.net --journal net.net",
    ],
)
def test_no_command_writes_over_what_it_reads_or_writes(
    asked: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused(asked, tmp_path, monkeypatch)


@pytest.mark.parametrize(
    "asked",
    [
        "check mission.xml --certificate none/new",
        "causes mission.xml --fmeca new.csv --certificate none/new",
        "report mission.xml -o new.html --certificate none/new",
        "controller mission.xml -o new --certificate none/new",
        "controller mission.xml -o new --certificate .",
        "convert mission.xml none/new.dot",
        "run mission.xml --drivers drivers.toml --journal new.json --snapshot none/new",
    ],
)
def test_where_no_file_can_be_is_said_before_anything_is_written(
    asked: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The controller was written before its certificate was refused, which is half of what was asked for."""
    refused(asked, tmp_path, monkeypatch)


def test_a_certificate_may_lie_in_the_folder_that_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.xml").write_text(MISSION.replace('<import href="robot.xml"/>', ROBOT))
    assert mcpn("controller", "m.xml", "-o", "new", "--certificate", "new/m.cert").returncode == 0
    assert sorted(path.name for path in Path("new").iterdir()) == ["controller.json", "m.cert"]


@pytest.mark.parametrize("other", [["--structure"], ["--format", "sarif"]])
def test_a_certificate_is_not_asked_for_in_vain(other: list[str], tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(MISSION.replace('<import href="robot.xml"/>', ROBOT))
    found = mcpn("check", tmp_path / "m.xml", *other, "--certificate", tmp_path / "m.cert")
    assert (found.returncode, (tmp_path / "m.cert").exists()) == (2, False)
    assert f"--certificate is of all that check says, and {' '.join(other)}" in found.stderr


@pytest.mark.parametrize(
    ("path", "found"), [(".", "a directory"), ("..", "a directory"), ("pipe", "no regular file")]
)
def test_what_is_no_file_is_not_replaced(
    path: str, found: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As ``/dev/null`` was, for who may do that."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    Path("m.xml").write_text(MISSION.replace('<import href="robot.xml"/>', ROBOT))
    said = mcpn("check", "m.xml", "--certificate", path)
    assert (said.returncode, said.stderr) == (2, f"error: {path}: cannot be written: it is {found}\n")
    assert Path("pipe").is_fifo()
