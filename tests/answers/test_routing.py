"""What can never be entered, and what leads only to failure, with the cause, against all states."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.findings import findings
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.syntax import parse
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.report.page import page
from mcpn.spaces.engine_names import SPACE_ENGINES
from mcpn.testing import missions
from mcpn.testing.elements import GUARDED, PAUSING, PAUSING_APART, WORLD, WORLD_ABORTED
from tests.commands import mcpn
from tests.conftest import ROOT
from tests.draws import composed, fewer
from tests.shares import returns_early

ROBOT = """<robot name="r">
  <hardware name="motor"/>
  <hardware name="lidar"/>
  <software name="place"/>
  <activity name="drive" consumes="motor"/>
  <activity name="localise" produces="place" consumes="motor"/>
  <activity name="steer" consumes="motor place"/>
  <activity name="look" consumes="lidar"/>
  <activity name="wait"/>
</robot>
"""


def checked(folder: Path, blocks: str, engine: str = "auto") -> MissionCheck:
    path = folder / "mission.xml"
    path.write_text(f'<mission xmlns="urn:mcpn:mission:1" name="m">\n{ROBOT}{blocks}\n</mission>\n')
    return check(compose(read_mission(path)), engine=engine)  # type: ignore[arg-type]


AISLES = """
<objective name="turn" activities="steer" failure="home"/>
<objective name="aisle">
  <objective name="fly" activities="drive"/>
  <objective name="spray" activities="look"/>
</objective>
<objective name="report" activities="look"/>
<objective name="home" activities="wait" failure="home"/>
<objective name="apart" activities="wait"/>
"""
"""Steering takes the motor, and then has none for the position that it needs: turning can never succeed."""


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_a_block_that_is_never_entered_is_one_sentence(tmp_path: Path, engine: str) -> None:
    found = checked(tmp_path, AISLES, engine)
    assert found.failing == ["nominal_success"]  # though nothing fails, turning cannot succeed
    said = [problem.message for problem in found.unselectable]
    assert said == [
        "resource place is never used",
        "alternative localise.localise can never be selected: steer, which it serves, has motor already",
        "alternative steer.steer can never be selected",
        "objective turn can never succeed",
        "block aisle and objective report can never be entered: objective turn can never succeed",
    ]
    assert not found.futile


FUTILE = """
<objective name="ask" activities="drive" failure="home"/>
<objective name="rescue" activities="steer"/>
<objective name="home" activities="wait" success="succeed"/>
"""


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_success_that_leads_only_to_failure_is_told_with_its_cause(tmp_path: Path, engine: str) -> None:
    found = checked(tmp_path, FUTILE, engine)
    assert [problem.message for problem in found.futile] == [
        "objective ask leads only to failure by its success: objective rescue can never succeed"
    ]
    assert [problem.source.line for problem in found.futile if problem.source] == [13]


def test_success_is_no_cause_where_facts_leave_no_other_way_either(tmp_path: Path) -> None:
    """Routes lead from the failure of driving to success, and no state takes them."""
    blocks = """
    <objective name="ask" activities="drive" success="ask" failure="go"/>
    <objective name="go" activities="drive" success="fail">
      <route goto="succeed" when="done(rest)" on="failure"/>
    </objective>
    <objective name="rest" activities="wait" success="{leads}"/>
    """
    found = checked(tmp_path, blocks.format(leads="ask"))
    assert not found.verdicts["success_reachable"].holds
    assert not found.futile
    begins = '<objective name="first" activities="drive" success="ask" failure="rest"/>'
    assert [problem.message for problem in checked(tmp_path, begins + blocks.format(leads="ask")).futile] == [
        "objective go leads only to failure by its success: its success leads to fail"
    ]


def test_a_child_that_fails_last_leaves_its_block_to_succeed(tmp_path: Path) -> None:
    """The optional child can never succeed; its failure fails the block unless all others have ended."""
    found = checked(
        tmp_path,
        """
<objective name="ask" activities="drive" failure="home"/>
<parallel name="both" failure_when="1" success="succeed">
  <objective name="sit" activities="wait"/>
  <objective name="go" activities="steer" mandatory="false"/>
