"""The controller of a page as a film: played, stepped through, linked to, on phones, on paper, with keys."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.simulator import HARDWARE, Simulation
from mcpn.drawing.compose import compose
from mcpn.events import Event, What
from mcpn.findings import Findings, findings
from mcpn.mission.model import Handler, Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Hardware, Robot
from mcpn.mission.xml import read_mission
from mcpn.report.page import page
from mcpn.robot.runtime import Controller
from tests.conftest import ROOT, ULYSSE
from tests.report.tabs import boxes_of, click, compare, lit, opened, state, steps

NATURAL = ROOT / "tests" / "natural"
DUMPSTER = NATURAL / "dumpster.xml"


def test_a_run_is_played_and_stepped_through(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    boxes = boxes_of(tab)
    tab.clock.install(time=0)
    tab.clock.pause_at(3_600_000)  # it goes on where a test says so
    tab.locator(".story .replay").click()
    events = steps(tab)
    assert events[0] == "MISSION_EV_START"
    assert state(tab) == "The mission has not begun."
    at = tab.locator("#play").bounding_box()
    for number in range(1, len(events) + 1):
        tab.clock.run_for(900)
        runtime = Controller.from_document(ulysse_findings.controller)
        for event in events[:number]:
            runtime.handle(event)
        compare(tab, runtime, boxes)
        assert tab.locator("#place").text_content() == f"{number} of {len(events)}"
        assert tab.locator("#play").bounding_box() == at  # under the pointer
    assert runtime.outcome == "success"
    tab.clock.run_for(5000)
    assert tab.locator("#play").text_content() == "play"
    succeeded = lit(tab, "rect.been.succeeded", "box")
    assert succeeded == {str(boxes[e[4:-6]]) for e in events if e.startswith("OBJ_")}
    tab.locator("#slider").fill("2")
    assert tab.locator("#place").text_content() == f"2 of {len(events)}"
    assert tab.locator("#history .ahead").count() == len(events) - 2
    tab.locator("#step").click()
    tab.locator("#undo").click()
    tab.locator("#undo").click()
    assert tab.locator("#place").text_content() == f"1 of {len(events)}"
    assert steps(tab) == events
    click(tab, "GPS_sensor_EV_OOS")  # another way: what followed is gone
    assert steps(tab) == [events[0], "GPS_sensor_EV_OOS"]
    assert tab.locator("#step").is_disabled()
    assert wrong == []


def test_a_link_leads_to_a_state(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    for event in ("MISSION_EV_START", "GPS_sensor_EV_OOS", "OBJ_coral_head.manual_moving_EV_OK"):
        click(tab, event)
    tab.locator("#undo").click()
    address, said, lights = tab.url, state(tab), lit(tab, "rect[data-box].lit", "box")
    assert address.endswith("&at=2")
    other = tab.context.new_page()
    other.goto(address)
    assert (state(other), lit(other, "rect[data-box].lit", "box")) == (said, lights)
    assert other.locator("#history li").count() == 3
    other.evaluate("location.hash = '#run=MISSION_EV_START,IMU_sensor_EV_OOS'")
    other.locator("#history li >> nth=1").get_by_text("IMU_sensor").wait_for()
    for broken in ("#run=nothing,at_all", "#run=%E0%A4%A", "#run=MISSION_EV_START&at=x"):
        other.evaluate("hash => { location.hash = hash; }", broken)
        other.wait_for_function("document.getElementById('history').children.length < 2")
    assert wrong == []


def test_keys(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    tab.clock.install(time=0)
    tab.clock.pause_at(3_600_000)  # it goes on where a test says so
    tab.keyboard.press(" ")  # nothing has been chosen: the run without failures
    tab.clock.run_for(1800)
    tab.keyboard.press(" ")
    place = tab.locator("#place")
    assert place.text_content().startswith("2 of ")
    for key, at in (("ArrowRight", 3), ("ArrowLeft", 2), ("u", 1), ("r", 0), ("End", 8), ("Home", 0)):
        tab.keyboard.press(key)
        assert place.text_content() == f"{at} of 8"
    section = tab.locator("section", has=tab.locator("h2", has_text="FMECA"))
    section.locator("input").press("ArrowRight")  # moves in the text
    section.locator("input").type("ur c")
    assert place.text_content() == "0 of 8"
    assert wrong == []


def test_chance_starts_the_mission_and_mostly_succeeds(
    browser: Any, ulysse_findings: Findings, tmp_path: Path
) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    ends = []
    for _ in range(20):
        tab.locator("#chance").click()
        runtime = Controller.from_document(ulysse_findings.controller)
        for event in steps(tab):
            runtime.handle(event)
        ends.append(runtime.outcome)
        assert runtime.outcome is not None
        assert runtime.outcome in state(tab)
    assert ends.count("success") > 5
    assert wrong == []


@pytest.mark.parametrize("dark", [False, True])
def test_a_page_fits_a_phone(browser: Any, ulysse_findings: Findings, dark: bool, tmp_path: Path) -> None:
    """The page is as wide as the phone; drawing and controller are in view together."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    tab.set_viewport_size({"width": 390, "height": 844})
    tab.emulate_media(color_scheme="dark" if dark else "light")
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    tab.locator(".drawing").first.evaluate("part => part.scrollIntoView()")
    drawing, aside = tab.locator(".drawing").first.bounding_box(), tab.locator("aside").bounding_box()
    assert drawing["y"] + drawing["height"] <= aside["y"] + 1
    assert aside["y"] + 200 < 844
    paper = tab.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == ("rgb(18, 22, 27)" if dark else "rgb(255, 255, 255)")
    assert wrong == []


