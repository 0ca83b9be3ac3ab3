"""The report: a page that stands alone, whose live controller does what the runtime does."""

from __future__ import annotations

import random
import re
from contextlib import suppress
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from mcpn.drawing.compose import compose
from mcpn.findings import Findings, findings
from mcpn.mission.model import Handler, Mission, Objective
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Hardware, Robot
from mcpn.mission.xml import read_mission
from mcpn.report.page import page
from mcpn.report.pages.result_tables import tables
from mcpn.robot.runtime import Controller, Journal, Refused
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE
from tests.report.tabs import boxes_of, click, compare, opened
from tests.report.test_pictures import HOSTILE, hostile


class Elements(HTMLParser):
    """The elements of a page with their attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_journal_of_the_runtime_is_replayed(
    browser: Any, ulysse_findings: Findings, tmp_path: Path
) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    runtime, journal = Controller.from_document(ulysse_findings.controller), StringIO()
    runtime.observe(Journal(journal))
    for event in ("MISSION_EV_START", "no_such_EV", "GPS_sensor_EV_OOS", "MISSION_EV_START"):
        with suppress(Refused):
            runtime.handle(event)
    lines = journal.getvalue().splitlines()
    for text, said in (
        (lines, "2 events replayed."),
        ([*lines, lines[2]], "Line 5: GPS_sensor_EV_OOS is not possible here."),
        (
            [lines[0].replace('"refused": false', '"refused": true')],
            "Line 1: MISSION_EV_START is possible here.",
        ),
        (["{"], "Line 1 is no line of a journal."),
        (["[]"], "Line 1 holds no event."),
    ):
        file = {"name": "log.jsonl", "mimeType": "application/json", "buffer": "\n".join(text).encode()}
        tab.locator("#replayed").evaluate("part => { part.textContent = ''; }")
        tab.locator("#journal").set_input_files(file)
        tab.locator("#replayed:not(:empty)").wait_for()
        assert tab.locator("#replayed").text_content().startswith(said)
        if text == lines:
            compare(tab, runtime, boxes_of(tab))
    assert wrong == []


def test_a_failure_and_a_recovery(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    runtime = Controller.from_document(ulysse_findings.controller)
    boxes = boxes_of(tab)
    compare(tab, runtime, boxes)
    for event in (
        "MISSION_EV_START",
        "OBJ_coral_head.manual_moving_EV_FAIL",
        "GPS_sensor_EV_OOS",
        "IMU_sensor_EV_OOS",
        "GPS_sensor_EV_RD",
        "OBJ_transect.diving_EV_FAIL",
        "OBJ_transect.going_up_EV_OK",
    ):
        actions = runtime.handle(event)
        click(tab, event)
        compare(tab, runtime, boxes)
        told = tab.locator("#history li").last.locator("small")
        shown = told.text_content() if told.count() else ""
        assert [text.split(": ")[0] for text in shown.split("; ") if text] == [
            " ".join(filter(None, (a.verb, a.activity or a.hardware))) for a in actions
        ]
    assert runtime.outcome == "success"
    assert wrong == []


INHERITED = ("constructor", "toString", "valueOf", "hasOwnProperty", "isPrototypeOf", "__proto__")
"""Names that the objects of JavaScript inherit."""


def test_names_that_objects_of_a_browser_inherit(browser: Any, tmp_path: Path) -> None:
    arms = [Hardware(name=name) for name in INHERITED]
    lays = [
        Activity(name=name, alternatives=(Alternative(name=name, consumes=(name,)),)) for name in INHERITED
    ]
    events = tuple(DeclaredEvent(name=name) for name in INHERITED)
    blocks = tuple(Objective(name=name, activities=(name,)) for name in INHERITED)
    handlers = tuple(Handler(event=name, goto=name) for name in INHERITED)
    robot = Robot(name="robot", hardware=tuple(arms), activities=tuple(lays), events=events)
    mission = Mission(name="constructor", robots=(robot,), blocks=blocks, handlers=handlers)
    found = findings(compose(mission))
    tab, wrong = opened(browser, page(found), tmp_path)
    assert found.controller is not None
    runtime, boxes = Controller.from_document(found.controller), boxes_of(tab)
    ended = (f"OBJ_{name}_EV_OK" for name in INHERITED)
    for event in (
        "MISSION_EV_START",
        "toString_EV_OOS",
        "toString_EV_RD",
        "valueOf",
        "constructor",
        *ended,
    ):
        runtime.handle(event)
        click(tab, event)
        compare(tab, runtime, boxes)
    assert runtime.outcome == "success"
    shown = tab.locator("body").inner_text()
    assert "[object Object]" not in shown
    assert "function" not in tab.locator("#history").inner_text()
    assert wrong == []


def test_undo_and_keyboard(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    """Undo leads back through each state; a button answers the Enter key."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    seen = []
    for event in ("MISSION_EV_START", "GPS_sensor_EV_OOS", "GPS_sensor_EV_RD"):
        seen.append(tab.locator("#now").text_content())
        tab.locator(f'#events button[data-event="{event}"]').focus()
        tab.keyboard.press("Enter")
    assert tab.locator("#history li").count() == 3
    for text in reversed(seen):
        tab.keyboard.press("u")
        assert tab.locator("#now").text_content() == text
    assert tab.locator("#undo").is_disabled()
    compare(tab, Controller.from_document(ulysse_findings.controller), boxes_of(tab))
    assert wrong == []


