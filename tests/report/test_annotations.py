"""``check --format``: what is wrong by its places, for tools of continuous integration."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.commands import mcpn

MISSION = """<mission name="patrol" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="wheels" repairable="false"/>
    <hardware name="lamp"/>
    <activity name="drive" consumes="wheels"/>
  </robot>
  <requirement name="once" description="It goes, 100 %: once" formula="AG !objective(go)"/>
  <requirement name="hint" severity="advice" formula="AG !success"/>
  <objective name="go" activities="drive" failure="go"/>
</mission>
"""


@pytest.fixture
def mission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path("my patrol, 1.xml")
    path.write_text(MISSION)
    return path


def commands(text: str) -> list[tuple[str, dict[str, str], str]]:
    """Workflow commands, read as GitHub's runner reads them."""
    found = []
    for line in text.splitlines():
        said = re.fullmatch(r"::(\w+) ([^:]*)::(.*)", line)
        assert said is not None, line
        properties = dict(pair.split("=", 1) for pair in said[2].split(","))
        for code, letter in (("%2C", ","), ("%3A", ":"), ("%0D", "\r"), ("%0A", "\n"), ("%25", "%")):
            properties = {key: value.replace(code, letter) for key, value in properties.items()}
        found.append((said[1], properties, said[3].replace("%0A", "\n").replace("%25", "%")))
    return found


def test_annotations_of_github(mission: Path) -> None:
    run = mcpn("check", mission, "--format", "github")
    assert run.returncode == 1
    found = commands(run.stdout)
    assert {properties["file"] for _, properties, _ in found} == {"my patrol, 1.xml"}
    by_title = {(level, p["title"], int(p["line"])): message for level, p, message in found}
    assert set(by_title) >= {
        ("error", "mcpn can_always_finish", 1),
        ("error", "mcpn requirement", 7),
        ("warning", "mcpn requirement", 8),
        ("warning", "mcpn warning", 4),  # the lamp, which nobody uses
    }
    assert "It goes, 100 %: once" in by_title["error", "mcpn requirement", 7]
    first, *steps = by_title["error", "mcpn can_always_finish", 1].split("\n")
    assert first == "The mission can reach a state from which it cannot end."
    assert any("wheels fails" in step for step in steps)


def results(text: str) -> list[dict[str, Any]]:
    (run,) = json.loads(text)["runs"]
    rules = {rule["id"] for rule in run["tool"]["driver"]["rules"]}
    assert {result["ruleId"] for result in run["results"]} == rules
    found: list[dict[str, Any]] = run["results"]
    return found


def test_a_log_of_sarif_says_the_same(mission: Path) -> None:
    run = mcpn("check", mission, "--format", "sarif")
    assert run.returncode == 1
    places = [result["locations"][0]["physicalLocation"] for result in results(run.stdout)]
    assert {place["artifactLocation"]["uri"] for place in places} == {"my%20patrol%2C%201.xml"}
    told = [
        (each["level"], f"mcpn {each['ruleId']}", place["region"]["startLine"], each["message"]["text"])
        for each, place in zip(results(run.stdout), places, strict=True)
    ]
    annotated = commands(mcpn("check", mission, "--format", "github").stdout)
    assert told == [(level, p["title"], int(p["line"]), message) for level, p, message in annotated]


def test_what_cannot_be_read_is_an_annotation_too(mission: Path) -> None:
    mission.write_text(MISSION.replace('consumes="wheels"', 'consumes="wheel"'))
    run = mcpn("check", mission, "--format", "github")
    assert (run.returncode, run.stderr) == (2, "")
    ((level, properties, message),) = commands(run.stdout)
    assert (level, properties["title"], properties["line"]) == ("error", "mcpn input", "5")
    assert "wheel, which is not declared (did you mean wheels?)" in message


def test_a_mission_without_a_fault_says_nothing(mission: Path) -> None:
    right = re.sub(r"  <requirement.*\n", "", MISSION).replace(' failure="go"', "")
    mission.write_text(right.replace('    <hardware name="lamp"/>\n', ""))
    run = mcpn("check", mission, "--format", "github")
    assert (run.returncode, run.stdout) == (0, "")
    assert results(mcpn("check", mission, "--format", "sarif").stdout) == []


@pytest.mark.parametrize("option", ["--json", "--structure"])
def test_it_stands_alone(mission: Path, option: str) -> None:
    assert mcpn("check", mission, "--format", "sarif", option).returncode == 2


TREE = """<?xml version="1.0"?>
<root BTCPP_format="4">
  <include path="parts/take.xml"/>
  <BehaviorTree ID="Main">
    <Sequence>
      <Go _odd="no"/>
      <SubTree ID="Take"/>
      <Inverter>
        <Lost/>
      </Inverter>
    </Sequence>
  </BehaviorTree>
</root>
"""
TAKE = """<root BTCPP_format="4">
  <BehaviorTree ID="Take">

    <Patient><Grasp/></Patient>
  </BehaviorTree>
</root>
"""


def test_a_tree_is_annotated_where_its_nodes_stand(mission: Path) -> None:
    Path("parts").mkdir()
    Path("parts", "take.xml").write_text(TAKE)
    Path("tree.xml").write_text(TREE)
    run = mcpn("check", "tree.xml", "--format", "github")
    assert run.returncode == 1
    found = commands(run.stdout)
    places = {(level, p["title"], p["file"], int(p["line"])): said for level, p, said in found}
    assert "Grasp succeeds" in places.pop(("error", "mcpn nominal_success", "tree.xml", 4))
    assert places.pop(("warning", "mcpn warning", "tree.xml", 6)) == "Go: attribute _odd means nothing"
    assert "Lost leads only to failure by its success" in places.pop(
        ("warning", "mcpn warning", "tree.xml", 9)
    )
    patient = places.pop(("notice", "mcpn tree", "parts/take.xml", 4))
    assert patient == "Patient is more runs: what Patient does with its child is not known"
    assert "7 nodes: exact 6, more runs 1" in places.pop(("notice", "mcpn tree", "tree.xml", 4))
    assert places == {}
    log = results(mcpn("check", "tree.xml", "--format", "sarif").stdout)
    levels = [(each["level"], each["ruleId"]) for each in log]
    assert sorted(levels) == sorted(
        (level.replace("notice", "note"), p["title"].removeprefix("mcpn ")) for level, p, _ in found
    )


def test_an_exact_tree_has_no_notes_and_a_wrong_one_is_an_annotation(mission: Path) -> None:
    path = Path("tree.xml")
    path.write_text(TREE)
    run = mcpn("check", path, "--format", "github")
    assert run.returncode == 2
    ((level, properties, message),) = commands(run.stdout)
    assert (level, properties["title"], properties["line"]) == ("error", "mcpn input", "3")
    assert "parts/take.xml" in message
    path.write_text('<root><BehaviorTree ID="A"><Sequence><a/><b/></Sequence></BehaviorTree></root>')
    run = mcpn("check", path, "--format", "github")
    assert (run.returncode, run.stdout) == (0, "")
