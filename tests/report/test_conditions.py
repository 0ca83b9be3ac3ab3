"""Sentences of failure, of missions that can abort at both levels."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.claims import claims_of_causes
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.findings import findings
from mcpn.mission.xml import read_mission
from mcpn.report.failures.sentences import headlines, moments, survived
from mcpn.report.page import page
from mcpn.spaces.engine_names import Engine
from tests.logic.asked import ENGINES

SURVEY = """<mission name="survey" xmlns="urn:mcpn:mission:1">
  <robot name="boat">
    <hardware name="sonar" failure_rate="0.1"/><hardware name="rudder" failure_rate="0.1"/>
    <hardware name="motor" failure_rate="0.1"/>
    <activity name="look"/>
    <activity name="map" consumes="sonar motor"/>
    <activity name="steer"><alternative name="by_rudder" consumes="rudder motor"/>
      <alternative name="by_motor" consumes="motor"/></activity>
  </robot>
  <objective name="look" activities="look" duration="1" failure="home"/>
  <objective name="lines" activities="map" duration="1" success="succeed" failure="home" retries="1"/>
  <objective name="home" activities="steer" duration="1" success="abort"/>
</mission>
"""
"""The sonar is needed for success, the motor for a safe end too, the rudder for neither."""


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("survey") / "survey.xml"
    path.write_text(SURVEY)
    return path


@pytest.fixture(scope="module", params=ENGINES)
def causes(survey: Path, request: pytest.FixtureRequest) -> Causes:
    engine: Engine = request.param
    return find_causes(compose(read_mission(survey)), engine=engine)


def test_both_levels_stand_in_the_headlines(causes: Causes) -> None:
    assert list(headlines(causes, claims_of_causes(causes))) == [
        "The loss of sonar, or of motor before the start, not repaired, leaves no way to success.",
        "After the loss of rudder alone, whenever it comes, success stays possible.",
        "The loss of motor before the start, not repaired, leaves no way to a safe end.",
        "After the loss of any one of sonar and rudder alone, whenever it comes, a safe end stays possible.",
    ]
    moments = dict(survived(causes))
    assert moments["from the start"] == [
        "No loss of more than 1 resource by the start, not repaired, leaves a way to success; "
        "some loss of 1 resource does.",
        "No loss of more than 2 resources by the start, not repaired, leaves a way to a safe end; "
        "some loss of 2 resources does.",
    ]
    assert moments["from home on"] == [
        "From the entry of home on success is out of reach, whatever is repaired.",
        "The loss of motor, not repaired, leaves no way to a safe end from the entry of home on.",
        "No loss of more than 2 resources by the entry of home, not repaired, leaves a way to a safe end; "
        "some loss of 2 resources does.",
    ]
    start = causes.survival[0]
    assert start.safety is not None
    assert start.safety.run is not None
    assert str(start.safety.run.events[-1]) == "OBJ_home_EV_OK"


def test_what_each_failure_costs(causes: Causes) -> None:
    rows = {(row.hardware, row.objective): row for row in fmeca(causes.prospects)}
    severities: Mapping[tuple[str, str], Severity] = {pair: row.severity for pair, row in rows.items()}
    assert severities == {
        ("sonar", "look"): Severity.MISSION_LOST_UNLESS_REPAIRED,
        ("sonar", "lines_try1"): Severity.MISSION_LOST_UNLESS_REPAIRED,
        ("sonar", "lines_try2"): Severity.MISSION_LOST,
        ("sonar", "home"): Severity.NO_EFFECT,
        ("rudder", "look"): Severity.NO_EFFECT,
        ("rudder", "lines_try1"): Severity.NO_EFFECT,
        ("rudder", "lines_try2"): Severity.NO_EFFECT,
        ("rudder", "home"): Severity.DEGRADED,
        ("motor", "look"): Severity.ROBOT_LOST_UNLESS_REPAIRED,
        ("motor", "lines_try1"): Severity.ROBOT_LOST_UNLESS_REPAIRED,
        ("motor", "lines_try2"): Severity.ROBOT_LOST_UNLESS_REPAIRED,
        ("motor", "home"): Severity.ROBOT_LOST,
    }
    motor, sonar = rows["motor", "look"], rows["sonar", "lines_try2"]
    assert motor.mission_effect == "can end safely only if repaired"
    assert motor.recovery == "the mission can succeed again"
    assert sonar.mission_effect == "can end safely, but no longer succeed"
    assert sonar.compensation == "the objective's failure leads to home"
    assert (
        rows["motor", "lines_try2"].mission_effect == "can end safely only if repaired, and no longer succeed"
    )
    regained = "none before the objective has failed, then the mission can end safely"
    assert rows["motor", "lines_try2"].recovery == regained
    assert rows["motor", "home"].mission_effect == "can no longer end safely"


def test_the_page_does_not_count_an_abort_as_success(survey: Path) -> None:
    html = page(findings(compose(read_mission(survey))))
    for told in (
        "The loss of sonar, or of motor before the start, not repaired, leaves no way to success.",
        "The loss of motor before the start, not repaired, leaves no way to a safe end.",
        "After the loss of rudder alone, whenever it comes, success stays possible.",
        "probability of abort",
        "robot lost unless repaired",
    ):
        assert told in html


def test_the_run_to_success_says_what_it_skips(tmp_path: Path) -> None:
    """Nothing takes the picture: a mission that goes on without it says so."""
    path = tmp_path / "m.xml"
    path.write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
        <hardware name="h"/><activity name="a" consumes="h"/></robot>
        <objective name="go" activities="a"/>
        <objective name="picture" activities="a" retries="1" success="picture" failure="back"/>
        <objective name="back" activities="a"/></mission>"""
    )
    for engine in ENGINES:
        verdict = check(compose(read_mission(path)), engine=engine).verdicts["success_reachable"]
        assert (verdict.holds, verdict.skipped) == (True, ("picture",))
    path.write_text(path.read_text().replace('success="picture"', ""))
    for engine in ENGINES:
        assert check(compose(read_mission(path)), engine=engine).verdicts["success_reachable"].skipped == ()


class Name(str):
    """A name that counts how often one is compared with another."""

    compared = 0

    def __eq__(self, other: object) -> bool:
        Name.compared += 1
        return str(self) == other

    __hash__ = str.__hash__


def test_names_of_moments_are_not_compared_each_with_each() -> None:
    every = [Name(f"o{i}") for i in range(50)]
    during = [Name(name) for name in every[:49]]
    assert moments(during, every) == "at any moment, but not while o49 runs"
    assert Name.compared < 4 * len(every)
