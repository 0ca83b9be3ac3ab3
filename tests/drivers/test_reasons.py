"""Drivers that tell why an objective has failed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.commands import mcpn

MISSION = """<mission name="fetch" xmlns="urn:mcpn:mission:1">
  <robot name="carrier">
    <activity name="drive" failures="no_path"/>
    <activity name="ring"/>
  </robot>
  <objective name="there" activities="drive" failures="blocked">
    <route on="failure" reason="blocked" goto="ask"/>
    <route on="failure" reason="no_path" goto="back"/>
  </objective>
  <objective name="back" activities="drive" success="succeed"/>
  <objective name="ask" activities="ring" success="succeed"/>
</mission>
"""
DRIVERS = """[activities.drive]
process = ["sh", "-c", "exit $(cat {objective})"]
ends = {0 = "success", 3 = "failure blocked", 4 = "failure no_path", other = "failure"}
[activities.ring]
process = ["true"]
ends = {0 = "success", other = "failure"}
"""


def run(folder: Path, drivers: str = DRIVERS, *options: str) -> tuple[int, str, str]:
    (folder / "mission.xml").write_text(MISSION)
    (folder / "drivers.toml").write_text(drivers)
    found = mcpn("run", folder / "mission.xml", "--drivers", folder / "drivers.toml", *options)
    return found.returncode, found.stdout, found.stderr


@pytest.mark.parametrize(
    ("there", "back", "events", "outcome"),
    [
        (3, 0, ["OBJ_there_EV_FAIL_blocked", "OBJ_ask_EV_OK"], "success"),
        (4, 0, ["OBJ_there_EV_FAIL_no_path", "OBJ_back_EV_OK"], "success"),
        # For the way back nobody has named what blocks it: it fails.
        (4, 3, ["OBJ_there_EV_FAIL_no_path", "OBJ_back_EV_FAIL"], "failure"),
        (1, 0, ["OBJ_there_EV_FAIL"], "failure"),
    ],
)
def test_the_route_of_the_reason_is_followed(
    there: int, back: int, events: list[str], outcome: str, tmp_path: Path
) -> None:
    (tmp_path / "there").write_text(str(there))
    (tmp_path / "back").write_text(str(back))
    _, told, error = run(tmp_path)
    assert error == ""
    assert re.findall(r"OBJ_\w+", told) == events
    assert f"outcome      {outcome}" in told


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("failure blocked", "failure blokced", [
            "failure blokced: no objective that runs drive fails for this reason "
            "(did you mean failure blocked?)",
            "OBJ_there_EV_FAIL_blocked",
        ]),
        (', 4 = "failure no_path"', "", ["EV_FAIL_no_path: name it in one, or in never"] * 2),
        ('["true"]\nends = {0 = "success"', '["true"]\nends = {0 = "success", 3 = "failure no_path"', [
            "failure no_path: no objective that runs ring fails for this reason",
        ]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    code, _, error = run(tmp_path, DRIVERS.replace(old, new), "--check")
    assert code == 2
    assert len(error.splitlines()) == len(expected)
    assert all(any(text in line for line in error.splitlines()) for text in expected)


def test_a_skeleton_has_a_number_for_each_reason(tmp_path: Path) -> None:
    (tmp_path / "mission.xml").write_text(MISSION)
    mcpn("run", tmp_path / "mission.xml", "--drivers", tmp_path / "drivers.toml", "--init")
    written = (tmp_path / "drivers.toml").read_text()
    assert (
        'ends = { 0 = "success", 3 = "failure blocked", 4 = "failure no_path", other = "failure" }' in written
    )
    assert 'ends = { 0 = "success", other = "failure" }' in written
