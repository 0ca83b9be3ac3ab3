"""Who asks at the very moment when a producer is refused, as the language page says: missions once drawn."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.xml import read_mission
from tests.judge.lockstep import Judge

TAKEN_AT_ONCE = """<mission xmlns="urn:mcpn:mission:1" name="mission">
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
"""activity2 wants h0 and what producer0 produces, which wants h0 too: who has it first is not said."""

ASKED_AT_ONCE = """<mission xmlns="urn:mcpn:mission:1" name="mission">
  <robot name="robot">
    <hardware name="h0" repairable="false"/>
    <hardware name="h1" shared="true" initial="oos"/>
    <hardware name="h2"/>
    <software name="s0a"/>
    <software name="s0b"/>
    <software name="s1a"/>
    <software name="s2a" exclusive="true"/>
    <activity name="producer0" produces="s0a s0b" faulty="true">
      <alternative name="producer0_way0" consumes="h1 h0" faulty="true" recovers="false"/>
      <alternative name="producer0_way1" consumes="h2 h0"/>
    </activity>
    <activity name="producer1" produces="s1a">
      <alternative name="producer1_way0" consumes="s0b" faulty="true"/>
      <alternative name="producer1_way1" faulty="true"/>
      <alternative name="producer1_way2"/>
    </activity>
    <activity name="producer2" produces="s2a" switch_back="true" faulty="true">
      <alternative name="producer2_way0" consumes="s0b" faulty="true"/>
      <alternative name="producer2_way1" consumes="s0a h2" faulty="true"/>
      <alternative name="producer2_way2" consumes="s1a"/>
    </activity>
    <activity name="activity3" consumes="s0a s2a"/>
  </robot>
  <objective name="obj8" activities="activity3" failure="fail"/>
</mission>"""
"""producer1 asks while producer0 is refused, for which activity3 starts it again in the same reaction."""

GIVEN_UP_FIRST = """<mission xmlns="urn:mcpn:mission:1" name="mission">
  <robot name="robot">
    <hardware name="h0"/>
    <hardware name="h1" initial="oos"/>
    <hardware name="h2" repairable="false"/>
    <software name="s0a"/>
    <software name="s1a"/>
    <software name="s1b"/>
    <software name="s2a"/>
    <software name="s2b"/>
    <activity name="producer0" produces="s0a">
      <alternative name="producer0_way0" consumes="h0" faulty="true" recovers="false"/>
      <alternative name="producer0_way1" consumes="h1"/>
      <alternative name="producer0_way2" consumes="h2 h0"/>
    </activity>
    <activity name="producer1" produces="s1a s1b">
      <alternative name="producer1_way0" consumes="s0a h0"/>
      <alternative name="producer1_way1" consumes="s0a"/>
      <alternative name="producer1_way2" consumes="h1"/>
    </activity>
    <activity name="producer2" produces="s2a s2b" switch_back="true">
      <alternative name="producer2_way0"/>
      <alternative name="producer2_way1" consumes="s1a" faulty="true" recovers="false"/>
    </activity>
    <activity name="activity3">
      <alternative name="activity3_way0" consumes="s1b"/>
      <alternative name="activity3_way1" consumes="s1a"/>
    </activity>
    <activity name="activity4" faulty="true" recovers="false">
      <alternative name="activity4_way0" consumes="s2b" faulty="true" recovers="false"/>
      <alternative name="activity4_way1" consumes="s1b" faulty="true"/>
      <alternative name="activity4_way2" consumes="s1a h1"/>
    </activity>
    <activity name="activity5">
      <alternative name="activity5_way0" consumes="s1a" faulty="true"/>
      <alternative name="activity5_way1" consumes="h0"/>
      <alternative name="activity5_way2" consumes="s2b"/>
    </activity>
    <activity name="activity6">
      <alternative name="activity6_way0" consumes="s1b s0a" faulty="true" recovers="false"/>
      <alternative name="activity6_way1" consumes="s0a"/>
    </activity>
  </robot>
  <objective name="obj6" activities="activity4" failure="succeed"/>
</mission>"""
"""producer1, whose supplier is refused, gives up before it answers activity4, which has just asked."""


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (TAKEN_AT_ONCE, "undetermined"),
        pytest.param(ASKED_AT_ONCE, "agree", marks=pytest.mark.slow),  # has thousands of states
        (GIVEN_UP_FIRST, "agree"),
    ],
)
def test_all_that_play_it_agree(text: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(text)
    assert Judge(read_mission(tmp_path / "m.xml")).judge().kind == kind
