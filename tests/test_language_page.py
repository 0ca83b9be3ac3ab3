"""The reference of the mission language, the files to start from, and the missions of different robots."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from lxml import etree

from mcpn.answers.verdicts.mission import check
from mcpn.cli.init import EXAMPLES
from mcpn.drawing.compose import compose
from mcpn.mission.language.forms import language
from mcpn.mission.language.relax_ng import relax_ng
from mcpn.mission.misfits import SCHEMA, find_misfits
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.xml import read_mission
from tests.conftest import ROOT

PAGES = [ROOT / "docs" / name for name in ("language.md", "patterns.md", "from-a-tree.md")]
TEXT = "".join(page.read_text() for page in PAGES)


def test_the_schema_is_that_of_the_model() -> None:
    assert SCHEMA.read_text() == relax_ng(), "run python docs/tables.py"


def test_the_tables_are_those_of_the_model() -> None:
    spec = importlib.util.spec_from_file_location("tables", ROOT / "docs" / "tables.py")
    assert spec is not None
    assert spec.loader is not None
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    for page in (ROOT / "docs" / name for name in ("formats.md", "templates.md", "claims.md")):
        assert tables.renewed(page.read_text()) == page.read_text(), "run python docs/tables.py"
    assert tables.renewed(TEXT) == TEXT, "run python docs/tables.py"
    described = set(re.findall(r"<!-- table (\w+) -->", TEXT))
    assert set(every()) <= described
    # Every attribute says what it means.
    rows = [line.split("|") for line in TEXT.splitlines() if line.startswith("| `")]
    meanings = [cells[3].strip() for cells in rows if len(cells) == 5]
    assert len(meanings) > 100
    assert all(meanings)


@pytest.mark.parametrize("text", re.findall(r"```xml\n(.*?)```", TEXT, re.DOTALL))
def test_the_missions_of_the_page_hold(text: str, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(text)
    mission = read_mission(tmp_path / "m.xml")
    found = check(compose(mission), engine="local")
    assert found.passed
    assert find_warnings(found.mission_net.mission) == []


TABLED = """
<mission name="tabled" xmlns="urn:mcpn:mission:1">
  <robot name="pair">
    <hardware name="sensor" repairable="false"/>
    <hardware name="lift"/>
    <hardware name="wheels"/>
    <hardware name="tracks"/>
    <software name="watched"/>
    <event name="stop"/>
    <activity name="watch" produces="watched" consumes="sensor"/>
    <activity name="drive" consumes="wheels watched"/>
    <activity name="ride" consumes="wheels lift watched"/>
    <activity name="lift_tracks" consumes="tracks lift watched"/>
    <activity name="confirm" consumes="watched"/>
    <activity name="hold"/>
    <activity name="pay"/>
  </robot>
  <requirement name="guarded" formula="G (oos(sensor) &amp; block(work) -> G !objective(order))"/>
  <requirement name="alone" formula="G !(activity(ride) &amp; activity(lift_tracks))"/>
  <requirement name="stops" formula="G (happens(stop) -> X (abort &amp; !activity(drive)))"/>
  <requirement name="waits" formula="G (happens(OBJ_cool_EV_TIMEOUT) -> X objective(order))"/>
  <requirement name="paid" formula="G (happens(OBJ_order_EV_OK) -> X objective(pay))"/>
  <requirement name="the_same">
    <reaction to="happens(OBJ_order_EV_OK)" gives="objective(pay)" when="prompt"/>
  </requirement>
  <requirement name="rounds" formula="G (happens(OBJ_knock_4_EV_OK) -> X objective(knock_5))"/>
  <requirement name="tries" formula="G (happens(OBJ_knock_1_try3_EV_FAIL) -> X abort)"/>
  <requirement name="again" formula="G (happens(OBJ_knock_1_try2_EV_FAIL) -> X objective(knock_1_try3))"/>
  <on event="stop" goto="abort"/>
  <objective name="knock" activities="pay" repeat="5" retries="2" failure="abort"/>
  <objective name="work" failure="abort">
    <parallel name="both">
      <objective name="upstairs">
        <objective name="come" activities="drive"/>
        <objective name="go_up" activities="ride"/>
      </objective>
      <objective name="other" activities="lift_tracks"/>
    </parallel>
    <objective name="clear" activities="confirm"/>
  </objective>
  <objective name="cool" activities="hold" timeout="PT10M" timeout_goto="order" failure="cool"/>
  <objective name="order" activities="pay" failure="abort"/>
  <objective name="pay" activities="pay" failure="abort"/>
