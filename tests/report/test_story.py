"""The first screen of a page, what it says that it is of, and rounds that are one row."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given

from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.findings import Findings, findings
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.report.page import EPOCH, digest_of, identity, page
from mcpn.report.pages.nominal_run import nominal_run
from mcpn.report.pages.preflight import preflight
from mcpn.report.pages.result_tables import fold_rows, tables
from mcpn.report.pages.story import headline, story, verdict_of_all
from mcpn.robot.runtime import Controller
from mcpn.testing import missions
from tests.commands import mcpn, output
from tests.conftest import ROOT, ULYSSE
from tests.small import activity, mission, robot

DRONE = ROOT / "experiments" / "drone" / "mission.xml"

MISSION = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="motor"/><hardware name="lamp"/>
    <activity name="go" consumes="motor"/><activity name="look" consumes="lamp"/></robot>
  {}
</mission>"""


def told(text: str, tmp_path: Path) -> tuple[Findings, dict[str, tuple[str, str]]]:
    """What is found of a mission, and the answers of its first screen by what they answer."""
    (tmp_path / "m.xml").write_text(MISSION.format(text))
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    every = [verdict_of_all(found.check), *story(found)]
    return found, {answer.asked: (answer.state, answer.said) for answer in every}


def test_a_mission_that_may_fly(tmp_path: Path) -> None:
    _, said = told('<objective name="a" activities="go"/>', tmp_path)
    stated = "the mission states no requirements of its own"
    assert said["May it go?"] == ("holds", f"Yes. All required verdicts hold; {stated}.")
    assert said["Can it succeed?"][0] == "holds"
    assert said["What endangers the robot?"][1].startswith("The mission has no abort, so that nothing")
    assert "What is taken for granted?" not in said
    defeats = "The loss of motor before the start, not repaired, leaves no way to success."
    assert said["What defeats it?"][1] == defeats
    assert said["What must hold?"][1] == "The mission states no requirements of its own."
    assert said["What can never run?"][0] == "note"
    assert "lamp" not in said["What defeats it?"][1]


def test_a_requirement_that_is_violated(tmp_path: Path) -> None:
    required = (
        '<requirement name="never_done" description="It never ends"><absence of="success"/></requirement>'
    )
    _, said = told(f'{required}<objective name="a" activities="go"/>', tmp_path)
    assert said["May it go?"] == ("fails", "No. It does not meet what it requires: never_done.")
    assert said["What must hold?"] == (
        "fails",
        "0 of 1 requirements are met; violated: 'It never ends'.",
    )


@pytest.mark.parametrize(
    ("severities", "answer"),
    [
        (("advice",), "; 1 advised requirement is not met"),
        (("advice", "advice"), "; 2 advised requirements are not met"),
        (("required", "advice"), "; it meets all that it requires; 1 advised requirement is not met"),
        (("required",), "; it meets all that it requires"),
    ],
)
def test_a_yes_says_what_it_leaves_open(severities: tuple[str, ...], answer: str, tmp_path: Path) -> None:
    """What is required holds here, and what is advised does not."""
    absent = {"required": "deadlock &amp; !success &amp; !failure", "advice": "success"}
    stated = "".join(
        f'<requirement name="r{i}" severity="{of}"><absence of="{absent[of]}"/></requirement>'
        for i, of in enumerate(severities)
    )
    _, said = told(f'{stated}<objective name="a" activities="go"/>', tmp_path)
    assert said["May it go?"] == ("holds", f"Yes. All required verdicts hold{answer}.")


@pytest.mark.parametrize(("undecided", "unanswered"), [(2, 0), (0, 1), (2, 1)])
def test_what_is_not_proved_is_counted(undecided: int, unanswered: int) -> None:
    """Verdicts and requirements without an answer, together."""
    open_ones = {"undecided": ("v",) * undecided, "unanswered": ("r",) * unanswered}
    line = verdict_of_all(cast("Any", SimpleNamespace(failing=(), violated=(), passed=False, **open_ones)))
    assert line.state == "unknown"
    assert line.said == f"Not proved. {undecided + unanswered} of its questions have no answer."


