"""A small mission with hardware, a fault, crashes, facts, timers, an abort and branches."""

from __future__ import annotations

from pathlib import Path

from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.xml import read_mission


def composed(text: str, folder: Path) -> MissionNet:
    (folder / "mission.xml").write_text(text)
    return compose(read_mission(folder / "mission.xml"))


WATCH = """
<mission name="twice" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="camera"/><hardware name="lamp" initial="oos"/><hardware name="gps" repairable="false"/>
    <fault name="short" affects="camera lamp"/>
    <fact name="door" values="open closed"/>
    <event name="closes"><sets fact="door" to="closed"/></event>
    <event name="opens"><sets fact="door" to="open"/></event>
    <event name="leak"/>
    <activity name="look" faulty="true"><alternative name="bright" consumes="camera"/>
      <alternative name="dark" consumes="camera lamp"/></activity>
    <activity name="go" consumes="gps" requires="door=open"/>
    <activity name="rest"/>
  </robot>
  <on event="leak" goto="abort"/>
  <parallel name="both">
    <objective name="watch" activities="look" timeout="5" retries="1"/>
    <objective name="leave" activities="go"/>
  </parallel>
  <objective name="wait" activities="rest" timeout="2.5">
    <sets fact="door" to="closed" on="start"/>
  </objective>
</mission>
"""
