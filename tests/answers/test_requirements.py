"""Requirements of missions: read, qualified by uses, answered on every engine, told."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.requirements import asked_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.logic.syntax import parse
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import SPACE_ENGINES, Asked
from mcpn.spaces.search.goal import Fires, marked
from tests.commands import mcpn, output

TEXT = """<mission xmlns="urn:mcpn:mission:1" name="survey">
  <robot name="boat">
    <hardware name="camera"/>
    <hardware name="motor" faulty="false"/>
    <activity name="film"><alternative name="film" consumes="camera"/></activity>
    <activity name="move"><alternative name="move" consumes="motor"/></activity>
  </robot>
  <protocols>
    <protocol name="look">
      {inside}
      <objective name="come" activities="move"/>
      <objective name="see" activities="film"/>
    </protocol>
  </protocols>
  {around}
  <use protocol="look" name="north"/>
  <use protocol="look" name="south"/>
</mission>
"""

WAITS = '<requirement name="come_first" formula="!objective(see) W happens(OBJ_come_EV_OK)"/>'

CONTENDED = """<mission xmlns="urn:mcpn:mission:1" name="c">
  <robot name="r">
    <hardware name="arm"/>
    <activity name="lift" consumes="arm"/>
    <activity name="wave" consumes="arm"/>
  </robot>
  <requirement name="never" formula="G !failure"/>
  <parallel name="both">
    <objective name="x" activities="lift"/>
    <objective name="y" activities="wave"/>
  </parallel>
</mission>
"""


def mission_file(folder: Path, around: str = "", inside: str = "") -> Path:
    path = folder / "survey.xml"
    path.write_text(TEXT.format(around=around, inside=inside))
    return path


def test_what_is_not_decided_is_not_called_violated(tmp_path: Path) -> None:
    """Two branches start one activity that takes what is there for one alone: composition gives no answer."""
    path = tmp_path / "mission.xml"
    path.write_text(CONTENDED)
    found = check(compose(read_mission(path)), engine="local")
    assert not found.passed
    assert (found.violated, found.unanswered) == ([], ["never"])
    said = mcpn("check", path, "--engine", "local").stdout
    assert "requirements violated" not in said
    assert re.search("^not decided: .*, never$", said, re.MULTILINE)


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_each_use_of_a_protocol_is_asked(tmp_path: Path, engine: Asked) -> None:
    others = (
        '<requirement name="ends" formula="F (success | failure)"/>'
        '<requirement name="ends_fairly" formula="F (success | failure)" fair="true"/>'
        '<requirement name="may_fail" formula="AG !failure" expected="fails"/>'
        '<requirement name="sees" formula="G (objective(south.see) -> !oos(camera))" severity="advice"/>'
    )
    found = check(compose(read_mission(mission_file(tmp_path, others, WAITS))), engine=engine)
    assert {a.asked.name: (a.holds, a.met, a.required) for a in found.requirements} == {
        "ends": (False, False, True),  # the camera may fail and return for ever
        "ends_fairly": (True, True, True),
        "may_fail": (False, True, True),
        "sees": (False, False, False),
        "north.come_first": (True, True, True),
        "south.come_first": (True, True, True),
    }
    assert found.violated == ["ends"]
    assert not found.passed
    runs = {a.asked.name: a.witness for a in found.requirements if a.holds is False}
    for name, witness in runs.items():
        assert witness is not None
        assert witness.steps, name
    assert runs["ends"] is not None
    assert runs["ends"].cycle is not None


def test_what_is_advice_does_not_fail_the_check(tmp_path: Path) -> None:
    path = mission_file(tmp_path, '<requirement name="sure" formula="G !failure" severity="advice"/>')
    found = mcpn("check", path)
    assert found.returncode == 0
    assert "G !failure (sure)" in found.stdout
    assert "0 of 1 requirements are met" in found.stdout


def test_what_is_violated_is_told_with_its_run(tmp_path: Path) -> None:
    path = mission_file(
        tmp_path, '<requirement name="sure" description="It never fails." formula="G !failure"/>'
    )
    found = mcpn("check", path)
    assert found.returncode == 1
    assert "FAIL It never fails. (sure)" in found.stdout
    assert "the mission ends in failure" in found.stdout
    assert "requirements violated: sure" in found.stdout
    (told,) = output("check", path, code=1)["requirements"]
    assert (told["name"], told["formula"]) == ("sure", "G !failure")
    assert (told["holds"], told["met"], told["expected"], told["severity"]) == (
        False,
        False,
        "holds",
        "required",
    )
    assert told["witness"]["events"][0] == "MISSION_EV_START"


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("formula", "last"),
    [
        ("!success W happens(OBJ_send_EV_OK)", "dawn"),  # not what else fails after the end
        ("G !happens(dawn)", "dawn"),
        ("G (happens(dawn) -> X !success)", "dawn"),
        ("G !success", "dawn"),
    ],
)
def test_a_run_ends_with_what_violates(engine: Asked, formula: str, last: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1">
        <robot name="r"><hardware name="wheels"/><event name="dawn"/>
        <activity name="roll" consumes="wheels"/></robot>
        <requirement name="asked" formula="{formula.replace(">", "&gt;")}"/>
        <on event="dawn" goto="succeed"/>
        <objective name="go" activities="roll"/><objective name="send" activities="roll"/>
        </mission>"""
    )
    (answer,) = check(compose(read_mission(path)), engine=engine).requirements
    assert answer.holds is False
    assert answer.witness is not None
    events = [str(event) for event in answer.witness.run.events]
    assert events == ["MISSION_EV_START", last]


