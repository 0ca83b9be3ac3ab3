"""The main job in a few seconds, in this process: what to run first after any change."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from mcpn.cli.line import command_line
from tests.conftest import ULYSSE


@pytest.mark.parametrize("engine", ["explicit", "symbolic", "local"])
def test_ulysse_is_verified_by_every_engine(engine: str) -> None:
    run = CliRunner().invoke(command_line, ["check", str(ULYSSE), "--engine", engine, "--json"])
    assert run.exit_code == 0
    found = json.loads(run.stdout)
    assert found["alternatives"] == {"states": 260, "edges": 1332}


def test_ulysse_has_causes_and_a_controller(tmp_path: Path) -> None:
    run = CliRunner().invoke(command_line, ["causes", str(ULYSSE), "--json"])
    assert json.loads(run.stdout)["mission"]["cut_sets"] == [
        ["thruster_actuator"],
        ["GPS_sensor", "IMU_sensor"],
    ]
    run = CliRunner().invoke(command_line, ["controller", str(ULYSSE), "-o", str(tmp_path)])
    assert run.exit_code == 0
    assert len(json.loads((tmp_path / "controller.json").read_text())["states"]) == 260
