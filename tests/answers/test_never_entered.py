"""Causes of what a mission never reaches: by definition, and the same by every engine."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import Engine
from tests.logic.asked import ENGINES, Asked

NEVER: list[CutSet] = [()]
"""The cut sets of what no loss is needed for."""

BLOCK_THAT_ALWAYS_FAILS = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="R"><hardware name="arm"/><activity name="grip" consumes="arm"/><activity name="look"/></robot>
  <parallel name="search" success="after" failure="fail">
    <objective name="scan"><objective name="inspect" activities="look" success="fail"/></objective>
  </parallel>
  <objective name="after" activities="grip"/>
</mission>"""

ENDS_AT_THE_FIRST = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="R"><hardware name="arm"/><activity name="grip" consumes="arm"/></robot>
  <objective name="first" activities="grip" success="fail" failure="fail"/>
  <objective name="second" activities="grip"/>
  <objective name="third" activities="grip"/>
</mission>"""

BLOCK_BEHIND_WHAT_CANNOT_SUCCEED = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="R"><hardware name="arm"/><software name="grasp"/>
    <activity name="hold" produces="grasp">
      <alternative name="left" consumes="arm"/><alternative name="right" consumes="arm"/>
    </activity>
    <activity name="carry" consumes="arm grasp"/>
    <activity name="show"><alternative name="one" consumes="grasp"/><alternative name="two" consumes="grasp"/>
    </activity>
  </robot>
  <objective name="lift" failure="fail" activities="carry"/>
  <parallel name="both" failure="fail">
    <objective name="tour"><objective name="go" activities="carry"/>
      <objective name="back" failure="fail" activities="carry"/></objective>
    <objective name="display" activities="show"/>
  </parallel>
</mission>"""


def asked(text: str, engine: Engine, folder: Path) -> Asked:
    path = folder / "m.xml"
    path.write_text(text)
    return Asked(compose(read_mission(path)), engine)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_section_behind_a_block_that_always_fails(engine: Engine, tmp_path: Path) -> None:
    causes = asked(BLOCK_THAT_ALWAYS_FAILS, engine, tmp_path).all
    # Every state (there is none) in which it runs loses it, and no state does.
    assert causes.objectives["after"].moments == {
        "start": NEVER,
        "entry": NEVER,
        "whenever": NEVER,
        "sometime": [],
    }
    assert causes.objectives["after"].critical == causes.objectives["after"].critical_with_repairs == []
    assert set(map(tuple, causes.objectives["inspect"].moments.values())) == {()}
    assert causes.mission.moments == {"start": NEVER, "whenever": NEVER, "sometime": NEVER}


@pytest.mark.parametrize("engine", ENGINES)
def test_objectives_that_no_route_reaches(engine: Engine, tmp_path: Path) -> None:
    causes = asked(ENDS_AT_THE_FIRST, engine, tmp_path).all
    assert list(causes.objectives) == ["first"]
    assert set(map(tuple, causes.objectives["first"].moments.values())) == {(("arm",),)}
    assert causes.mission.moments == {"start": NEVER, "whenever": NEVER, "sometime": NEVER}


@pytest.mark.parametrize("engine", ENGINES)
def test_a_block_behind_what_cannot_succeed(engine: Engine, tmp_path: Path) -> None:
    causes = asked(BLOCK_BEHIND_WHAT_CANNOT_SUCCEED, engine, tmp_path).all
    # The arm carries or holds the grasp that carrying needs.
    assert set(map(tuple, causes.objectives["lift"].moments.values())) == {((),)}
    for name in ("go", "back", "display"):
        assert causes.objectives[name].moments["sometime"] == []
        assert causes.objectives[name].moments["whenever"] == NEVER
    assert [survival.at_most for survival in causes.survival] == [None, None, None]
