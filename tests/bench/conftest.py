"""A mission as a file, for tests of the bench as a command."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.writer import write_mission
from tests.bench.test_bench import one_sensor


@pytest.fixture
def written(tmp_path: Path) -> str:
    path = tmp_path / "mission.xml"
    path.write_bytes(write_mission(one_sensor()))
    return str(path)
