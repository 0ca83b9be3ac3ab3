"""Monitors on a bench, beside what the runs themselves say."""

from __future__ import annotations

import json
from pathlib import Path

from mcpn.mission.writer import write_mission
from tests.bench.test_bench import one_sensor
from tests.commands import mcpn, output


def test_as_many_runs_violate_a_requirement_as_fail(tmp_path: Path) -> None:
    text = write_mission(one_sensor()).decode()
    never = '<requirement name="never_fails" formula="G !failure" severity="advice"/>'
    ends = '<requirement name="starts" formula="F happens(MISSION_EV_START)" severity="advice"/>'
    head, robot, rest = text.partition("</robot>")
    path = tmp_path / "mission.xml"
    path.write_text(f"{head}{robot}{never}{ends}{rest}")
    said = output("bench", path, "--runs", "300", "--monitors")
    failed = said["outcomes"]["failure"]["count"]
    assert 0 < failed < 300
    assert said["monitors"]["never_fails"]["violated"] == failed
    assert said["monitors"]["starts"] == {"violated": 0, "satisfied": 300, "open": 0}
    shown = mcpn("bench", path, "--runs", "300", "--monitors")
    assert f"violated in {failed}" in shown.stdout
    assert json.loads(mcpn("bench", path, "--runs", "5", "--json").stdout)["monitors"] is None
