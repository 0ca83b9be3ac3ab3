"""Files of trees: what is read, what is refused with its line, and what is written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import mcpn
from mcpn.cli.line import run
from mcpn.errors import InputError
from mcpn.mission.xml import read_mission
from mcpn.trees.importing import translate
from mcpn.trees.reading import read_forest

ROBUST = """\
<root BTCPP_format="4">
  <include path="parts/go.xml"/>
  <BehaviorTree ID="Main">
    <Sequence name="Both ways">
      <SubTree ID="Go" target="table" mood="good"/>
      <SubTree ID="Go" target="door"/>
      <Wave hand="{hand}" times="3"/>
    </Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Condition ID="Lit"/>
  </TreeNodesModel>
</root>
"""
GO = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Go">
    <RetryUntilSuccessful num_attempts="3">
      <ReactiveSequence>
        <Lit/>
        <Drive target="{target}"/>
      </ReactiveSequence>
    </RetryUntilSuccessful>
  </BehaviorTree>
</root>
"""


def written(folder: Path) -> Path:
    (folder / "parts").mkdir()
    (folder / "main.xml").write_text(ROBUST)
    (folder / "parts" / "go.xml").write_text(GO)
    return folder / "main.xml"


def test_what_is_written_reads_back_as_the_same_mission(tmp_path: Path) -> None:
    tree = written(tmp_path)
    assert run(["init", str(tmp_path / "both"), "--from", str(tree)]) == 0
    assert (
        read_mission(tmp_path / "both" / "mission.xml")
        == translate(read_forest(tree), "both", tree.name).mission
    )


def test_subtrees_are_protocols_with_their_ports(tmp_path: Path) -> None:
    mission = translate(read_forest(written(tmp_path)), "both", "main.xml").mission
    (protocol,) = mission.protocols
    assert [p.name for p in protocol.parameters] == ["mood", "target"]
    uses = [block for block in mission.blocks if block.TAG == "use"]
    assert [{p.name: p.value for p in use.parameters} for use in uses] == [  # type: ignore[union-attr]
        {"target": "table", "mood": "good"},
        {"target": "door"},
    ]
    assert [event.name for event in mission.events] == ["Lit_fails"]


def test_leaves_may_be_faulty(tmp_path: Path) -> None:
    mission = translate(read_forest(written(tmp_path)), "both", "main.xml", faulty=True).mission
    assert {a.name for a in mission.activities if a.faulty} == {"Lit", "Drive", "Wave"}


