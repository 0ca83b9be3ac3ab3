"""Files of trees: what is read, what is refused with its line, and what is written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

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
