"""Trees are checked and asked as they are, also in several files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import mcpn
from mcpn.cli.line import run


def test_a_tree_is_checked_and_asked_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "fetch-it.xml"
    path.write_text(
        '<?xml version="1.0"?><!-- a tree --><root BTCPP_format="4"><BehaviorTree ID="A">\n'
        '<Sequence><a _skipIf="x && y"/><b/></Sequence></BehaviorTree></root>'
    )
    assert run(["check", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["mission"] == "fetch_it"
    (translated,) = found["translated"]
    assert translated["library"] == "BehaviorTree.CPP 4.0 to 4.10 (BTCPP_format 4)"
    assert run(["check", str(path)]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "line 2: a is more runs: _skipIf='x && y' is free" in told
    assert "warning: fetch-it.xml:2: & or < in an attribute is no XML" in told
    assert run(["ask", str(path), "E F objective(b)"]) == 0
    path.write_text('<root BTCPP_format="4"><BehaviorTree ID="A">\n<Odd><a/><b/></Odd></BehaviorTree></root>')
    assert run(["check", str(path)]) == 2
    assert f"{path}:2: Odd has 2 children" in capsys.readouterr().err


def test_versions_are_said_of_a_tree_that_is_checked_and_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "turns.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A">\n'
        "<RoundRobin><Inverter><Spin/></Inverter><BackUp/></RoundRobin></BehaviorTree></root>"
    )
    # Until Nav2 1.4 the success of the last child is one of RoundRobin.
    succeeds = "A G (objective(BackUp) -> E F success)"
    for version, code in (("1.4", 0), ("1.5", 1)):
        library = ["--library", f"nav2={version}"]
        assert run(["ask", str(path), succeeds, *library]) == code
        run(["check", str(path), "--json", *library])
        (translated,) = json.loads(capsys.readouterr().out.splitlines()[-1])["translated"]
        assert f"Nav2 {version}" in translated["library"]
        assert translated["approximations"] == []
    assert len(mcpn.open(path, library=["nav2=1.5"]).ledger.inexact) == 0  # type: ignore[union-attr]
    assert run(["check", str(path)]) in (0, 1)
    assert "depends on the version" in capsys.readouterr().out
    assert run(["check", str(path), "--library", "nav2=7"]) == 2
    assert "no version '7' of Nav2" in capsys.readouterr().err


def test_versions_of_what_is_no_tree_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="a"/></robot>'
        '<objective name="o" activities="a"/></mission>'
    )
    for command in (["check"], ["ask"]):
        assert run([*command, str(path), "--library", "nav2=1.5"]) == 2
        said = f"{path}: found a mission, expected a behaviour tree"
        assert said in capsys.readouterr().err


def test_a_file_that_is_no_tree_is_refused_as_a_mission(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "odd.xml"
    for text in ("<rooted/>", "<!-- <root/> --><tree/>", "<!-- <root/>", ""):
        path.write_text(text)
        assert run(["check", str(path)]) == 2
        assert "behaviour tree" not in capsys.readouterr().err


def tree_file(path: Path, name: str, inside: str, head: str = "") -> Path:
    path.parent.mkdir(exist_ok=True)
    said = f' main_tree_to_execute="{name}"' if head == "main" else ""
    text = f'<root BTCPP_format="4"{said}>{head if head != "main" else ""}<BehaviorTree ID="{name}">'
    path.write_text(f"{text}{inside}</BehaviorTree></root>")
    return path


def test_a_folder_of_trees(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "trees"
    tree_file(folder / "main.xml", "Main", '<Sequence><SubTree ID="Go"/><b/></Sequence>')
    tree_file(folder / "parts" / "go.xml", "Go", "<a/>")
    (folder / "other.xml").write_text("<package/>")
    assert run(["init", str(tmp_path / "m"), "--from", str(folder)]) == 0
    told = capsys.readouterr().err
    assert "trees: 4 nodes. exact: 4." in told
    assert "expected <root> of a behaviour tree, found <package>: not read" in told
    tree_file(folder / "third.xml", "Third", "<c/>")
    assert run(["init", str(tmp_path / "n"), "--from", str(folder)]) == 2
    assert "expected one of Go, Main, Third: say it with --main" in capsys.readouterr().err
    assert run(["init", str(tmp_path / "n"), "--from", str(folder), "--main", "Third"]) == 0
    (tmp_path / "empty").mkdir()
    assert run(["init", str(tmp_path / "o"), "--from", str(tmp_path / "empty")]) == 2


def test_several_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main = tree_file(tmp_path / "main.xml", "Main", '<Sequence><SubTree ID="Go"/><b/></Sequence>')
    go = tree_file(tmp_path / "elsewhere" / "go.xml", "Go", "<a/>")
    assert run(["init", str(tmp_path / "m"), "--from", str(main), "--from", str(go)]) == 0
    assert run(["init", str(tmp_path / "n"), "--from", str(main)]) == 2
    assert "no tree 'Go', expected one of Main" in capsys.readouterr().err


def test_includes_stay_in_the_folder_that_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree_file(tmp_path / "go.xml", "Go", "<a/>")
    tree_file(tmp_path / "pack" / "come.xml", "Come", "<b/>")
    both = '<Sequence><SubTree ID="Go"/><SubTree ID="Come"/></Sequence>'
    head = '<include path="../go.xml"/><include ros_pkg="pack" path="come.xml"/>'
    main = tree_file(tmp_path / "main" / "main.xml", "Main", both, head)
    command = ["init", str(tmp_path / "m"), "--from", str(main)]
    assert run(command) == 2
    told = capsys.readouterr().err
    assert "leaves the folder of the main file: --import-root says another" in told
    assert "in package 'pack'" in told
    assert run([*command, "--import-root", str(tmp_path)]) == 0
    (tmp_path / "inner").mkdir()
    assert (
        run([*command[:1], str(tmp_path / "n"), *command[2:], "--import-root", str(tmp_path / "inner")]) == 2
    )