def test_hardware_that_never_fails_is_taken_for_granted(tmp_path: Path) -> None:
    text = MISSION.replace('<hardware name="lamp"/>', '<hardware name="lamp" faulty="false"/>')
    (tmp_path / "m.xml").write_text(text.format('<objective name="a" activities="go look"/>'))
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    answer = next(a for a in story(found) if a.asked == "What is taken for granted?")
    assert answer.said == "That these never fail, as the mission says of them: lamp."


def test_an_end_that_is_not_safe_is_no_safe_end(tmp_path: Path) -> None:
    """A mission that no loss of hardware endangers, and that fails where its first objective does."""
    text = """<objective name="a" activities="wait"/>
      <objective name="b" activities="look" failure="abort"/>"""
    (tmp_path / "m.xml").write_text(
        MISSION.format(text).replace("</robot>", '<activity name="wait"/></robot>')
    )
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    assert verdict_of_all(found.check).state == "fails"
    answer = next(a for a in story(found) if a.asked == "What endangers the robot?")
    assert answer.state == "fails"
    assert answer.said == (
        "The mission can reach a state from which it can end neither in success nor in a safe abort."
    )
    assert list(answer.chips) == ["a", "failure"]


LEAK = """<mission name="auv" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="thrusters"/><event name="leak"/><event name="call"/>
    <activity name="swim" consumes="thrusters"/></robot>
  <requirement name="up_after_leak"><response to="happens(leak)" gives="objective(up)"/></requirement>
  <objective name="dive" activities="swim" failure="up"><on event="leak" goto="up"/></objective>
  <objective name="work" activities="swim" failure="up" success="succeed">
    <on event="call" goto="up"/></objective>
  <objective name="up" activities="swim" success="abort" failure="abort"/>
</mission>"""


def test_what_reassures_where_it_should_not_stands_first(tmp_path: Path) -> None:
    """Ignored events, an abort that is safe by word alone: first screen, headline, list before it goes."""
    (tmp_path / "m.xml").write_text(LEAK)
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    said = {answer.asked: (answer.state, answer.said) for answer in [headline(found), *story(found)]}
    # An abort by the failure of a safing objective is no safe end: up may only fail.
    state, go = said["May it go?"]
    assert state == "fails"
    assert "can end neither in success nor in a safe abort" in go
    state, endangers = said["What endangers the robot?"]
    assert (state, "no way to a safe end" in endangers, "thrusters" in endangers) == ("note", True, True)
    assert said["Is every abort safe?"][0] == "fails"
    assert said["What is ignored?"] == (
        "note",
        "leak is ignored during work. call is ignored during dive.",
    )
    ticks = [tick.what for tick in preflight(found)]
    assert {"Test thrusters.", "Test up.", "Accept this: leak is ignored during work."} <= {*ticks}
    text = page(found)
    assert "is met, and says nothing of leak where leak is ignored." in text


PHOTO = """<mission name="photo" xmlns="urn:mcpn:mission:1">
  <robot name="drone"><hardware name="camera" detected="late"/><hardware name="sonar"/>
    <activity name="look"><alternative name="by_eye" consumes="camera"/>
      <alternative name="by_ear" consumes="sonar"/></activity>
    <activity name="test" detects="camera"/></robot>
  <objective name="watched" activities="look test"/>
  <objective name="search" activities="look"/>
</mission>"""