BAD = {
    "no root": ("<tree/>", 1, "expected <root> of a behaviour tree, found <tree>"),
    "doctype": ("<!DOCTYPE root [<!ENTITY a 'b'>]><root/>", 1, "DTD"),
    "not well-formed": ("<root>\n<BehaviorTree></root>", 2, "not well-formed"),
    "format": ('<root BTCPP_format="5"/>', 1, "BTCPP_format '5', expected 3 or 4"),
    "no tree": ('<root BTCPP_format="4"/>', 1, "found no <BehaviorTree>"),
    "no such main": (
        '<root main_tree_to_execute="B"><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        1,
        "no tree 'B' to execute, expected one of A",
    ),
    "two roots": ('<root>\n<BehaviorTree ID="A">\n<a/><b/></BehaviorTree></root>', 2, "has 2 roots"),
    "two of a name": (
        '<root><BehaviorTree ID="A"><a/></BehaviorTree>\n<BehaviorTree ID="A"><a/></BehaviorTree></root>',
        2,
        "already a tree 'A'",
    ),
    "no children": (
        '<root><BehaviorTree ID="A">\n<Sequence/></BehaviorTree></root>',
        2,
        "expected at least 1",
    ),
    "too many children": (
        '<root><BehaviorTree ID="A">\n<Inverter><a/><b/></Inverter></BehaviorTree></root>',
        2,
        "Inverter has 2 children, expected 1",
    ),
    "no such subtree": (
        '<root><BehaviorTree ID="A">\n<SubTree ID="B"/></BehaviorTree></root>',
        2,
        "no tree 'B', expected one of A",
    ),
    "cycle": (
        '<root><BehaviorTree ID="A">\n<Sequence><SubTree ID="A"/></Sequence></BehaviorTree></root>',
        2,
        "tree A holds itself",
    ),
    "unknown control": (
        '<root><BehaviorTree ID="A">\n<Odd><a/><b/></Odd></BehaviorTree></root>',
        2,
        "Odd has 2 children, and what it does with them is not known",
    ),
    "known and not translated": (
        '<root><BehaviorTree ID="A">\n<ManualSelector><a/><b/></ManualSelector></BehaviorTree></root>',
        2,
        "ManualSelector has no translation",
    ),
    "include away": (
        '<root>\n<include path="../other.xml"/><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        2,
        "leaves the folder of the main file",
    ),
    "include of nothing": (
        '<root>\n<include path="other.xml"/><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        2,
        "include of other.xml: no such file",
    ),
    "package": ('<root>\n<include ros_pkg="p" path="o.xml"/></root>', 2, "in package 'p'"),
    "explicit form without name": (
        '<root><BehaviorTree ID="A">\n<Action/></BehaviorTree></root>',
        2,
        "without ID",
    ),
    "too deep": (
        '<root><BehaviorTree ID="A">\n'
        + "<Sequence>" * 70
        + "<a/>"
        + "</Sequence>" * 70
        + "</BehaviorTree></root>",
        2,
        "nested more than 64 deep",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_trees_are_refused_with_their_line(name: str, tmp_path: Path) -> None:
    text, line, message = BAD[name]
    path = tmp_path / "tree.xml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        translate(read_forest(path), "m", "tree.xml")
    problem = error.value.problems[0]
    assert problem.source is not None
    assert (problem.source.file, problem.source.line) == (str(path), line)
    assert message in problem.message
    assert run(["init", str(tmp_path / "m"), "--from", str(path)]) == 2
    assert not (tmp_path / "m").exists()


def test_options_that_belong_together(tmp_path: Path) -> None:
    for options in (["--main", "A"], ["--faulty-leaves"], ["--from", "t.xml", "--example", "drone"]):
        assert run(["init", str(tmp_path / "m"), *options]) == 2


def test_what_is_not_exact_is_told_with_every_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root><BehaviorTree ID="A"><Sequence><a/>\n<Odd><b/></Odd>\n'
        '<RateController hz="1"><c/></RateController></Sequence></BehaviorTree></root>'
    )
    assert run(["init", str(tmp_path / "m"), "--from", str(path), "--json"]) == 0
    counts = json.loads(capsys.readouterr().out)["ledger"]["counts"]
    assert counts == {"exact": 4, "time": 1, "more": 1, "left_out": 0}
    mission = str(tmp_path / "m" / "mission.xml")
    assert run(["check", mission]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "made of tree.xml, 6 nodes: exact 4, exact but for time 1, more runs 1. Read as Behav" in told
    assert "That success is reachable, or that the end always is, does not carry over." in told
    assert "line 2: Odd is more runs: what Odd does with its child is not known" in told
    assert run(["check", mission, "--json"]) == 0
    (translated,) = json.loads(capsys.readouterr().out)["translated"]
    assert [(each["line"], each["kind"]) for each in translated["approximations"]] == [
        (2, "more"),
        (3, "time"),
    ]
    page = tmp_path / "page.html"
    assert run(["report", mission, "-o", str(page)]) == 0
    assert "Made of tree.xml, 6 nodes" in page.read_text()


# --- a tree is checked and asked as it is ----------------------------------------------------------------


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


# --- several files ---------------------------------------------------------------------------------------


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


# --- nothing is skipped because no code asks for it --------------------------------------------------------

UNKNOWN = {
    "attribute of the root": (
        '<root odd="1"><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of a tree": (
        '<root><BehaviorTree ID="A" odd="1"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of an include": (
        '<root><include path="o.xml" odd="1"/><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of a model": (
        '<root><BehaviorTree ID="A"><a/></BehaviorTree>'
        '<TreeNodesModel><Action ID="a" odd="1"/></TreeNodesModel></root>',
        "no attribute 'odd', expected ID, editable",
    ),
    "element in a model": (
        '<root><BehaviorTree ID="A"><a/></BehaviorTree>'
        '<TreeNodesModel><Action ID="a"><odd/></Action></TreeNodesModel></root>',
        "found <odd> in <Action>, expected <input_port>",
    ),
    "element beside trees": ('<root><odd/><BehaviorTree ID="A"><a/></BehaviorTree></root>', "found <odd>"),
    "ID where none belongs": (
        '<root><BehaviorTree ID="A"><a ID="b"/></BehaviorTree></root>',
        "no attribute 'ID'",
    ),
    "port of a node": (
        '<root><BehaviorTree ID="A"><Inverter odd="1"><a/></Inverter></BehaviorTree></root>',
        "no port",
    ),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_what_is_not_known_is_refused(name: str, tmp_path: Path) -> None:
    text, message = UNKNOWN[name]
    path = tmp_path / "tree.xml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_forest(path)
    assert any(message in problem.message for problem in error.value.problems)
    assert all(problem.source and problem.source.line == 1 for problem in error.value.problems)


def test_what_libraries_ignore_is_listed(tmp_path: Path) -> None:
    """Attributes that begin with ``_`` and text mean nothing: a warning says so, and what was meant."""
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><Sequence _odd="1" _description="x">\n'
        '<a _skipif="x"/>stray</Sequence></BehaviorTree></root>'
    )
    assert [problem.message for problem in read_forest(path).warnings] == [
        "<Sequence> holds text, which means nothing",
        "a: attribute _skipif means nothing, _skipIf does",
        "Sequence: attribute _odd means nothing",
    ]


def test_names_in_other_letters(tmp_path: Path) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root><BehaviorTree ID="A"><Sequence><Go name="抓取"/><Go name="Größe prüfen"/><拿/></Sequence>'
        "</BehaviorTree></root>"
    )
    mission = translate(read_forest(path), "m", "tree.xml").mission
    assert [(block.name, block.description) for block in mission.blocks] == [
        ("Go", "抓取"),
        ("Grosse_prufen", "Größe prüfen"),
        ("node", "拿"),
    ]


def test_what_editors_and_version_3_write(tmp_path: Path) -> None:
    """Attributes of editors stand anywhere; version 3 writes the ports of a tree as elements."""
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root main_tree_to_execute="A"><BehaviorTree ID="A" _description="x" _favorite="true">\n'
        '<SubTree ID="B"><remap internal="to" external="goal"/></SubTree></BehaviorTree>\n'
        '<BehaviorTree ID="B"><a to="{to}"/></BehaviorTree>\n'
        '<TreeNodesModel><SubTree ID="B"><MetadataFields><Metadata runnable="true"/></MetadataFields>'
        '<input_port name="to" default="x">Where to</input_port></SubTree></TreeNodesModel></root>'
    )
    forest = read_forest(path)
    assert forest.main.root.ports == {"to": "{goal}"}
    assert [each.message for each in forest.warnings] == ["<BehaviorTree>: attribute _favorite means nothing"]