def test_a_long_run_is_scrolled_on_a_phone(browser: Any, tmp_path: Path) -> None:
    found = findings(compose(read_mission(ROOT / "experiments" / "drone" / "mission.xml")))
    tab, wrong = opened(browser, page(found), tmp_path)
    for width in (390, 700, 900, 1280):
        tab.set_viewport_size({"width": width, "height": 844})
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert wrong == []


def test_on_paper_nothing_is_cut(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    """Runs of what does not hold are open, the FMECA fits the sheet, what is clicked is left out."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    sheet = tab.context.browser.contexts[-1].pages[-1].pdf(path=tmp_path / "r.pdf", prefer_css_page_size=True)
    assert sheet.startswith(b"%PDF")
    tab.set_viewport_size({"width": 703, "height": 1000})  # of A4, at 96 dots an inch
    tab.emulate_media(media="print")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert tab.locator("details.verdict:not(.holds) ol").first.is_visible()
    assert not tab.locator("details.verdict.holds ol").first.is_visible()  # what holds is said, not shown
    for part in ("aside", "nav", ".zoom", "#lost"):
        assert not tab.locator(part).first.is_visible()
    assert all(line.is_visible() for line in tab.locator(".sign").all())
    heads = tab.locator("section", has=tab.locator("h2", has_text="FMECA")).locator("th")
    boxes = [head.bounding_box() for head in heads.all()]
    assert [head.inner_text() for head in heads.all()][:3] == ["hardware", "objective", "severity"]
    assert max(box["x"] + box["width"] for box in boxes) <= 703
    tab.evaluate("dispatchEvent(new Event('afterprint'))")
    assert tab.locator("details.verdict[open]").count() == 0
    assert wrong == []


def test_what_if_hardware_is_lost(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    """Each set of hardware, held against a search on the net that knows no cut sets."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    names = [h.name for h in ulysse_findings.check.mission_net.core.hardware if h.faulty]
    assert tab.locator("#lost input").count() == len(names)
    seen = set()
    for size in range(len(names) + 1):
        for lost in combinations(names, size):
            for name in names:
                tab.locator(f"#lost input[value={name}]").set_checked(name in lost)
            told = tab.locator("#loses").inner_text()
            game = Simulation(ulysse_findings.check.mission_net)
            for name in lost:
                game.take(Event(What.OUT_OF_SERVICE, name))
            succeeds = game.way_to("success", HARDWARE)
            if lost:
                assert ("can still succeed" in told) == (succeeds is not None), (lost, told)
                seen.add(succeeds is not None)
    assert seen == {True, False}
    tab.locator("#lost input[value=GPS_sensor]").set_checked(True)
    tab.locator("#lost input[value=IMU_sensor]").set_checked(False)
    tab.locator("#lost input[value=thruster_actuator]").set_checked(False)
    modes = tab.locator("section", has=tab.locator("h2", has_text="Functioning modes"))
    assert modes.locator("tr.gone").count() == 1
    assert "gps_localisation" in modes.locator("tr.gone").inner_text()
    tab.locator("#lose").click()
    assert steps(tab) == ["GPS_sensor_EV_OOS", "MISSION_EV_START"]
    assert "imu_localisation" in state(tab)
    assert wrong == []


PROTOTYPE = [
    "constructor",
    "hasOwnProperty",
    "isPrototypeOf",
    "propertyIsEnumerable",
    "toLocaleString",
    "toString",
    "valueOf",
    "__proto__",
    "__defineGetter__",
    "__defineSetter__",
    "__lookupGetter__",
    "__lookupSetter__",
]
"""All that objects of JavaScript inherit (ECMA-262, 20.1.3 and B.2.2)."""


def test_names_of_javascript_s_prototypes(browser: Any, tmp_path: Path) -> None:
    """As hardware, activities, alternatives, events, objectives in parallel, each told and played."""
    hardware = tuple(Hardware(name=name) for name in PROTOTYPE[:4])
    activities = tuple(
        Activity(
            name=name,
            alternatives=(
                Alternative(name=name, consumes=(PROTOTYPE[i % 4],)),
                Alternative(name=PROTOTYPE[i - 1]),
            ),
        )
        for i, name in enumerate(PROTOTYPE)
    )
    objectives = tuple(Objective(name=name, activities=(name,)) for name in PROTOTYPE)
    first, last = Parallel(name="pair", blocks=objectives[:2]), objectives[2:]
    robot = Robot(
        name="r", hardware=hardware, activities=activities, events=(DeclaredEvent(name="constructor"),)
    )
    mission = Mission(
        name="constructor",
        robots=(robot,),
        blocks=(first, *last),
        handlers=(Handler(event="constructor", goto=PROTOTYPE[-1]),),
    )
    held(browser, findings(compose(mission)), tmp_path, events=40)


def held(browser: Any, found: Findings, tmp_path: Path, events: int, seed: int = 1) -> None:
    """The page does what the runtime does with what may be another form of the controller."""
    tab, wrong = opened(browser, page(found), tmp_path)
    assert found.controller is not None
    runtime, boxes, draw = Controller.from_document(found.controller), boxes_of(tab), random.Random(seed)
    for _ in range(events):
        compare(tab, runtime, boxes)
        likely = [e for e in runtime.possible if not e.endswith(("_OOS", "_RD"))]
        if runtime.outcome:
            break
        event = draw.choice(likely if likely and draw.random() < 0.7 else runtime.possible)
        actions = runtime.handle(event)
        click(tab, event)
        told = tab.locator("#history li").last.locator("small")
        shown = told.text_content() if told.count() else ""
        assert len([text for text in shown.split("; ") if text]) == len(actions)
    text = tab.locator("body").inner_text()
    assert "[object Object]" not in text
    assert not re.search(r"function \w*\(", text)
    assert wrong == []


@pytest.mark.parametrize(("name", "seeds"), [("dumpster", (1, 2)), ("sewer", (1,))])
def test_missions_with_facts_and_wide_blocks(
    browser: Any, name: str, seeds: tuple[int, ...], tmp_path: Path
) -> None:
    """Facts are changed by events beside a section; the block of sewer has more states than a page holds."""
    found = findings(compose(read_mission(NATURAL / f"{name}.xml")))
    text = page(found)
    assert len(text) < 1_000_000
    for seed in seeds:
        held(browser, found, tmp_path, 25, seed)


def test_hardware_that_is_out_at_the_start_or_never_repaired(browser: Any, tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1">
          <robot name="r"><hardware name="a" initial="oos"/><hardware name="b" repairable="false"/>
            <hardware name="c" initial="oos"/>
            <activity name="go"><alternative name="first" consumes="a"/>
              <alternative name="second" consumes="b"/><alternative name="third"/></activity>
            <activity name="see" consumes="c"/></robot>
          <objective name="leg" activities="go"/><objective name="look" activities="see" failure="succeed"/>
        </mission>"""
    )
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    for seed in range(4):
        held(browser, found, tmp_path, 12, seed)


def test_tables_of_sections_are_run_too(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    """The hierarchical and the flat form, of a mission with facts and of one with handlers once."""
    for path, form in (
        (NATURAL / "dumpster.xml", "hierarchical"),
        (ULYSSE, "hierarchical"),
        (ULYSSE, "flat"),
    ):
        net = compose(read_mission(path))
        made = generate(net, form)  # type: ignore[call-overload]
        found = findings(net)
        held(browser, replace(found, controller=document(made, net)), tmp_path, 20)


def test_a_long_mission(browser: Any, tmp_path: Path) -> None:
    """A thousand sections: the page opens, and its film has their run."""
    robot = Robot(
        name="r",
        hardware=(Hardware(name="motor"),),
        activities=(Activity(name="go", alternatives=(Alternative(name="go", consumes=("motor",)),)),),
    )
    blocks = tuple(Objective(name=f"leg{i}", activities=("go",)) for i in range(1000))
    found = findings(compose(Mission(name="long", robots=(robot,), blocks=blocks)))
    tab, wrong = opened(browser, page(found), tmp_path)
    assert tab.locator(".strip li").count() == 14
    tab.locator(".story .replay").click()
    tab.locator("#end").click()
    assert state(tab) == "The mission has ended in success."
    assert tab.locator("#place").text_content() == "1001 of 1001"
    assert wrong == []


def test_a_film_that_plays_is_brought_to_its_end(
    browser: Any, ulysse_findings: Findings, tmp_path: Path
) -> None:
    """By the button, and step by step before the next step is due: then it plays no further."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    for press in ("#end", "#step"):
        tab.locator(".story .replay").click()
        assert tab.locator("#play").text_content() == "pause"
        while tab.locator(press).is_enabled():
            tab.locator(press).click()
        tab.wait_for_timeout(1_000)  # the next step would be due
        assert state(tab) == "The mission has ended in success."
        assert tab.locator("#play").text_content() == "play"
    assert wrong == []
