"""The main job in a few seconds: what to run first after any change."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcpn.spaces.engine_names import SPACE_ENGINES
from tests.commands import mcpn, output
from tests.conftest import ULYSSE


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_ulysse_is_verified_by_every_engine(engine: str) -> None:
    assert output("check", ULYSSE, "--engine", engine)["alternatives"] == {"states": 260, "edges": 1332}


def test_ulysse_has_causes_and_a_controller(tmp_path: Path) -> None:
    cut_sets = [["thruster_actuator"], ["GPS_sensor", "IMU_sensor"]]
    assert output("causes", ULYSSE)["mission"]["cut_sets"] == cut_sets
    assert mcpn("controller", ULYSSE, "-o", tmp_path).returncode == 0
    assert json.loads((tmp_path / "controller.json").read_text())["format"] == "mcpn-controller"