</parallel>
<objective name="home" activities="wait" success="succeed"/>
""",
    )
    assert not found.futile


def test_a_route_to_failure_is_its_own_cause(tmp_path: Path) -> None:
    blocks = '<objective name="ask" activities="drive" success="fail" failure="succeed"/>'
    assert [problem.message for problem in checked(tmp_path, blocks).futile] == [
        "objective ask leads only to failure by its success: its success leads to fail"
    ]


def test_strict_lets_warnings_fail(tmp_path: Path) -> None:
    unused = '<objective name="ask" activities="wait"/>'
    checked(tmp_path, unused)
    path = str(tmp_path / "mission.xml")
    assert mcpn("check", path).returncode == 0
    found = mcpn("check", path, "--strict")
    assert found.returncode == 1
    warned = checked(tmp_path, unused).warnings
    assert f"{len(warned)} warnings, and none is allowed (--strict)" in found.stdout
    ulysse = str(ROOT / "experiments" / "ulysse" / "mission.xml")
    assert mcpn("check", ulysse, "--strict").returncode == 0


AWAY = """
<on event="rain" goto="pack"/>
<parallel name="work" success="succeed">
  <on event="wind" pause="shelter"/>
  <objective name="map" activities="look"><on event="rain" goto="fail"/></objective>
</parallel>
<objective name="pack" activities="wait"/>
<parallel name="shelter" failure="succeed"><objective name="anchor" activities="drive"/></parallel>
"""


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("handler", "cause"),
    [
        ('<on event="rain" goto="work"/>', "event rain never happens while block work runs"),
        ('<on event="rain" goto="fail"/>', "event rain never happens while block work runs"),
    ],
)
def test_what_only_a_pause_would_lead_to_is_told_with_its_cause(
    tmp_path: Path, handler: str, cause: str, engine: str
) -> None:
    events = ROBOT.replace("</robot>", '<event name="rain"/><event name="wind"/></robot>')
    blocks = AWAY.replace('failure="succeed">', f'failure="succeed">{handler}')
    path = tmp_path / "mission.xml"
    path.write_text(f'<mission xmlns="urn:mcpn:mission:1" name="m">\n{events}{blocks}\n</mission>\n')
    found = check(compose(read_mission(path)), engine=engine)  # type: ignore[arg-type]
    said = [problem.message for problem in found.unselectable]
    assert f"objective pack can never be entered: {cause}" in said


def test_what_facts_alone_would_lead_to_is_told_with_its_cause(tmp_path: Path) -> None:
    blocks = """
    <objective name="ask" activities="wait"><route when="done(help)" goto="help"/></objective>
    <objective name="go" activities="drive" success="succeed"/>
    <objective name="help" activities="wait"/>
    """
    said = [problem.message for problem in checked(tmp_path, blocks).unselectable]
    told = "objective help can never be entered: the facts that objective ask asks for never hold there"
    assert told in said


def test_a_success_that_facts_lead_on_is_not_futile(tmp_path: Path) -> None:
    blocks = """
    <objective name="ask" activities="drive" failure="home"/>
    <objective name="home" activities="wait" success="fail" failure="home">
      <route when="done(ask)" goto="succeed"/>
    </objective>
    """
    assert not checked(tmp_path, blocks).futile


@fewer(0.5)
@given(PAUSING | PAUSING_APART)
def test_pauses_are_answered_whatever_they_lead_to(mission: Mission) -> None:
    """Verdicts, causes, the page and a controller of what pauses raise nothing but errors that say why."""
    with suppress(LimitError, SemanticsError):
        page(findings(composed(mission), max_states=500))


@given(missions() | WORLD | WORLD_ABORTED | GUARDED)
def test_what_is_told_is_so(mission: Mission) -> None:
    found_of = compose(mission)
    try:
        found = check(found_of, engine="explicit", max_states=20_000)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    space, names = found.alternatives, MissionNames(found_of)
    if space is None:
        returns_early("not confluent")
        return
    evaluation = Evaluation(space)
    told = [problem.message for problem in found.futile]
    copies = found_of.graph.copies
    for section in found_of.graph.sections:
        plain = copies.plain(section.name)
        if any(f"objective {of} lead" in m for of in (section.name, f"{plain} (all") for m in told):
            event = f"happens(OBJ_{section.name}_EV_OK)"
            assert evaluation.holds(parse(f"EF event(OBJ_{section.name}_EV_OK)", names))
            assert evaluation.holds(parse(f"A G ({event} -> X G !success)", names))
            assert evaluation.holds(parse(f"EF (objective({section.name}) & EF success)", names))
    entered = {name for place, name in found_of.saying("objective").items() if space.marked([place])}
    lost = [o.name for o in found_of.graph.walk() if o.name not in entered]
    said = [problem.message for problem in found.unselectable if "can never be entered" in problem.message]
    assert bool(lost) == any("no route reaches" not in message for message in said)
