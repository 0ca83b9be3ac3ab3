"""What is said of a behaviour tree, by every command that takes missions; the others name init --from."""

from __future__ import annotations

import json
from pathlib import Path

import click
import pytest

import mcpn
from mcpn.cli.line import command_line, run

TREES = """<root BTCPP_format="4">
<BehaviorTree ID="A"><Sequence><SubTree ID="B"/><Look/></Sequence></BehaviorTree>
<BehaviorTree ID="C"><ReactiveFallback><Seen/><SubTree ID="B"/></ReactiveFallback></BehaviorTree>
<BehaviorTree ID="B"><RoundRobin><Inverter><Spin/></Inverter><BackUp/></RoundRobin></BehaviorTree>
</root>"""
MODEL = '<root><TreeNodesModel><Condition ID="Seen"/></TreeNodesModel></root>'
TAKING = {
    "check": (),
    "ask": ("E F failure",),
    "causes": (),
    "report": ("-o", "report.html"),
    "simulate": ("--nominal",),
    "states": (),
    "alternatives": (),
    "compare": ("--repeat", "1"),
    "convert": ("net.pnml",),
}
"""Commands that take trees, with what else they need."""
REFUSING = {
    "controller": ("-o", "out"),
    "run": ("--drivers", "none.toml"),
    "bench": (),
    "monitor": ("-o", "out"),
    "tests": ("-o", "out"),
}
"""Commands of a robot that a mission says more of than a tree."""


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("models.xml").write_text(MODEL)
    path = tmp_path / "turns.xml"
    path.write_text(TREES)
    return path


def test_each_command_that_reads_a_mission_takes_trees_or_refuses_them() -> None:
    reading = {
        name
        for name in command_line.list_commands(click.Context(command_line))
        if (command := command_line.get_command(click.Context(command_line), name)) is not None
        and {"file", "mission", "source"} & {each.name for each in command.params}
    }
    assert reading == TAKING.keys() | REFUSING.keys() | {"serve"}  # which is served until it is stopped


@pytest.mark.parametrize("command", TAKING)
def test_commands_that_take_trees(command: str, tree: Path, capsys: pytest.CaptureFixture[str]) -> None:
    more = TAKING[command]
    assert run([command, str(tree), *more]) == 2
    assert "turns.xml:1: no main_tree_to_execute, expected one of A, B, C" in capsys.readouterr().err
    said = ["--main", "C", "--library", "nav2=1.5", "--nodes", "models.xml", "--faulty-leaves"]
    assert run([command, str(tree), *more, *said]) in (0, 1)
    assert run([command, str(tree), *more, "--main", "A", "--library", "nav2=9"]) == 2
    assert "no version '9' of Nav2" in capsys.readouterr().err


@pytest.mark.parametrize("command", REFUSING)
def test_commands_that_refuse_trees(command: str, tree: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for text in (TREES, TREES.replace('<root BTCPP_format="4">', '<root main_tree_to_execute="A">')):
        tree.write_text(text)
        assert run([command, str(tree), *REFUSING[command]]) == 2
        told = "found a behaviour tree, expected a mission: mcpn init NAME --from"
        assert f"{tree}:1: {told}" in " ".join(capsys.readouterr().err.split())


def test_options_mean_the_same_for_init_and_check(tree: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = ["--main", "C", "--library", "nav2=1.5", "--nodes", "models.xml", "--faulty-leaves"]
    assert run(["init", "turns", "--from", str(tree), *said]) == 0
    capsys.readouterr()
    found = []
    for mission, options in ((str(tree), said), ("turns/mission.xml", [])):
        run(["check", mission, *options, "--json"])
        run(["causes", mission, *options, "--json"])
        checked, causes = map(json.loads, capsys.readouterr().out.splitlines())
        found.append((checked["translated"], checked["verdicts"], causes["mission"]))
    assert found[0] == found[1]
    assert 'event name="Seen_succeeds"' in Path("turns/robot.xml").read_text()  # a condition, by the model
    assert found[0][0][0]["library"].startswith("Nav2 1.5 (asked for)")


def test_a_folder_of_trees_is_checked(tree: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder in which no file is a tree is no mission either."""
    assert run(["check", str(tree.parent), "--main", "A"]) in (0, 1)
    capsys.readouterr()
    tree.unlink()
    assert run(["check", str(tree.parent)]) == 2
    assert "behaviour tree" not in capsys.readouterr().err


def test_leaves_that_may_crash_are_in_cut_sets(tree: Path) -> None:
    for faulty, expected in ((False, []), (True, [("Look",)])):
        study = mcpn.open(tree, main="A", faulty_leaves=faulty, library=["nav2=1.4"])
        assert [cut for cut in study.causes().mission.cut_sets if cut == ("Look",)] == expected


def test_options_of_trees_are_of_trees(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "small.net"
    path.write_text("net small\ntr t a -> b\npl a (1)\n")
    for options in (["--main", "A"], ["--library", "nav2=1.5"], ["--faulty-leaves"], ["--nodes", "m.xml"]):
        assert run(["check", str(path), *options]) == 2
        told = f"found a net, expected a behaviour tree: {options[0]} is of trees"
        assert told in capsys.readouterr().err