def test_the_report_says_what_is_violated(tmp_path: Path) -> None:
    path = mission_file(
        tmp_path,
        '<requirement name="sure" description="It never &lt;fails&gt;." formula="G !failure"/>'
        '<requirement name="can" formula="EF success"/>',
    )
    assert mcpn("report", path, "-o", tmp_path / "page.html").returncode == 1
    told = (tmp_path / "page.html").read_text()
    assert "It does not meet what it requires: sure." in told
    assert "It never &lt;fails&gt;." in told
    assert "EF success" in told


def test_a_mission_that_is_not_confluent_leaves_them_open(tmp_path: Path) -> None:
    path = tmp_path / "clash.xml"
    path.write_text(
        """<mission xmlns="urn:mcpn:mission:1" name="clash">
  <robot name="boat">
    <hardware name="camera"/>
    <activity name="film"><alternative name="film" consumes="camera"/></activity>
    <activity name="scan"><alternative name="scan" consumes="camera"/></activity>
  </robot>
  <requirement name="ends" formula="EF success"/>
  <objective name="both" activities="film scan"/>
</mission>"""
    )
    found = check(compose(read_mission(path)))
    (answer,) = found.requirements
    assert (answer.holds, answer.met) == (None, None)
    assert "several outcomes" in answer.reason
    told = mcpn("check", path)
    assert told.returncode == 1
    assert "?    EF success (ends)" in told.stdout


@pytest.mark.parametrize(
    ("around", "inside", "line", "words"),
    [
        ('<requirement name="x" formula="G objektive(a)"/>', "", 15, "requirement x: formula"),
        ('<requirement name="x" formula="F objective(nort.see)"/>', "", 15, "did you mean north.see"),
        ("", '<requirement name="x" formula="F objective(seen)"/>', 10, "requirement north.x: formula"),
        ('<requirement name="x" formula=""/>', "", 15, "expected a formula"),
        ('<requirement name="x" formula="true" severity="some"/>', "", 15, "required or advice"),
        ('<requirement name="x" formula="true" expected="no"/>', "", 15, "holds or fails"),
        ('<requirement name="x"/>', "", 15, "formula"),
        ('<requirement name="x" formula="true"/>' * 2, "", 15, "x"),
    ],
)
def test_a_wrong_requirement_is_an_error_at_its_line(
    tmp_path: Path, around: str, inside: str, line: int, words: str
) -> None:
    path = mission_file(tmp_path, around, inside)
    found = mcpn("check", path)
    assert found.returncode == 2
    assert f"survey.xml:{line}:" in found.stderr
    assert words in found.stderr


def test_they_are_written_as_they_are_read(tmp_path: Path) -> None:
    around = '<requirement name="x" formula="EF success" expected="fails" severity="advice" fair="true"/>'
    mission = read_mission(mission_file(tmp_path, around, WAITS))
    copy = tmp_path / "copy.xml"
    copy.write_bytes(write_mission(mission))
    assert read_mission(copy) == mission


