"""A mission on which engines and the interpreter without nets disagree: who is wrong is not known yet."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.xml import read_mission
from tests.judge.lockstep import Disagreement, Judge

WRITTEN = """<mission xmlns="urn:mcpn:mission:1" name="mission">
  <robot name="robot">
    <hardware name="h0"/>
    <hardware name="h1" repairable="false"/>
    <hardware name="h2" initial="oos"/>
    <fault name="f0" affects="h1"/>
    <software name="s0a"/>
    <software name="s0b" exclusive="true"/>
    <activity name="producer0" produces="s0a s0b">
      <alternative name="producer0_way0" consumes="h0"/>
      <alternative name="producer0_way1" consumes="h2 h1"/>
    </activity>
    <activity name="activity1">
      <alternative name="activity1_way0"/>
    </activity>
    <activity name="activity2" switch_back="true">
      <alternative name="activity2_way0" consumes="s0a h2"/>
      <alternative name="activity2_way1" consumes="s0b h0"/>
      <alternative name="activity2_way2" consumes="h1 h0"/>
    </activity>
  </robot>
  <objective name="obj5" activities="activity2 activity1" failure="abort" repeat="3"/>
</mission>"""


# Drawn with seed 43602076 of the profile "fresh".
@pytest.mark.xfail(raises=Disagreement, strict=True, reason="an activity and its producer want one hardware")
def test_a_producer_and_its_consumer_want_one_hardware(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(WRITTEN)
    Judge(read_mission(tmp_path / "m.xml")).judge()
