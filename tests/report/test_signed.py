"""The page that one signs: nothing overlaps, it prints on few sheets, it is the same byte for byte."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from mcpn.drawing.compose import compose
from mcpn.findings import Findings, findings
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.report.page import page
from mcpn.report.pages.result_tables import MOST_BITS, tables
from mcpn.report.pictures.objectives import mission_drawing
from mcpn.testing import missions
from mcpn.testing.shape import Shape
from tests.conftest import ROOT, ULYSSE
from tests.report.tabs import opened

HOSPITAL = ROOT / "tests" / "natural" / "hospital.xml"
BUSY = """<mission name="busy" xmlns="urn:mcpn:mission:1">
<robot name="r"><event name="rain"/><event name="battery_low"/><event name="call_back"/><fact name="door"/>
<activity name="drive"/></robot>
<on event="call_back" goto="home"/><on event="battery_low" goto="abort"/>
<objective name="work" success="succeed" failure="abort" abort="home">
<on event="rain" pause="shelter"/><on event="battery_low" goto="home"/>
<objective name="go" activities="drive" timeout="5" timeout_goto="abort" abort="fail">
<route when="door" goto="go"/><on event="rain" goto="go"/><on event="battery_low" goto="abort"/></objective>
</objective>
<objective name="shelter" activities="drive" abort="home"/>
<objective name="home" activities="drive"/>
</mission>"""
A4 = 270 / 25.4 * 96
"""Pixels that a sheet is high, without its margins."""
MEASURE = """() => {
  const svg = document.querySelector("svg"), texts = [...svg.querySelectorAll("text")];
  const boxes = texts.map((text) => [text.textContent, text.getBoundingClientRect()]);
  const found = [];
  boxes.forEach(([one, a], i) => boxes.slice(i + 1).forEach(([two, b]) => {
    if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
        && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2) found.push([one, two]);
  }));
  return [texts.length, found];
}"""

WORKED = [ROOT / "experiments" / name / "mission.xml" for name in ("courier", "drone", "glider", "rover")]


def overlapping(browser: Any, mission: Mission) -> list[list[str]]:
    """Pairs of texts that a browser draws one over the other."""
    tab = browser.new_page()
    tab.set_content(f"<body>{mission_drawing(compose(mission)).svg}</body>")
    count, found = tab.evaluate(MEASURE)
    tab.close()
    assert count >= 3
    return list(found)


def read(text: str) -> Mission:
    file = Path("/nowhere/busy.xml")
    return read_mission(file, unsaved={file: text})


@pytest.mark.parametrize(
    "path", [ULYSSE, HOSPITAL, *(ROOT / "experiments").glob("[cdr]o[uv]*/mission.xml")], ids=str
)
def test_no_two_texts_of_a_worked_mission_overlap(browser: Any, path: Path) -> None:
    assert overlapping(browser, read_mission(path)) == []


def test_handlers_of_one_block_and_aborts_have_lines_of_their_own(browser: Any) -> None:
    assert overlapping(browser, read(BUSY)) == []


@settings(max_examples=12, suppress_health_check=[*HealthCheck])
@given(mission=missions(Shape(events=3, facts=2, timeouts=5, aborts=5, recovers=5, pauses=5)))
def test_no_two_texts_of_a_drawn_mission_overlap(browser: Any, mission: Mission) -> None:
    assert overlapping(browser, mission) == []


@pytest.mark.parametrize(
    ("path", "most"),
    [(ULYSSE, 6), (HOSPITAL, 10), *(pytest.param(path, 10, marks=pytest.mark.slow) for path in WORKED)],
    ids=str,
)
def test_a_page_prints_on_few_sheets(browser: Any, tmp_path: Path, path: Path, most: int) -> None:
    file = tmp_path / "page.html"
    file.write_text(page(findings(compose(read_mission(path)))))
    tab = browser.new_page()
    tab.goto(file.as_uri())
    sheets = len(re.findall(rb"/Type\s*/Page\b", tab.pdf(prefer_css_page_size=True)))
    # Paper is narrow, as a telephone is: what holds there must not hold here.
    tab.set_viewport_size({"width": 720, "height": 1050})
    tab.emulate_media(media="print")
    drawing = tab.locator(".drawing svg").first.bounding_box()
    heads = [head.bounding_box() for head in tab.locator("h2:visible").all()]
    signed = tab.locator(".identity").bounding_box()
    tab.close()
    assert 2 <= sheets <= most
    assert signed["y"] + signed["height"] < A4, "who signs has all that is signed on one sheet"
    below = [head["y"] for head in heads if head["y"] > drawing["y"]]
    assert len(below) > 2
    assert drawing["y"] + drawing["height"] <= min(below)


def test_on_a_telephone_a_row_is_a_card(browser: Any, tmp_path: Path, ulysse_findings: Findings) -> None:
    """No table is cut, each cell says what it is, and a filter hides rows as elsewhere."""
    tab, wrong = opened(browser, page(ulysse_findings), tmp_path)
    tab.set_viewport_size({"width": 360, "height": 800})
    cut = "all => all.filter(each => each.scrollWidth > each.clientWidth).map(each => each.textContent)"
    assert tab.eval_on_selector_all(".wide", cut) == []
    said = "all => all.map(each => JSON.parse(getComputedStyle(each, '::before').content))"
    assert tab.eval_on_selector_all("#rows2 tbody tr:first-child td", said) == [
        head.text_content() for head in tab.locator("#rows2 th").all()
    ]
    rows = tab.locator("#rows2 tbody tr")
    count = rows.count()
    tab.locator("#table2 input").fill("no row has this")
    assert [row.is_visible() for row in rows.all()] == [False] * count
    tab.locator("#table2 input").fill("")
    assert rows.first.is_visible()
    assert wrong == []


def test_keys_move_before_a_run_is_loaded(browser: Any, tmp_path: Path, ulysse_findings: Findings) -> None:
    file = tmp_path / "page.html"
    file.write_text(page(ulysse_findings))
    tab = browser.new_page()
    tab.goto(file.as_uri())
    assert tab.locator("#place").text_content() == "0 of 0"
    tab.keyboard.press("ArrowRight")
    first = str(tab.locator("#place").text_content())
    assert re.fullmatch(r"1 of [1-9][0-9]*", first)
    tab.keyboard.press("Home")
    assert tab.locator("#place").text_content() == first.replace("1", "0", 1)
    tab.close()


def test_a_page_is_the_same_byte_for_byte(tmp_path: Path) -> None:
    """By two processes with other seeds of hashes: no measured time, no order of a set."""
    made = []
    for seed in ("1", "2"):
        file = tmp_path / f"{seed}.html"
        environment = {**os.environ, "SOURCE_DATE_EPOCH": "1000000000", "PYTHONHASHSEED": seed}
        command = [sys.executable, "-m", "mcpn.cli", "report", str(ULYSSE), "-o", str(file)]
        subprocess.run(command, env=environment, check=True, capture_output=True)
        made.append(file.read_bytes())
    assert made[0] == made[1]


def test_a_page_does_not_fail_for_a_number(ulysse_findings: Findings) -> None:
    check = replace(ulysse_findings.check, stable_sizes=(1 << MOST_BITS, 10**6000))
    rows = tables(replace(ulysse_findings, check=check))[-1].rows
    said = {row[0]: row[1] for row in rows}
    assert said["event edges"] == "a number of some 6000 digits"
    assert "some 3010 digits" in said["stable states"]


SIGNED = """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
<hardware name="wheels"/><hardware name="arm"/><hardware name="radio" faulty="false"/><hardware name="spare"/>
<hardware name="sonar" detected="late"/>
<activity name="drive" consumes="wheels radio"/><activity name="look" consumes="sonar" detects="sonar"/>
<activity name="pick"><alternative name="by_arm" consumes="arm"/><alternative name="by_hand"/></activity>
<activity name="stop"/></robot>
<objective name="go" activities="drive" failure="halt"/>
<objective name="see" activities="look" failure="abort"/>
<objective name="take" activities="pick" success="succeed" failure="abort"/>
<objective name="halt" activities="stop" success="abort" failure="halt"/></mission>"""


def test_the_list_before_it_goes_has_what_no_proof_covers() -> None:
    text = page(findings(compose(read(SIGNED))))
    head, ticks = text.split('class="ticks"')
    ticks = ticks.split("</ul>")[0]
    assert "The loss of wheels, or of sonar before the start, not repaired, leaves no way to success." in head
    assert "whenever it comes, a safe end stays possible." in head
    assert "The loss of sonar is noticed late." in head
    assert "Test wheels and sonar." in ticks
    assert "Test sonar: its loss is noticed late." in ticks
    assert "Check that radio cannot fail." in ticks
    assert "Run each driver once" in ticks
    survived = re.search(r"What does it survive\?</dt>.*?</dd>", head, re.DOTALL)
    assert survived
    assert "arm" in survived[0]
    assert "spare" not in survived[0]
