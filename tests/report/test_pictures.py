"""Pictures of missions: everything of the mission is in them, and nothing of it is obeyed."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from lxml import etree

import mcpn
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Mission, Objective, Parallel, Recursive, walk
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.mission.xml import read_mission
from mcpn.report.pictures.boxes import Box, boxes
from mcpn.report.pictures.layout import lay_out, text_width
from mcpn.report.pictures.objectives_graph import objectives_picture
from mcpn.testing import missions
from tests import commands
from tests.conftest import ROOT

SVG = "{http://www.w3.org/2000/svg}"
HOSTILE = "</title><script>alert(1)</script>\"' onload=\u202e\u0000]]>&amp;" + "x" * 5000


def every(box: Box) -> list[Box]:
    return [box, *(inner for child in box.children for inner in every(child))]


@given(missions())
def test_every_objective_has_its_box(mission: Mission) -> None:
    """The boxes are those that the mission's text has, and copies lead to the box of what they copy."""
    root, keys = boxes(mission, flatten(mission))
    found = {box.key: box for box in every(root)}
    assert len(found) == len(every(root))
    for section in flatten(mission).walk():
        box = found[keys[section.name]]
        assert box.kind == "objective"
        assert box.activities == section.activities
        assert box.name in section.name
    picture = lay_out(root, mission)
    drawn = Counter(dict(frame.data)["box"] for frame in picture.frames if "box" in dict(frame.data))
    assert drawn == Counter(str(box.key) for box in found.values() if box.kind == "objective")
    assert len(drawn) >= sum(isinstance(block, Objective) for block in walk(mission.blocks))


@given(missions())
def test_nothing_stands_on_something_else(mission: Mission) -> None:
    """Two frames are apart, or one is in the other."""
    root, _ = boxes(mission, flatten(mission))
    picture = lay_out(root, mission)
    spans = [(f.x, f.y, f.x + f.width, f.y + f.height) for f in picture.frames]
    for i, (left, top, right, bottom) in enumerate(spans):
        assert 0 <= left < right <= picture.width
        assert 0 <= top < bottom <= picture.height
        for other in spans[:i]:
            apart = other[2] <= left or right <= other[0] or other[3] <= top or bottom <= other[1]
            inside = other[0] < left and other[1] < top and right < other[2] and bottom < other[3]
            assert apart or inside, (spans[i], other)


@pytest.mark.parametrize("name", ["ulysse", "rover", "drone", "glider", "courier"])
def test_a_mission_is_drawn(name: str, tmp_path: Path) -> None:
    path = ROOT / "experiments" / name / "mission.xml"
    assert commands.mcpn("convert", path, tmp_path / "m.svg").returncode == 0
    tree = etree.parse(tmp_path / "m.svg")
    texts = {element.text for element in tree.iter(f"{SVG}text")}
    mission = read_mission(path)
    assert {a.name for a in mission.activities} | {h.name for h in mission.hardware} <= texts
    for handler in mission.handlers:
        assert any(f"on {handler.event}" in (text or "") for text in texts)
    picture = mcpn.open(mission).picture()
    assert picture._repr_svg_() == (tmp_path / "m.svg").read_text()


def test_routes_of_ulysse() -> None:
    """One line from each block for each outcome, as the mission's text says."""
    mission = read_mission(ROOT / "experiments" / "ulysse" / "mission.xml")
    root, _ = boxes(mission, flatten(mission))
    titles = Counter(line.title for line in lay_out(root, mission).lines)
    for title in (
        "coral_head: failure leads to transect",
        "diving: failure leads to going_up",
        "census: failure leads to going_up",
        "going_up: failure leads to fail",
        "manual_moving succeeds",
        "census succeeds",
        "transect succeeds",
    ):
        assert titles[title] == 1, title


ROUTED = """<mission xmlns="urn:mcpn:mission:1" name="errand">
  <robot name="r">
    <fact name="battery" values="high low"/><fact name="holding"/>
    <event name="drained"><sets fact="battery" to="low"/></event><activity name="go"/>
  </robot>
  <objective name="fetch" activities="go" failure="fail">
    <sets fact="holding" to="true"/>
    <route when="battery=low !holding" goto="dock"/>
    <route when="battery=low" goto="dock" on="failure"/>
  </objective>
  <objective name="bring" activities="go" success="succeed"/>
  <objective name="dock" activities="go"/>
</mission>
"""


