"""Missions as people write them from the language page alone: what is made of them at the first try."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission

HERE = Path(__file__).parent


@cache
def checked(name: str) -> MissionCheck:
    return check(compose(read_mission(HERE / f"{name}.xml")))


@pytest.mark.parametrize("name", ["greenhouse", "portboat"])
def test_missions_of_many_elements_hold(name: str) -> None:
    assert checked(name).passed


@pytest.mark.parametrize("name", ["hospital", "sewer"])
def test_shared_data_retries_and_events_hold_at_the_first_try(name: str) -> None:
    found = checked(name)
    assert found.passed
    assert found.choice.engine == "local"


def test_an_alternative_that_its_own_consumer_blocks_says_why() -> None:
    told = [str(problem) for problem in checked("hospital").unselectable]
    (line,) = [line for line in told if "amcl.by_odometry" in line]
    assert line.endswith("can never be selected: drive, which it serves, has wheels already")


def test_a_clash_of_hardware_is_told_before_anything_is_explored() -> None:
    """Five branches on ten hardware resources, of which two want the gimbal, two the radio."""
    found = checked("inspection")
    verdict = found.verdicts["confluent"]
    assert verdict.holds is False
    assert verdict.explanation.startswith(  # both clash at the same moment
        (
            "not confluent: film (objective filming) and thermal (objective heat), both in parallel block "
            "survey, ask for gimbal at the same moment",
            "not confluent: report (objective telling) and stream (objective streaming), both in parallel "
            "block survey, ask for radio at the same moment",
        )
    )
    assert [str(e) for e in verdict.runs[0].events] == ["MISSION_EV_START", "OBJ_go_EV_OK"]
    wanted = {c.wanted for c in found.mission_net.usage.contentions}
    assert {"gimbal", "radio", "front_camera"} <= wanted


def test_a_mission_that_cannot_succeed_by_its_routes_says_so(tmp_path: Path) -> None:
    text = """<mission name="m" xmlns="urn:mcpn:mission:1">
      <robot name="r"><activity name="work"/><activity name="drift"/></robot>
      <objective name="do" activities="work"/>
      <objective name="give_up" activities="drift" success="fail"/>
    </mission>"""
    file = tmp_path / "m.xml"
    for route, holds in (("", False), (' success="succeed"', True)):
        file.write_text(text.replace('activities="work"', f'activities="work"{route}'))
        verdict = check(compose(read_mission(file))).verdicts["success_reachable"]
        assert verdict.holds is holds
        assert ("no route of the mission leads to succeed" in verdict.explanation) is not holds
