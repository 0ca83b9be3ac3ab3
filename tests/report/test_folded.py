"""Rounds and tries of which the same is to be said are said together."""

from __future__ import annotations

import re

from hypothesis import given

from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.report.words import folded
from mcpn.testing import missions
from tests.conftest import ROOT


def test_all_rounds_have_one_name() -> None:
    of = compose(read_mission(ROOT / "experiments" / "courier" / "mission.xml"))
    names = [section.name for section in of.graph.walk()]
    home = [name for name in names if name.startswith("home")]
    assert len(home) == 4
    assert folded(of, home) == ["home (all 4)"]
    assert folded(of, home[1:]) == home[1:]
    assert folded(of, []) == []


@given(missions())
def test_no_objective_is_left_out_or_said_twice(mission: Mission) -> None:
    of = compose(mission)
    names = [section.name for section in of.graph.walk()]
    several = [re.fullmatch(r"(?P<name>.*) \(all (?P<number>\d+)\)", said) for said in folded(of, names)]
    counts = [int(found["number"]) if found else 1 for found in several]
    assert sum(counts) == len(names)
    assert len(folded(of, names)) <= len(names)