def test_losses_that_nobody_notices_stand_first(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(PHOTO)
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    (answer,) = (answer for answer in story(found) if answer.asked == "What goes unnoticed?")
    assert answer.said == (
        "Nothing notices the loss of camera during search, which can then no longer succeed. After the loss "
        "of camera, watched can succeed only if the loss is found in time."
    )
    assert headline(found).said.endswith("The loss of camera is noticed late.")
    (tick,) = (tick for tick in preflight(found) if "noticed late" in tick.what)
    assert "during search, which can then no longer succeed" in tick.why


def test_what_is_not_confluent_is_not_proved() -> None:
    found = findings(compose(read_mission(ROOT / "tests" / "natural" / "inspection.xml")))
    every = {answer.asked: answer for answer in [verdict_of_all(found.check), *story(found)]}
    assert every["May it go?"].said.startswith("No. The reaction to an event depends on chance")
    assert every["What is not proved?"].state == "unknown"
    assert not every["Can it succeed?"].chips
    page(found)


@given(missions(max_objectives=4))
def test_the_run_without_failures_is_one(mission: Mission) -> None:
    """It ends in success; nothing in it fails; where there is none, some success leads away from success."""
    found = findings(compose(mission))
    events = nominal_run(found)
    if events is None:
        return
    assert found.controller is not None
    assert events[0] == "MISSION_EV_START"
    assert all(event.startswith("OBJ_") and event.endswith("_EV_OK") for event in events[1:])
    runtime = Controller.from_document(found.controller)
    for event in events:
        runtime.handle(event)
    assert runtime.outcome == "success"
    assert found.check.verdicts["success_reachable"].holds


def test_what_a_page_says_that_it_is_of(monkeypatch: pytest.MonkeyPatch, ulysse_findings: Findings) -> None:
    monkeypatch.setenv(EPOCH, "86400")
    said = {what: (value, more) for what, value, more in identity(ulysse_findings)}
    assert said["made"][0].startswith("1970-01-02 00:00 UTC by mcpn ")
    files = [ULYSSE, ULYSSE.parent / "robot.xml", ULYSSE.parent / "protocols.xml"]
    digest = hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()
    assert said["sources"][0] == f"SHA-256 {digest[:16]} of mission.xml, robot.xml, protocols.xml"
    assert said["sources"][1].startswith(digest)
    assert said["engine"][0] == "explicit"
    assert said["proof"][0]
    assert page(ulysse_findings) == page(ulysse_findings)  # the same, byte by byte
    monkeypatch.setenv(EPOCH, "yesterday")
    with pytest.raises(InputError, match="expected seconds since 1970"):
        page(ulysse_findings)


def test_a_wrong_date_is_an_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(EPOCH, "1e9")
    done = mcpn("report", ULYSSE, "-o", tmp_path / "u.html")
    assert done.returncode == 2
    assert EPOCH in done.stderr
    assert not (tmp_path / "u.html").exists()


def test_a_mission_of_no_file_has_no_sources() -> None:
    mission = replace(read_mission(ULYSSE), source=None, robots=(), protocols=(), requirements=(), blocks=())
    assert digest_of(mission) == ("", [])


def test_rounds_that_say_the_same_are_one_row() -> None:
    found = findings(compose(read_mission(DRONE)))
    by_name = {table.name.split(":")[0]: table for table in tables(found)}
    assert found.fmeca is not None
    rows = by_name["FMECA"].rows
    assert len(rows) < len(found.fmeca)
    counted = 0
    for hardware, objectives, *_ in rows:
        several = [(int(n[1]), n[2]) for n in re.finditer(r"[(]all (\d+)(?: but ([^)]*))?[)]", objectives)]
        named = re.sub(r" [(]all [^)]*[)]", "", objectives).split(", ")
        told = len(named) + sum(n - 1 - (len(but.split(", ")) if but else 0) for n, but in several)
        counted += len(hardware.split(", ")) * told
    changing = [row for row in found.fmeca if row.local_effect != "none" or row.with_others]
    assert counted == len(changing)  # each is told once
    assert any("stock.leave (all 3)" in row[0] for row in by_name["What happens when hardware fails"].rows)
    for table in tables(found):
        assert table.reading.endswith(".")


def test_a_row_of_modes_names_a_dozen_objectives() -> None:
    """Of hundreds that run in the same ways each mode would list all of them again."""
    of = mission(
        robot((), activity("go", ())), *(Objective(name=f"leg{n}", activities=("go",)) for n in range(15))
    )
    by_name = {table.name: table for table in tables(findings(compose(of)))}
    ((objectives, number, ways),) = by_name["Functioning modes"].rows
    assert objectives == ", ".join(f"leg{n}" for n in range(12)) + " and 3 more"
    assert (number, ways) == ("1", "as written")


def test_rounds_that_differ_stay_apart() -> None:
    drone = compose(read_mission(DRONE))
    rows = [("stock_A1.leave", "no way"), ("stock_A2.leave", "no way"), ("stock_B1.leave", "")]
    assert fold_rows(drone, rows) == rows
    own = [(f"stock_{a}.leave", f"then stock_{a}.wait; mission lost") for a in ("A1", "A2", "B1")]
    assert fold_rows(drone, own) == [("stock.leave (all 3)", "then stock.wait; mission lost")]
    hospital = compose(read_mission(ROOT / "tests" / "natural" / "hospital.xml"))
    tries = [(f"dock_try{n}", "the next try" if n < 6 else "leads to park") for n in range(1, 7)]
    assert fold_rows(hospital, tries) == [("dock (all 6 but dock_try6)", "the next try"), tries[-1]]


def test_what_is_lost_where_a_mission_goes_on_is_told(tmp_path: Path) -> None:
    """Where a route leads on, an objective that can never succeed does not keep the mission from success."""
    path = tmp_path / "mission.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="camera"/>'
        '<hardware name="motor"/><activity name="film" consumes="camera"/><activity name="move">'
        '<alternative name="by_motor" consumes="motor"/><alternative name="drift"/></activity></robot>'
        '<objective name="filming" activities="film" failure="moving"/>'
        '<objective name="moving" activities="move"/></mission>'
    )
    lines = {line.asked: line for line in story(findings(compose(read_mission(path))))}
    assert lines["What does it survive?"].said.startswith(
        "After the loss of any one of camera and motor alone"
    )
    lost = lines["What is lost then?"]
    assert lost.state == "note"
    assert lost.said == "What has not begun cannot succeed then: without camera, filming."