</mission>
"""
"""A guard over branches, a lift for one at a time, an emergency stop, a wait: recipes without an example."""


def test_recipes_of_the_table_do_what_they_are_for(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(TABLED.lstrip())
    found = check(compose(read_mission(tmp_path / "m.xml")), engine="local")
    assert found.passed
    assert {answer.asked.name for answer in found.requirements if answer.met} == {
        "guarded",
        "alone",
        "stops",
        "waits",
        "paid",
        "the_same",
        "rounds",
        "tries",
        "again",
    }


def run(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "mcpn.cli", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_init_writes_a_mission_that_holds(tmp_path: Path) -> None:
    assert run("init", "first_one", folder=tmp_path).returncode == 0
    folder = tmp_path / "first_one"
    names = ["drivers.toml", "mission.xml", "played.py", "protocols.xml", "robot.xml"]
    assert sorted(p.name for p in folder.iterdir()) == names
    found = check(compose(read_mission(folder / "mission.xml")), engine="local")
    assert found.passed
    assert found.mission_net.mission.name == "first_one"
    assert find_warnings(found.mission_net.mission) == []
    before = (folder / "mission.xml").read_bytes()
    again = run("init", "first_one", folder=tmp_path)
    assert (again.returncode, again.stdout) == (2, "")
    assert "not overwritten" in again.stderr
    assert (folder / "mission.xml").read_bytes() == before
    wrong = run("init", "1st", folder=tmp_path)
    assert wrong.returncode == 2
    assert not (tmp_path / "1st").exists()


def test_init_writes_a_mission_that_runs(tmp_path: Path) -> None:
    """Out of the box, with a robot that is played: every place is visited, and nothing refused."""
    assert run("init", "first_one", folder=tmp_path).returncode == 0
    written = ("first_one/mission.xml", "--drivers", "first_one/drivers.toml")
    ran = run("run", *written, "--journal", "log.jsonl", folder=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    said = [line.strip() for line in ran.stdout.splitlines()]
    # On a busy machine it is said, too, that a start waits.
    places = [line.removeprefix("drive: to ") for line in said if line.startswith("drive: to ")]
    assert places == ["a", "b", "c", "base"]
    assert [line.split() for line in said if line.startswith(("outcome", "refused"))] == [
        ["outcome", "success"],
        ["refused", "0"],
    ]
    replayed = run("simulate", written[0], "--events", "log.jsonl", "--json", folder=tmp_path)
    assert json.loads(replayed.stdout)["outcome"] == "success"


def test_the_printed_schema_judges_as_the_reader_does(tmp_path: Path) -> None:
    printed = run("schema", folder=tmp_path)
    schema = etree.RelaxNG(etree.fromstring(printed.stdout.encode()))
    for path in sorted((ROOT / "experiments" / "ulysse").glob("*.xml")):
        root = etree.parse(path).getroot()
        assert schema.validate(root)
        assert find_misfits(root) == []
        root.set("colour", "blue")
        assert not schema.validate(root)
        assert find_misfits(root)


@pytest.mark.parametrize("robot", EXAMPLES)
def test_missions_of_different_robots_hold(robot: str) -> None:
    found = check(compose(read_mission(ROOT / "experiments" / robot / "mission.xml")), engine="local")
    assert found.passed
    assert find_warnings(found.mission_net.mission) == []


def every() -> dict[str, set[str]]:
    """Every element of the language with its attributes."""
    return {name: set(tag.attributes) for name, tag in language().items()}


def test_each_element_is_in_some_mission() -> None:
    used: set[tuple[str, str]] = set()
    for robot in EXAMPLES:
        for path in (ROOT / "experiments" / robot).glob("*.xml"):
            for element in etree.parse(path).iter(etree.Element):
                tag = etree.QName(element).localname
                used |= {(tag, ""), *((tag, str(name)) for name in element.attrib)}
    for text in re.findall(r"```xml\n(.*?)```", TEXT, re.DOTALL):
        for element in etree.fromstring(text).iter(etree.Element):
            tag = etree.QName(element).localname
            used |= {(tag, ""), *((tag, str(name)) for name in element.attrib)}
    blocks = ("objective", "parallel", "use", "each")
    common = {
        "description",
        "success",
        "failure",
        "abort",
        "mandatory",
        "retries",
        "repeat",
        "recover",
        "times",
        "nominal",
        "timeout",
        "timeout_goto",
    }
    scoped = {name for name, tag in language().items() if {"after", "before"} <= tag.attributes.keys()}
    for tag, names in every().items():
        assert (tag, "") in used, tag
        for name in names:
            of_any = name in common and any((block, name) in used for block in blocks)
            of_any |= name in ("after", "before", "until") and any((other, name) in used for other in scoped)
            assert (tag, name) in used or of_any, f"{name} of {tag}"


def test_init_writes_every_example(tmp_path: Path) -> None:
    folders = sorted(path.parent for path in (ROOT / "experiments").glob("*/mission.xml"))
    assert list(EXAMPLES) == [folder.name for folder in folders]
    for folder in folders:
        made = run("init", folder.name, "--example", folder.name, folder=tmp_path)
        assert made.returncode == 0, made.stderr
        written = {path.name: path.read_text() for path in (tmp_path / folder.name).iterdir()}
        assert written == {path.name: path.read_text() for path in folder.glob("*.xml")}
    assert "'ulysse'" in run("init", "other", "--example", "boat", folder=tmp_path).stderr