def test_routes_that_facts_decide_are_drawn(tmp_path: Path) -> None:
    path = tmp_path / "errand.xml"
    path.write_text(ROUTED)
    mission = read_mission(path)
    picture = lay_out(boxes(mission, flatten(mission))[0], mission)
    titles = Counter(line.title for line in picture.lines)
    assert titles["fetch: when battery=low !holding leads to dock"] == 1
    assert titles["fetch: failure when battery=low leads to dock"] == 1
    arrows = {arrow.title: arrow for arrow in objectives_picture(flatten(mission), "errand").edges}
    success = arrows["fetch: success, when battery=low !holding leads to dock"]
    assert (success.kind, success.lines) == ("success", ("when battery=low !holding",))
    assert arrows["fetch: success, else leads to bring"].target == "bring"
    assert arrows["fetch: failure, when battery=low leads to dock"].kind == "failure"
    assert arrows["bring: success leads to success"].lines == ()


def hostile() -> Mission:
    """A mission whose texts try to be more than text."""
    sensor = Hardware(name="s", description=HOSTILE)
    work = Activity(name="a", description=HOSTILE, alternatives=(Alternative(name="w", consumes=("s",)),))
    inner = Parallel(
        name="p",
        blocks=(
            Objective(name="o", activities=("a",), description=HOSTILE),
            Recursive(name="r", mandatory=False, blocks=(Objective(name="q", activities=("b",)),)),
        ),
    )
    other = Activity(name="b", alternatives=(Alternative(name="b"),))
    robot = Robot(name="robot", hardware=(sensor,), activities=(work, other))
    return Mission(name="m", description=HOSTILE, blocks=(inner,), robots=(robot,))


def test_a_hostile_mission_is_text() -> None:
    svg = mcpn.open(hostile()).picture().svg
    tree = etree.fromstring(svg.encode())
    assert not list(tree.iter(f"{SVG}script"))
    assert not [name for element in tree.iter() for name in element.attrib if str(name).startswith("on")]
    titles = [element.text for element in tree.iter(f"{SVG}title")]
    assert any("<script>alert(1)</script>" in (title or "") for title in titles)


def test_a_net_too_large_to_be_read_is_not_drawn(tmp_path: Path) -> None:
    pytest.importorskip("pygraphviz", reason="needs pygraphviz: the extra pictures")
    ulysse = ROOT / "experiments" / "ulysse" / "mission.xml"
    assert commands.mcpn("convert", ulysse, tmp_path / "u.net").returncode == 0
    found = commands.mcpn("convert", tmp_path / "u.net", tmp_path / "u.svg")
    assert found.returncode == 2
    assert "the limit of what one drawing shows" in found.stderr
    assert not (tmp_path / "u.svg").exists()


@pytest.mark.parametrize("how", ['<on event="full" pause="aside"/>', "recover"])
def test_success_is_drawn_past_a_sibling_that_only_helps(how: str, tmp_path: Path) -> None:
    """It is entered for the block that pauses, or recovers, alone, and leads back to it."""
    recover, inside = (' recover="aside"', "") if how == "recover" else ("", how)
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><event name="full"/>'
        '<activity name="rest"/></robot>'
        f'<objective name="work" activities="rest"{recover}>{inside}</objective>'
        '<objective name="aside" activities="rest"/><objective name="park" activities="rest"/></mission>'
    )
    found = read_mission(tmp_path / "m.xml")
    root, _ = boxes(found, flatten(found))
    titles = {line.title for line in lay_out(root, found).lines}
    assert "work: success leads to park" in titles
    assert "park succeeds" in titles
    assert not {"work succeeds", "aside succeeds"} & titles


FACTS = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="motor" repairable="false"/>
    <hardware name="radio" initial="oos" detected="late"/>
    <hardware name="hull" faulty="false"/>
    <fact name="tide" values="low high" initial="high"/>
    <event name="tide_falls"><sets fact="tide" to="low"/></event>
    <activity name="map" requires="tide=high">
      <alternative name="quick" consumes="motor hull" requires="tide=high"/>
      <alternative name="slow" consumes="motor radio"/>
    </activity>
  </robot>
  <objective name="o" activities="map"><sets fact="tide" to="low" on="failure"/></objective>
</mission>
"""


def test_what_facts_ask_and_what_is_never_repaired_is_drawn(tmp_path: Path) -> None:
    """All that the robot's elements say that decides a mission; and no heading is cut."""
    path = tmp_path / "m.xml"
    path.write_text(FACTS)
    picture = etree.fromstring(mcpn.open(path).picture().svg.encode())
    texts = {str(text.text): float(text.get("x", "0")) for text in picture.iter("{*}text")}
    assert set(texts) >= {
        "1. quick: motor + hull, if tide=high",
        "2. slow: motor + radio",
        "if tide=high",
        "may fail, and is not repaired",
        "out of service at the start",
        "its loss is noticed late",
        "never fails",
        "low or high, at first high",
        "set by tide_falls",
        "failure sets tide=low",
    }
    assert all(x + text_width(text) <= float(picture.get("width", "0")) for text, x in texts.items())