def test_what_defeats_it_at_the_worst_moment_alone_is_told(tmp_path: Path) -> None:
    """Once it is called back it needs the radio; the lamp it does not, as long as it may be called back."""
    path = tmp_path / "mission.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="radio"/>'
        '<hardware name="lamp"/><event name="called"/><activity name="shine" consumes="lamp"/>'
        '<activity name="answer" consumes="radio"/></robot>'
        '<objective name="look" activities="shine" success="succeed" failure="abort">'
        '<on event="called" goto="say"/></objective>'
        '<objective name="say" activities="answer" success="succeed" failure="say"/></mission>'
    )
    found = findings(compose(read_mission(path)))
    said = headline(found).said
    worst = "The loss of radio alone, at its worst moment, leaves no way to success."
    before = "The loss of lamp before the start, not repaired, leaves no way to success"
    alone = f"{before} without the help of called."
    assert said.count(worst) == said.count(alone) == 1
    assert "The loss of radio alone, at its worst moment, leaves no safe end." in said
    lines = {line.asked: line for line in story(found)}
    assert lines["What defeats it?"].said.endswith(f"{worst} {alone}")
    endangers = "The loss of radio alone, at its worst moment, leaves no safe end."
    assert lines["What endangers the robot?"].said == endangers
    assert "What does it survive?" not in lines
    (ticked,) = [tick for tick in preflight(found) if "radio" in tick.what]
    assert ticked.why == endangers


def test_equal_rows_of_one_objective_are_no_copies(tmp_path: Path) -> None:
    """Two edges of one event in states that differ in nothing that the table names are one row."""
    found, _ = told('<objective name="a" activities="go"/>', tmp_path)
    net = found.check.mission_net
    assert fold_rows(net, [("a", "fails"), ("a", "fails")]) == [("a", "fails")]


WAYS = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="motor"{}/>
    <activity name="go"><alternative name="a"{}/><alternative name="b"/></activity></robot>
  <objective name="a" activities="go"/>
</mission>"""
SPARED = {
    "used, with a way that does without": (("", ' consumes="motor"'), "Whatever hardware is lost beforehand"),
    "that nothing uses": (("", ""), "No hardware that may fail is used."),
    "that cannot fail": ((' faulty="false"', ' consumes="motor"'), "No hardware that may fail is used."),
}


@pytest.mark.parametrize("hardware", SPARED)
def test_what_is_said_where_no_loss_defeats(hardware: str, tmp_path: Path) -> None:
    parts, begins = SPARED[hardware]
    (tmp_path / "m.xml").write_text(WAYS.format(*parts))
    found = findings(compose(read_mission(tmp_path / "m.xml")))
    assert {line.asked: line for line in story(found)}["What defeats it?"].said.startswith(begins)
    printed = mcpn("causes", tmp_path / "m.xml").stdout
    condition = output("causes", tmp_path / "m.xml")["mission"]["condition"]
    kept = "After the loss of motor alone, whenever it comes, success stays possible."
    told = kept if begins.startswith("Whatever") else begins
    assert printed.splitlines()[0] == condition == told
    assert ("what the mission survives" in printed) is (parts[0] == "")
