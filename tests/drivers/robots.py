"""A courier of five parts, for tests of drivers: its mission, and what they share."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

MISSION = """<mission name="round" xmlns="urn:mcpn:mission:1">
  <robot name="courier">
    <hardware name="lidar"/>
    <hardware name="encoders"/>
    <hardware name="wheels"/>
    <software name="scan"/>
    <software name="position"/>
    <event name="called_back"/>
    <activity name="lidar_driver" produces="scan" consumes="lidar"/>
    <activity name="localisation" produces="position">
      <alternative name="by_scan" consumes="scan"/>
      <alternative name="by_odometry" consumes="encoders"/>
    </activity>
    <activity name="drive" consumes="position wheels"/>
    <activity name="hand_over"/>
  </robot>
  <on event="called_back" goto="home" once="true"/>
  <objective name="travel" activities="drive" failure="home"><parameter name="room" value="12"/></objective>
  <objective name="give" activities="hand_over"/>
  <objective name="home" activities="drive"><parameter name="room" value="base"/></objective>
</mission>
"""

NEVER = ["lidar_EV_RD", "encoders_EV_*", "wheels_EV_*"]


def until(condition: Callable[[], object], seconds: float = 60.0) -> None:
    """Waits until something is so."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            pytest.fail(f"not so within {seconds} seconds")
        time.sleep(0.01)


def alive(number: int) -> bool:
    """Whether a process runs; one that nobody has waited for has ended."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):  # or it ends while it is read
        pass
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return not Path("/proc").is_dir()


def numbers(folder: Path, part: str | None = None) -> list[int]:
    """The processes that a part, or all parts, have been."""
    files = folder.glob("*.pids") if part is None else [folder / f"{part}.pids"]
    return [int(line) for file in files if file.exists() for line in file.read_text().splitlines()]
