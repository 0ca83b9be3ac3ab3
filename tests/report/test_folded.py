"""Rounds and tries of which the same is to be said are said together."""

from __future__ import annotations

import re

from hypothesis import event, given
from hypothesis import strategies as st

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
    assert folded(of, home[1:]) == ["home (all 4 but home_try1)"]
    assert folded(of, home[:2]) == home[:2]
    assert folded(of, []) == []


def test_rounds_of_which_nothing_is_said_are_named() -> None:
    of = compose(read_mission(ROOT / "experiments" / "glider" / "mission.xml"))
    names = [section.name for section in of.graph.walk()]
    reports = [name for name in names if ".report" in name]
    assert len(reports) == 15
    assert folded(of, reports[:12]) == ["tooth.report (all 15 but tooth_5.report)"]
    assert folded(of, reports[3:9]) == ["tooth_2.report (all 3)", "tooth_3.report (all 3)"]
    assert folded(of, reports[2:4]) == ["tooth_1.report_try3", "tooth_2.report_try1"]


SAID = re.compile(r"(?P<name>\S+)(?: \(all (?P<number>\d+)(?: but (?P<left>.*))?\))?")


@given(missions(), st.data())
def test_what_is_said_together_means_what_was_asked(mission: Mission, data: st.DataObject) -> None:
    """Each name is looked up as formulas look it up: what is left out of a group is taken from it."""
    of = compose(mission)
    copies, names = of.graph.copies, [section.name for section in of.graph.walk()]
    asked = data.draw(st.sets(st.sampled_from(names)))
    found = list[str]()
    for said in folded(of, sorted(asked, key=names.index)):
        match = SAID.fullmatch(said)
        assert match is not None, said
        if match["number"] is None:
            found.append(said)
            continue
        meant = [name for name in copies.meant(match["name"]) if name in names]
        assert len(meant) == int(match["number"])
        left = [each for one in (match["left"] or "").split(", ") if one for each in copies.meant(one)]
        event(f"some copies are left out: {bool(left)}")
        assert {*left} < {*meant}
        found += (name for name in meant if name not in left)
    assert sorted(found) == sorted(asked)


@given(missions())
def test_no_objective_is_left_out_or_said_twice(mission: Mission) -> None:
    of = compose(mission)
    names = [section.name for section in of.graph.walk()]
    several = [re.fullmatch(r"(?P<name>.*) \(all (?P<number>\d+)\)", said) for said in folded(of, names)]
    counts = [int(found["number"]) if found else 1 for found in several]
    assert sum(counts) == len(names)
    assert len(folded(of, names)) <= len(names)
