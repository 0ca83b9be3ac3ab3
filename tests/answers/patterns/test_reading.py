"""Patterns in missions: their sentences and formulas, what is wrong with them, and that they are answered."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.answers.requirements import asked_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.model import Mission
from mcpn.mission.requirement import Requirement, RestrictedAvoidance
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import Asked
from tests.commands import mcpn, output

TEXT = """<mission xmlns="urn:mcpn:mission:1" name="survey">
  <robot name="boat">
    <hardware name="camera"/>
    <activity name="film"><alternative name="near" consumes="camera"/><alternative name="far"/></activity>
    <activity name="move"/>
  </robot>
{requirements}
  <objective name="come" activities="move"/>
  <objective name="see" activities="film"/>
  <objective name="leave" activities="move"/>
</mission>
"""
SENTENCES = {
    '<absence of="oos(camera)"/>': "It is never the case that camera is out of service.",
    '<absence of="refused(film)" before="success"/>': (
        "Up to the first moment at which the mission has succeeded, if there is one: "
        "it is never the case that “refused(film)”."
    ),
    '<existence of="alternative(film)=far" after="oos(camera)"/>': (
        "From the first moment on at which camera is out of service: at some moment film runs as far."
    ),
    '<universality of="!objective(see) | activity(film)" after="objective(see)" before="success"/>': (
        "Whenever see runs, up to the next moment at which the mission has succeeded, if there is one: "
        "it is always the case that see does not run or film runs."
    ),
    '<bounded_existence of="objective(see)" most="3" after="objective(come)" until="failure"/>': (
        "Whenever come runs, up to the next moment at which the mission has failed, or for ever: "
        "at most 3 times it becomes true that see runs."
    ),
    '<bounded_existence of="objective(see)"/>': "At most twice it becomes true that see runs.",
    '<precedence of="objective(see)" by="happens(OBJ_come_EV_OK)"/>': (
        "See runs only after the success of come happens."
    ),
    '<precedence of="objective(leave)" by="objective(come)" then="objective(see)"/>': (
        "Leave runs only when see runs, or after that, and before that come runs."
    ),
    '<precedence of="oos(camera)" followed_by="available(camera)" by="objective(come)"/>': (
        "Camera is out of service and later camera is available only when first come runs."
    ),
    '<response to="oos(camera)" gives="alternative(film)=far | failure"/>': (
        "Whenever camera is out of service, then or later film runs as far or the mission has failed."
    ),
    '<response to="objective(come)" followed_by="oos(camera)" gives="failure"/>': (
        "Whenever come runs and later camera is out of service, then or later the mission has failed."
    ),
    '<response to="objective(come)" gives="objective(see)" then="success"/>': (
        "Whenever come runs, then or later see runs, and after that the mission has succeeded."
    ),
    '<response to="objective(come)" gives="objective(see)" then="success" without="!available(camera)"/>': (
        "Whenever come runs, then or later see runs, and after that the mission has succeeded, "
        "and in between never camera is not available."
    ),
    '<visit in="come see"/>': "The robot visits come and see.",
    '<visit in="come see" order="sequenced"/>': (
        "The robot visits come and see, each after the one before it."
    ),
    '<visit in="come see leave" order="ordered"/>': (
        "The robot visits come, see and leave, none before the one before it."
    ),
    '<visit in="come see" order="strict"/>': (
        "The robot visits come and see, none before the one before it, "
        "and enters none twice before the next one."
    ),
    '<visit in="come see" order="fair"/>': (
        "The robot visits come and see, "
        "and does not enter one again before it has visited the next one in turn."
    ),
    '<patrolling in="come see" order="sequenced"/>': (
        "Again and again the robot visits come and see, each after the one before it."
    ),
    '<avoidance of="see"/>': "The robot never visits see.",
    '<avoidance of="see leave" until="happens(OBJ_come_EV_OK)"/>': (
        "At some time the success of come happens, and the robot does not visit any of see and leave before."
    ),
    '<avoidance of="see" after="oos(camera)"/>': (
        "Once camera is out of service, the robot never visits see."
    ),
    '<restricted_avoidance of="see" at_most="1"/>': "The robot enters see at most once.",
    '<restricted_avoidance of="see" at_least="2"/>': "The robot enters see at least twice.",
    '<restricted_avoidance of="see leave" exactly="3"/>': (
        "The robot enters each of see and leave exactly 3 times."
    ),
    '<reaction to="oos(camera)" gives="!alternative(film)=near" when="instantaneous"/>': (
        "Whenever camera is out of service, at that moment film does not run as near."
    ),
    '<reaction to="happens(camera_EV_OOS)" gives="oos(camera)" when="prompt"/>': (
        "Whenever the loss of camera happens, after the next event camera is out of service."
    ),
    '<reaction to="oos(camera)" gives="failure" when="delayed"/>': (
        "Whenever camera is out of service, then or later the mission has failed."
    ),
    '<reaction to="activity(film)" gives="objective(see)" when="bound"/>': (
        "Whenever film runs, and only then, see runs."
    ),
    '<reaction to="happens(OBJ_come_EV_OK)" gives="event(OBJ_see_EV_OK)" when="bound_delay"/>': (
        "Whenever the success of come happens, and only then, "
        "after the next event the success of see may come next."
    ),
    '<wait in="come" until="objective(see) | failure"/>': (
        "The robot stays in come until see runs or the mission has failed."
    ),
}


def mission_file(folder: Path, *patterns: str) -> Path:
    path = folder / "survey.xml"
    inside = (f'  <requirement name="r{i}">\n{p}</requirement>' for i, p in enumerate(patterns))
    path.write_text(TEXT.format(requirements="\n".join(inside)))
    return path


def test_each_has_a_sentence_and_is_written_as_it_is_read(tmp_path: Path) -> None:
    mission = read_mission(mission_file(tmp_path, *SENTENCES))
    asked = asked_of(compose(mission))
    assert [each.sentence for each in asked] == list(SENTENCES.values())
    copy = tmp_path / "copy.xml"
    copy.write_bytes(write_mission(mission))
    assert read_mission(copy) == mission


def test_they_are_answered_alike_by_every_engine(tmp_path: Path) -> None:
    """And as the formulas that people may ask in their place."""
    path = mission_file(tmp_path, *SENTENCES)

    def holding(engine: Asked) -> dict[str, bool | None]:
        return {a.asked.text: a.holds for a in check(compose(read_mission(path)), engine=engine).requirements}

    found = holding("explicit")
    assert found == holding("symbolic") == holding("local")
    assert set(found.values()) == {True, False}
    asked = mcpn("ask", path, *found, "--json")
    assert asked.returncode == 1
    answers = output("ask", path, *found, code=1)
    assert {answer["formula"]: answer["holds"] for answer in answers} == found


def test_they_are_told_as_sentences(tmp_path: Path) -> None:
    path = mission_file(tmp_path, *list(SENTENCES)[:1])
    told = mcpn("check", path).stdout
    assert "FAIL It is never the case that camera is out of service. (r0)" in told
    assert "G !oos(camera) fails" in told
    (answer,) = output("check", path, code=1)["requirements"]
    assert answer["sentence"] == "It is never the case that camera is out of service."
    assert answer["formula"] == "G !oos(camera)"
    assert mcpn("report", path, "-o", tmp_path / "page.html").returncode == 1
    assert "It is never the case that camera is out of service." in (tmp_path / "page.html").read_text()


@pytest.mark.parametrize(
    ("pattern", "line", "words"),
    [
        (
            '<absence of="oos(camra)"/>',
            8,
            "of of <absence>: formula, column 5: no resource is named camra",
        ),
        ('<absence of="F"/>', 8, "no word is named F"),
        ('<absence of="oos(camera"/>', 8, "expected ')'"),
        ("<absence/>", 8, "<absence> has no attribute of, which is required"),
        ('<absense of="success"/>', 8, "did you mean absence?"),
        ('<absence off="success"/>', 8, "did you mean of?"),
        ('<absence of="success" until="failure"/>', 8, "until without after"),
        ('<absence of="success" after="true" before="true" until="failure"/>', 8, "both before and until"),
        ('<bounded_existence of="success" most="0"/>', 8, "expected a whole number from 1 to 9"),
        ('<response to="success" gives="failure" without="true"/>', 8, "without and no then"),
        ('<response to="true" followed_by="true" gives="true" then="true"/>', 8, "a chain on one side"),
        ('<precedence of="true" followed_by="true" by="true" then="true"/>', 8, "a chain on one side"),
        ('<visit in=""/>', 8, "no objective, expected one or more"),
        ('<visit in="come" order="fair"/>', 8, "expected two or more"),
        ('<visit in="come see come"/>', 8, "names come 2 times"),
        ('<visit in="come sea"/>', 8, "in of <visit>: no objective is named sea; did you mean see"),
        ('<visit in="come see" order="random"/>', 8, "any, sequenced, ordered, strict or fair"),
        ('<avoidance of="see" after="true" until="true"/>', 8, "both until and after"),
        ('<restricted_avoidance of="see"/>', 8, "0 of at_most, at_least and exactly"),
        ('<restricted_avoidance of="see" at_most="1" exactly="1"/>', 8, "2 of at_most, at_least and exactly"),
        ('<reaction to="true" gives="true" when="soon"/>', 8, "expected instantaneous, prompt, delayed"),
        ("", 7, "neither a formula nor a pattern"),
        ('<absence of="true"/><absence of="true"/>', 7, "2 patterns, expected a formula or one pattern"),
    ],
)
def test_what_is_wrong_is_an_error_at_its_line(tmp_path: Path, pattern: str, line: int, words: str) -> None:
    found = mcpn("check", mission_file(tmp_path, pattern))
    assert found.returncode == 2
    assert f"survey.xml:{line}: " in found.stderr
    assert words in found.stderr


def test_a_formula_and_a_pattern_are_too_much(tmp_path: Path) -> None:
    path = tmp_path / "survey.xml"
    both = '<requirement name="r" formula="true"><absence of="true"/></requirement>'
    path.write_text(TEXT.format(requirements=both))
    assert "both a formula and <absence>" in mcpn("check", path).stderr


def test_patterns_built_in_python_are_checked() -> None:
    wrong = RestrictedAvoidance(objectives=("see",), at_most=12)
    mission = Mission(name="m", blocks=(), requirements=(Requirement(name="r", patterns=(wrong,)),))
    with pytest.raises(InputError, match="at_most of <restricted_avoidance> of requirement r is 12"):
        compose(mission)
