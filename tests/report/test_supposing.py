"""What if: hardware lost from the start, alternatives in another order or taken away."""

from __future__ import annotations

import re
from itertools import chain, combinations
from typing import Any

import pytest
from hypothesis import given

from mcpn.editor.what_if import compared, supposed
from mcpn.errors import InputError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.study import open_study
from mcpn.testing import missions
from tests.conftest import ULYSSE
from tests.report.tabs import visited
from tests.report.test_served import JSON, asked, serving, ulysse_served

__all__ = ["ulysse_served"]  # a fixture


def said(lost: list[str], ways: dict[str, list[str]]) -> dict[str, Any]:
    return {row["asked"]: row["said"] for row in compared(open_study(ULYSSE), lost, ways)["rows"]}


def test_losses_are_verified_as_cut_sets_foretell() -> None:
    """Both ways to know it: a mission whose hardware is out of service is verified, and the cut sets."""
    study = open_study(ULYSSE)
    cut_sets = study.causes().mission.cut_sets
    names = [h.name for h in study.mission_net.core.hardware]
    subsets = chain.from_iterable(combinations(names, size) for size in range(len(names) + 1))
    states = set()
    for lost in subsets:
        state = said(list(lost), {})["Can it succeed?"][1][0]
        assert state == ("fails" if any(set(cut) <= set(lost) for cut in cut_sets) else "holds"), lost
        states.add(state)
    assert states == {"holds", "fails"}


def test_an_alternative_that_is_taken_away_is_one_that_is_not_written() -> None:
    text = (ULYSSE.parent / "robot.xml").read_text()
    line = next(line for line in text.splitlines() if 'alternative name="imu_localisation"' in line)
    robot = (ULYSSE.parent / "robot.xml").resolve()
    unsaid = (ULYSSE.parent / "protocols.xml").read_text()  # a requirement speaks of it
    (requirement,) = re.findall(
        r'<requirement name="\w+"[^>]*>\s*<[^>]*localisation\)=imu[^>]*>\s*</requirement>', unsaid
    )
    protocols = (ULYSSE.parent / "protocols.xml").resolve()
    typed = {robot: text.replace(line, ""), protocols: unsaid.replace(requirement, "")}
    written, mission = read_mission(ULYSSE, unsaved=typed), read_mission(ULYSSE)
    assert supposed(mission, [], {"localisation": ["gps_localisation"]}) == written
    told = said([], {"localisation": ["gps_localisation"]})
    lost, would_be = told["What defeats it?"]
    assert "GPS_sensor and IMU_sensor together" in lost[1]
    assert "GPS_sensor" in would_be[1]
    assert "together" not in would_be[1]
    turned = said([], {"localisation": ["imu_localisation", "gps_localisation"]})
    assert turned["What defeats it?"][0] == turned["What defeats it?"][1]
    assert any(question.startswith("Modes of") for question in told)
    assert not any(question.startswith("Modes of") for question in said([], {}))


def test_requirements_that_are_left_out_are_named() -> None:
    study = open_study(ULYSSE)
    required = [answer.asked.name for answer in study.verdicts().requirements]
    found = compared(study, [], {"localisation": ["gps_localisation"]})["left_out"]
    speaking = [answer.asked.name for answer in study.verdicts().requirements if "imu" in answer.asked.text]
    assert found == speaking
    assert set(found) < set(required)
    assert compared(study, ["GPS_sensor"], {})["left_out"] == []


@given(missions())
def test_a_mission_that_is_supposed_as_it_is_is_itself(mission: Mission) -> None:
    ways = {a.name: [w.name for w in a.alternatives] for robot in mission.robots for a in robot.activities}
    assert supposed(mission, [], ways) == mission


@pytest.mark.parametrize(
    ("lost", "ways", "wrong"),
    [
        (["GPS_sensr"], {}, "did you mean GPS_sensor"),
        ([], {"locolisation": ["a"]}, "did you mean localisation"),
        ([], {"localisation": ["gps"]}, "the mission has no alternative of localisation gps"),
        ([], {"localisation": []}, "needs an alternative"),
        ([], {"localisation": ["gps_localisation"] * 2}, "each once"),
    ],
)
def test_what_a_mission_has_not_is_told(lost: list[str], ways: dict[str, list[str]], wrong: str) -> None:
    with pytest.raises(InputError, match=wrong):
        supposed(read_mission(ULYSSE), lost, ways)


def test_a_page_shows_what_would_be(browser: Any, ulysse_served: Any) -> None:
    tab, wrong = visited(browser, ulysse_served.address)
    localisation = tab.locator('#suppose fieldset[data-activity="localisation"]')
    assert localisation.locator("bdi").all_inner_texts() == [
        "localisation",
        "gps_localisation",
        "imu_localisation",
    ]
    localisation.get_by_label("imu_localisation", exact=True).uncheck()
    tab.get_by_role("button", name="Verify it so").click()
    row = tab.locator("#supposed tr.other", has_text="What defeats it?")
    row.wait_for()
    tab.locator("#supposed p", has_text="goes_on_without_GPS.").wait_for()
    assert "GPS_sensor and IMU_sensor together" in row.locator("td").first.inner_text()
    assert "together" not in row.locator("td").last.inner_text()
    tab.get_by_role("button", name="As it is").click()
    localisation.get_by_role("button", name="prefer imu_localisation").press("Enter")
    assert localisation.locator("bdi").all_inner_texts()[1:] == ["imu_localisation", "gps_localisation"]
    tab.locator('#lost input[value="thruster_actuator"]').check()
    tab.get_by_role("button", name="Verify it so").click()
    lost = tab.locator("#supposed tr.other", has_text="May it go?")
    lost.wait_for()
    assert lost.locator("td").last.inner_text().startswith("No.")
    for activity in localisation.locator("input").all():
        activity.uncheck()
    tab.get_by_role("button", name="Verify it so").click()
    tab.locator("#supposed .missing", has_text="needs an alternative").wait_for()
    assert wrong == []


def test_what_is_no_supposition_is_refused(ulysse_served: Any) -> None:
    for body in (
        "{}",
        '{"lost": [1], "ways": {}}',
        '{"lost": [], "ways": {"a": "b"}}',
        '{"lost": "x", "ways": {}}',
    ):
        status, *_ = asked(ulysse_served, "POST", f"/{ulysse_served.token}/suppose", body, **JSON)
        assert status == 400, body


def test_a_mission_without_choices_has_no_such_form(tmp_path: Any) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="h"/>'
        '<activity name="a" consumes="h"/></robot><objective name="o" activities="a"/></mission>'
    )
    with serving(path) as server:
        assert 'id="suppose"' not in asked(server, "GET", f"/{server.token}/")[1]