LATE = """<mission name="photo" xmlns="urn:mcpn:mission:1">
  <robot name="drone">
    <hardware name="camera" detected="late"/>
    <activity name="look">
      <alternative name="by_eye" consumes="camera"/>
      <alternative name="by_ear"/>
    </activity>
  </robot>
  <objective name="search" activities="look" retries="1"/>
</mission>
"""


def test_a_loss_that_is_detected_late(browser: Any, tmp_path: Path) -> None:
    """Before the mission, while it runs, and after it: what is not known to be lost is not repaired."""
    (tmp_path / "mission.xml").write_text(LATE)
    found = findings(compose(read_mission(tmp_path / "mission.xml")))
    assert found.controller is not None
    tab, wrong = opened(browser, page(found), tmp_path)
    runtime, boxes = Controller.from_document(found.controller), boxes_of(tab)
    first, second = "OBJ_search_try1_EV_FAIL", "OBJ_search_try2_EV_OK"
    for event in ("camera_EV_OOS", "MISSION_EV_START", first, "camera_EV_RD", second, "camera_EV_OOS"):
        runtime.handle(event)
        click(tab, event)
        compare(tab, runtime, boxes)
    assert wrong == []


@pytest.mark.parametrize("seed", range(3))
def test_random_events(browser: Any, ulysse_findings: Findings, seed: int, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    assert ulysse_findings.controller is not None
    runtime = Controller.from_document(ulysse_findings.controller)
    boxes, draw = boxes_of(tab), random.Random(seed)
    for _ in range(25):
        event = draw.choice(runtime.possible)
        runtime.handle(event)
        click(tab, event)
        compare(tab, runtime, boxes)
    assert wrong == []


def test_runs_are_replayed(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    for name, outcome in (("success_reachable", "success"), ("failure_reachable", "failure")):
        verdict = tab.locator("details.verdict", has_text=name)
        verdict.locator("summary").click()
        verdict.locator("button.replay").click()
        assert outcome in tab.locator("#now").text_content()
    assert wrong == []


def test_tables_sort_and_filter(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    section = tab.locator("section", has=tab.locator("h2", has_text="FMECA"))
    assert ulysse_findings.fmeca is not None
    rows = section.locator("tbody tr:visible")
    (table,) = (t for t in tables(ulysse_findings) if t.name.startswith("FMECA"))
    assert rows.count() == len(table.rows)
    section.locator("input").fill("gps_sensor transect.diving")
    told = [" ".join(row).lower() for row in table.rows]
    wanted = [text for text in told if "gps_sensor" in text and "transect.diving" in text]
    assert 0 < len(wanted) < len(told)
    assert rows.count() == len(wanted)
    section.locator("input").fill("")
    for direction in (1, -1):
        section.locator("th button").nth(1).click()
        names = section.locator("tbody tr td:nth-child(2)").all_text_contents()
        assert names == sorted(names, key=str.lower)[::direction]
    assert wrong == []


def test_the_page_answers_what_is_asked_first(ulysse_findings: Findings) -> None:
    """Can it succeed, what makes it fail, what happens when the GPS fails during the dive."""
    told = re.sub(r"\s+", " ", Elements(page(ulysse_findings)).text)
    assert "The mission can succeed." in told
    lost = "The loss of thruster_actuator, or of GPS_sensor and IMU_sensor together before the start"
    assert f"{lost}, not repaired, leaves no way to success." in told
    alone = "After the loss of any one of GPS_sensor and IMU_sensor alone, whenever it comes"
    assert f"{alone}, success stays possible." in told
    row = re.search(r"transect\.diving ?(goes on[^;]*); mission can still succeed", told)
    assert row is not None
    assert row[1] == "goes on in another mode (localisation: gps_localisation -> imu_localisation)"


def test_local_graphs_are_zoomed(browser: Any, ulysse_findings: Findings, tmp_path: Path) -> None:
    """One for each type of section; it becomes larger and smaller by buttons and keys."""
    pytest.importorskip("pygraphviz", reason="needs pygraphviz: the extra pictures")
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    pictures = tab.locator("#local details")
    assert pictures.count() == len(ulysse_findings.local) == 2
    pictures.nth(1).locator("summary").click()
    svg = pictures.nth(1).locator("svg")
    fitting = svg.bounding_box()["width"]
    pictures.nth(1).locator("[data-zoom=in]").click()
    assert svg.bounding_box()["width"] == pytest.approx(1.25 * fitting, rel=0.01)
    pictures.nth(1).locator(".drawing").focus()
    tab.keyboard.press("0")
    assert svg.bounding_box()["width"] == pytest.approx(int(svg.get_attribute("width")), rel=0.01)
    ids = tab.eval_on_selector_all("[id]", "all => all.map(one => one.id)")
    assert len(set(ids)) == len(ids)
    assert wrong == []


def test_risk_is_told_where_there_are_rates() -> None:
    found = findings(compose(read_mission(ROOT / "experiments" / "rover" / "mission.xml")))
    assert found.risk is not None
    text = Elements(page(found)).text
    assert f"the mission ends in success with probability {found.risk.success:.6g}" in text
    assert "importance of" in text


def test_risk_is_told_where_an_event_alone_has_a_rate(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        """<mission name="m" xmlns="urn:mcpn:mission:1">
          <robot name="r"><event name="leak" rate="0.5"/><event name="call"/><activity name="go"/></robot>
          <on event="leak" goto="fail"/><on event="call" goto="fail"/>
          <objective name="leg" activities="go" duration="2"/>
        </mission>"""
    )
    text = Elements(page(findings(compose(read_mission(tmp_path / "m.xml"))))).text
    assert (
        "With the given rates the mission ends in each of success and failure with probability 0.5." in text
    )
    assert "call has no rate, and never happens in these numbers." in text


def test_a_mission_whose_sections_are_interrupted(browser: Any, tmp_path: Path) -> None:
    """The warehouse drone: low battery ends any section, people nearby one of them."""
    found = findings(compose(read_mission(ROOT / "experiments" / "drone" / "mission.xml")))
    assert found.controller is not None
    runtime = Controller.from_document(found.controller)
    tab, wrong = opened(browser, page(found), tmp_path)
    boxes, draw = boxes_of(tab), random.Random(1)
    declared = 0
    for _ in range(20):
        events = [event for event in runtime.possible if not event.endswith(("_OOS", "_RD"))]
        if not events:
            break
        event = draw.choice(events)
        declared += not event.startswith(("OBJ_", "MISSION_"))
        runtime.handle(event)
        click(tab, event)
        compare(tab, runtime, boxes)
    assert declared
    assert wrong == []


def test_a_hostile_mission_runs_nothing(browser: Any, tmp_path: Path) -> None:
    """What tries to be a script is read as text; that the page can tell is seen with a script of its own."""
    text = page(findings(compose(hostile())))
    tab, wrong = opened(browser, text, tmp_path)
    assert wrong == []
    click(tab, "MISSION_EV_START")
    assert "<script>alert(1)</script>" in tab.locator("header").text_content()
    assert tab.locator("script").count() == 2
    injected = text.replace("<main>", "<main><script>alert(2)</script>")
    _, wrong = opened(browser, injected, tmp_path)
    assert len(wrong) == 1
    assert "Content Security Policy" in wrong[0]


def test_texts_are_escaped() -> None:
    """The same without a browser: the elements are those of a harmless mission with the same names."""

    def harmless(mission: Mission) -> Mission:
        return replace(mission, description="x")

    evil = Elements(page(findings(compose(hostile()))))
    good = Elements(page(findings(compose(harmless(hostile())))))
    assert [tag for tag, _ in evil.elements] == [tag for tag, _ in good.elements]
    assert [set(a) for _, a in evil.elements] == [set(a) for _, a in good.elements]
    assert HOSTILE[:30] in evil.text


def test_the_page_needs_nothing_else(ulysse_findings: Findings) -> None:
    found = Elements(page(ulysse_findings))
    for tag, attributes in found.elements:
        assert tag not in ("img", "link", "iframe", "object"), tag
        for name, value in attributes.items():
            assert name != "src"
            assert name != "href" or (value or "").startswith("#")
            assert not name.startswith("on")


def test_the_command(tmp_path: Path) -> None:
    told = output("report", ULYSSE, "-o", tmp_path / "u.html")
    assert told["passed"] is True
    assert told["engine"] == "explicit"
    assert (tmp_path / "u.html").stat().st_size == told["bytes"]
    local = output("report", ULYSSE, "-o", tmp_path / "l.html", "--engine", "local")
    assert local["engine"] == "local"
    refused = mcpn("report", ULYSSE, "-o", tmp_path / "u.pdf")
    assert refused.returncode == 2
    assert "expected .html" in refused.stderr
    assert not (tmp_path / "u.pdf").exists()


@pytest.mark.parametrize(
    "name",
    ["rover", "drone", *(pytest.param(name, marks=pytest.mark.slow) for name in ("glider", "courier"))],
)
def test_other_missions(name: str, tmp_path: Path) -> None:
    path = ROOT / "experiments" / name / "mission.xml"
    told = output("report", path, "-o", tmp_path / "m.html")
    text = Elements((tmp_path / "m.html").read_text()).text
    for activity in read_mission(path).activities:
        assert activity.name in text
    assert told["passed"] is True


def test_an_interruption(browser: Any, tmp_path: Path) -> None:
    """A declared event has its button; a mission that cannot be taken apart is run in one piece."""
    mission = hostile()
    robot = replace(mission.robots[0], events=(DeclaredEvent(name="leak"),))
    surface = Objective(name="surface", activities=("b",))
    mission = replace(
        mission,
        robots=(robot,),
        blocks=(*mission.blocks, surface),
        handlers=(Handler(event="leak", goto="surface", once=True),),
    )
    found = findings(compose(mission))
    assert found.controller is not None
    runtime = Controller.from_document(found.controller)
    tab, wrong = opened(browser, page(found), tmp_path)
    boxes = boxes_of(tab)
    for event in ("MISSION_EV_START", "s_EV_OOS", "leak", "OBJ_surface_EV_OK"):
        compare(tab, runtime, boxes)
        if event == "MISSION_EV_START":
            assert "leak" not in runtime.possible
        runtime.handle(event)
        click(tab, event)
    compare(tab, runtime, boxes)
    assert runtime.outcome == "success"
    assert wrong == []
