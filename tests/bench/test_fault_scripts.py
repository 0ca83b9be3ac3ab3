"""The bench as a command: traces are replayed, and scripts of faults are played."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.commands import mcpn
from tests.conftest import ULYSSE


def test_the_command_s_traces_are_replayed(written: str, tmp_path: Path) -> None:
    said: dict[str, Any] = json.loads(
        mcpn("bench", written, "--runs", "200", "--traces", str(tmp_path / "t"), "--json").stdout
    )
    assert sum(of["count"] for of in said["outcomes"].values()) == 200
    assert all(of["agrees"] for of in said["outcomes"].values())
    assert len(said["traces"]) == 10
    replayed = mcpn("simulate", written, "--events", said["traces"][0], "--json")
    assert json.loads(replayed.stdout)["outcome"] == "failure"


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("1 OBJ_other_EV_OK\n", "which is no event of the mission"),
        ("0.5 GPS_EV_OOS x", "found '0.5 GPS_EV_OOS x', expected hours and an event"),
        ("# nothing\n-1 GPS_EV_OOS", ":2: found '-1 GPS_EV_OOS'"),
        ("soon GPS_EV_OOS", "found 'soon GPS_EV_OOS'"),
        ("1 dance", ":1: found 'dance', which is no event of the mission"),
    ],
)
def test_scripts_that_are_none(script: str, message: str, written: str, tmp_path: Path) -> None:
    path = tmp_path / "faults.txt"
    path.write_text(script)
    found = mcpn("bench", written, "--faults", str(path))
    assert found.returncode == 2
    assert message in found.stderr


def test_a_script_of_faults_is_played(written: str, tmp_path: Path) -> None:
    path = tmp_path / "faults.txt"
    path.write_text("0 MISSION_EV_START\n0 H_EV_OOS  # at once\n")
    said = json.loads(mcpn("bench", written, "--runs", "50", "--faults", str(path), "--json").stdout)
    assert said["no_risk"] == "a script of faults is played"
    assert said["outcomes"]["failure"]["count"] == 50


def test_a_mission_without_durations_runs_untimed() -> None:
    """Nothing fails in Ulysse but by chance of its objectives, of which it gives none: all succeed."""
    said = json.loads(mcpn("bench", str(ULYSSE), "--runs", "50", "--json").stdout)
    assert said["outcomes"]["success"]["count"] == 50
    assert (said["hours"], said["no_risk"][:27]) == (None, "objectives have no duration")
    assert said["outcomes"]["success"]["risk"] is None
    assert "mean hours" not in mcpn("bench", str(ULYSSE), "--runs", "5").stdout
