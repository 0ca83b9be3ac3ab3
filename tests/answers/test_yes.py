"""What a yes means: five missions whose answers once reassured where they should not.

Each stands here in a form of its own, and is asked as it was found, too, where the folder of faults is named.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from tests.commands import mcpn, output

HEAD = """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">
  <hardware name="legs"/><hardware name="gripper"/><event name="{event}"/>
  <activity name="walk" consumes="legs"/><activity name="grasp" consumes="gripper"/><activity name="stand"/>
</robot>
"""
OWN = {
    "nominal_loop": """<objective name="harvest" success="succeed" failure="succeed">
      <objective name="pick" activities="grasp" failure="step"/>
      <objective name="step" activities="walk" success="pick"/></objective>""",
    "ignored_event": """<requirement name="answered">
      <response to="happens(gust)" gives="objective(crouch) | success | failure"/></requirement>
      <objective name="climb" activities="walk" failure="crouch"><on event="gust" goto="crouch"/></objective>
      <objective name="cross" activities="walk" failure="crouch"/>
      <objective name="crouch" activities="stand"/>""",
    "safe_by_word": """<objective name="work" failure="retreat" success="succeed">
      <on event="gust" goto="retreat"/><objective name="climb" activities="walk"/></objective>
      <objective name="retreat" activities="walk" success="abort" failure="abort"/>""",
    "pause_leads_out": """<objective name="work" success="succeed"><on event="gust" pause="hold"/>
      <objective name="climb" activities="walk"/></objective>
      <objective name="hold" activities="grasp" timeout="PT10M" timeout_goto="succeed"/>""",
    "after_event": """<requirement name="still">
      <absence of="activity(walk)" after="happens(gust)"/></requirement>
      <requirement name="still_too" formula="G (happens(gust) -&gt; X G !activity(walk))"/>
      <requirement name="stops"><response to="happens(gust)" gives="abort"/></requirement>
      <on event="gust" goto="halt"/>
      <objective name="climb" activities="walk" success="succeed"/>
      <objective name="halt" activities="stand" success="abort" failure="abort"/>""",
}


@pytest.fixture(params=["own", "found"])
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Where the five missions are: ours, or those that were found."""
    if request.param == "found":
        return Path(request.getfixturevalue("faults"))
    for name, blocks in OWN.items():
        (tmp_path / f"{name}.xml").write_text(f"{HEAD.format(event='gust')}{blocks}</mission>")
    return tmp_path


@cache
def checked(path: Path) -> MissionCheck:
    return check(compose(read_mission(path)))


def test_a_mission_that_goes_round_while_nothing_fails(folder: Path) -> None:
    path = folder / "nominal_loop.xml"
    found = checked(path)
    assert found.failing == ["nominal_success"]
    nominal = found.verdicts["nominal_success"]
    first, second = (objective for objective in found.mission_net.graph.sections)
    assert f"for ever: {first.name}, {second.name}, and so on" in nominal.explanation
    assert nominal.cycle is not None
    told = mcpn("check", "--strict", path)
    assert told.returncode == 1
    assert "on this run objective" in told.stdout  # the run to success says which objective fails on it
    assert "ends in success" not in mcpn("simulate", path, "--nominal").stdout


def test_an_event_that_is_ignored(folder: Path, tmp_path: Path) -> None:
    path = folder / "ignored_event.xml"
    found = checked(path)
    (ignored,) = found.ignored
    (event,) = found.mission_net.mission.events
    last, final = [section.name for section in found.mission_net.graph.sections][1:]
    assert (ignored.event, ignored.objectives) == (event.name, (last,))
    assert ignored.answering == (final,)
    assert found.passed
    told = " ".join(mcpn("check", path).stdout.split())
    assert f"{event.name} is ignored during {last}." in told
    assert f"{event.name} changes nothing during {final}, where it leads." in told
    assert f"is met, and says nothing of {event.name} where {event.name} is ignored." in told
    page = tmp_path / "page.html"
    assert mcpn("report", path, "-o", page).returncode == 0
    assert f"{event.name} is ignored during" in page.read_text()
    required = tmp_path / "required.xml"
    text = path.read_text()
    required.write_text(
        text.replace(f'<event name="{event.name}"', f'<event required="true" name="{event.name}"')
    )
    assert checked(required).failing == ["events_handled"]


def test_an_abort_by_the_failure_of_what_makes_safe(folder: Path, tmp_path: Path) -> None:
    path = folder / "safe_by_word.xml"
    found = checked(path)
    assert found.verdicts["abort_by_failure"].holds
    last = found.mission_net.graph.sections[-1].name
    assert last in found.verdicts["abort_by_failure"].explanation
    causes = Study(read_mission(path)).causes()
    (hardware,) = causes.safety.cut_sets  # type: ignore[union-attr]
    page = tmp_path / "page.html"
    assert found.failing == ["can_always_end_safely"]
    assert mcpn("report", path, "-o", page).returncode == 1
    text = " ".join(page.read_text().split())
    assert f"{hardware[0]}" in text
    assert f"by the failure of {last}, a safing objective" in text
    assert "Whatever hardware is lost" not in text
    answers = {each["question"]: each["holds"] for each in output("ask", path, "--robot-safety", code=1)}
    assert answers["no_abort_by_failure"] is False
    assert answers["no_single_loss_endangers"] is False


def test_a_pause_whose_time_is_over_leads_out(folder: Path) -> None:
    told = mcpn("check", folder / "pause_leads_out.xml")
    assert told.returncode == 0
    assert "and leads to succeed when its time is over" in told.stderr
    assert "does not go on then" in told.stderr
    assert mcpn("check", "--strict", folder / "pause_leads_out.xml").returncode == 1


def test_after_an_event_begins_with_the_reaction(folder: Path) -> None:
    absent, same, stops = checked(folder / "after_event.xml").requirements
    assert (absent.holds, same.holds, stops.holds) == (True, True, False)
    assert "from the reaction on" in absent.asked.sentence
    # Only runs on which the robot stands still for ever violate the last.
    assert 'fair="true"' in stops.advice


def test_a_pause_that_ends_by_its_own_handler_leads_out(tmp_path: Path) -> None:
    """The handler of the shelter ends the mission; one inside it ends the pause, and draws no warning."""
    night = (
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">'
        '<event name="dark"/><event name="dawn"/><activity name="drive"/><activity name="sleep"/></robot>'
        '<objective name="work" activities="drive" success="succeed">'
        '<on event="dark" pause="night"/></objective>'
        '<objective name="night">{}<objective name="doze" activities="sleep">{}</objective></objective>'
        "</mission>"
    )
    handler = '<on event="dawn" goto="succeed"/>'
    path = tmp_path / "night.xml"
    path.write_text(night.format(handler, ""))
    told = mcpn("check", path).stderr
    assert "night runs while work pauses, and by its event dawn succeeds, which ends the block around" in told
    path.write_text(night.format("", handler))
    assert "runs while" not in mcpn("check", path).stderr