def test_names_are_those_of_the_use(tmp_path: Path) -> None:
    mission_net = compose(read_mission(mission_file(tmp_path, "", WAITS)))
    north, south = asked_of(mission_net)
    assert north.formula != south.formula
    names = MissionNames(mission_net)  # outside it means both
    sees = [("objective", "north.see"), ("objective", "south.see")]
    both = [place for place, said in mission_net.roles.items() if said in sees]
    assert parse("objective(see)", names) == marked(*both)


def test_a_name_means_all_rounds_and_tries(tmp_path: Path) -> None:
    path = tmp_path / "rounds.xml"
    path.write_text(
        """<mission xmlns="urn:mcpn:mission:1" name="rounds">
  <robot name="boat"><activity name="move"/></robot>
  <objective name="leave" activities="move" retries="1"/>
  <each name="site" in="a b"><objective name="come" activities="move" repeat="2"/></each>
  <objective name="site_b" activities="move"/>
</mission>"""
    )
    mission_net = compose(read_mission(path))
    names = MissionNames(mission_net)

    sections = [section.name for section in mission_net.graph.walk()]
    assert sections == ["leave_try1", "leave_try2", *(f"come_{v}_{n}" for v in "ab" for n in "12"), "site_b"]
    for short, copies in (
        ("leave", ["leave_try1", "leave_try2"]),
        ("come", ["come_a_1", "come_a_2", "come_b_1", "come_b_2"]),
        ("come_a_2", ["come_a_2"]),
        ("leave_try2", ["leave_try2"]),
        ("site_b", ["site_b"]),
    ):
        places = {p for p, of in mission_net.saying("objective").items() if of in copies}
        assert parse(f"objective({short})", names) == marked(*places), short
        happening = parse(f"event(OBJ_{short}_EV_OK)", names)
        assert isinstance(happening, Fires)
        events = {str(mission_net.net.transitions[t].event) for t in happening.transitions}
        assert events == {f"OBJ_{name}_EV_OK" for name in copies}
    with pytest.raises(InputError, match="no objective is named leave_try3"):
        parse("objective(leave_try3)", names)


@pytest.mark.parametrize(
    ("asked", "fairly"),
    [
        ('<existence of="success | failure"/>', True),  # it ends, unless hardware fails and returns for ever
        ('<existence of="success"/>', False),  # it may fail
        ('<absence of="activity(drive)"/>', False),  # no run for ever violates it
    ],
)
def test_runs_that_no_robot_makes_are_told(asked: str, fairly: bool, tmp_path: Path) -> None:
    text = """<mission name="m" xmlns="urn:mcpn:mission:1">
      <robot name="r"><hardware name="wheels"/><activity name="drive" consumes="wheels"/></robot>
      <requirement name="plain">{0}</requirement><requirement name="fair" fair="true">{0}</requirement>
      <objective name="a" activities="drive"/></mission>"""
    (tmp_path / "m.xml").write_text(text.format(asked))
    plain, fair = check(compose(read_mission(tmp_path / "m.xml"))).requirements
    assert plain.holds is False
    assert bool(plain.advice) is plain.fairly is fairly
    assert (bool(fair.holds), fair.advice) == (fairly, "")


DIGS = """<mission name="digs" xmlns="urn:mcpn:mission:1">
  <robot name="r"><activity name="dig"/><activity name="move"/></robot>
  <requirement name="few"><bounded_existence of="objective(dig)" most="{most}"/></requirement>
  <objective name="dig" activities="dig" success="succeed" failure="move"/>
  <objective name="move" activities="move" success="dig" failure="fail"/>
</mission>"""


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("most", "said"),
    [
        (1, "dig runs for the first time after event 1 and the second after event 3"),
        (3, "the second after event 3, the third after event 5 and the 4th after event 7"),
    ],
)
def test_what_comes_about_too_often_is_told_time_by_time(
    most: int, said: str, engine: Asked, tmp_path: Path
) -> None:
    """The moments are those of the run that is shown; no nest of untils stands beside it."""
    path = tmp_path / "digs.xml"
    path.write_text(DIGS.format(most=most))
    (answer,) = check(compose(read_mission(path)), engine=engine).requirements
    assert answer.holds is False
    assert answer.witness is not None
    assert [note for note in answer.witness.notes if said in note]
    assert not any(" U " in note for note in answer.witness.notes)
