"""Recipes of the language page do what they say, and what does not is told."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.answers.verdicts.mission import MissionCheck, check
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.xml import read_mission
from mcpn.study import Study

HEAD = """<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="auv">
  <hardware name="motor"/><hardware name="watch"/>
  <event name="ship"/><event name="dose_reached"/>
  <activity name="swim" consumes="motor"/><activity name="guard" consumes="watch"/>
  <activity name="hover"/></robot>
"""


def of(folder: Path, blocks: str) -> Study:
    path = folder / "m.xml"
    path.write_text(f"{HEAD}{blocks}</mission>")
    return Study(read_mission(path))


def holds(study: Study, formula: str, *, fair: bool = False) -> bool:
    return study.ctl(formula, fair=["progress"] if fair else []).holds


PAUSE = """<objective name="survey" success="succeed"><on event="ship" pause="deep"/>
  <objective name="line" activities="swim"/></objective>"""


def test_a_wait_in_a_pause_goes_on(tmp_path: Path) -> None:
    inside = '<objective name="deep"><objective name="wait" activities="hover" timeout="600" {}/></objective>'
    found = of(tmp_path, PAUSE + inside.format('timeout_goto="succeed"'))
    name = next(s.name for s in found.mission_net.graph.walk() if "wait" in s.name)
    over = f"happens(OBJ_{name}_EV_TIMEOUT)"
    assert holds(found, f"G ({over} -> X objective(line))")
    assert not [w for w in find_warnings(found.mission_net.mission) if "does not go on" in w.message]


def test_a_sibling_that_leads_out_when_its_time_is_over_is_told(tmp_path: Path) -> None:
    apart = '<objective name="deep" activities="hover" timeout="600" timeout_goto="succeed"/>'
    found = of(tmp_path, PAUSE + apart)
    told = [str(problem) for problem in find_warnings(found.mission_net.mission)]
    assert [w for w in told if "deep runs while survey pauses, and leads to succeed" in w]
    away = replace_timeout(apart)
    quiet = find_warnings(of(tmp_path, PAUSE + away).mission_net.mission)
    assert not [w for w in quiet if "does not go on" in w.message]


def test_an_abort_without_effect_is_told_once_for_all_copies_and_of_no_failure_that_nothing_takes(
    tmp_path: Path,
) -> None:
    inside = '<objective name="line" activities="swim"/>'
    vain = f'<objective name="way" abort="home" retries="2">{inside}</objective>'
    home = '<objective name="home" activities="swim"/>'
    held = f'<each name="site" in="a b">{vain}{home}</each>'
    told = [problem.message for problem in find_warnings(of(tmp_path, held).mission_net.mission)]
    assert [text for text in told if "abort" in text] == ["abort of way has no effect: nothing in it aborts"]
    # What runs in a pause fails as the block that pauses does, whatever its own failure leads to.
    for failure, number in (('failure="abort"', 1), ('abort="abort" timeout="9" timeout_goto="abort"', 0)):
        deep = f'<objective name="deep" activities="hover" {failure}/>'
        held = f'<objective name="way" abort="home">{PAUSE}{deep}</objective>{home}'
        told = [problem.message for problem in find_warnings(of(tmp_path, held).mission_net.mission)]
        assert len([text for text in told if text.startswith("abort of way has no effect")]) == number


def replace_timeout(block: str) -> str:
    return block.replace(' timeout_goto="succeed"', "")


def test_a_guard_that_is_lost_stops_the_work(tmp_path: Path) -> None:
    found = of(tmp_path, '<objective name="work" activities="swim guard"/>')
    assert holds(found, "AG (refused(guard) -> !event(OBJ_work_EV_OK))")


def test_a_final_state_that_nobody_interrupts(tmp_path: Path) -> None:
    blocks = """<objective name="work" success="last" failure="last"><on event="ship" goto="last"/>
      <objective name="line" activities="swim"/></objective>
      <objective name="last" activities="hover" failure="last"/>"""
    found = of(tmp_path, blocks)
    assert holds(found, "AG (objective(last) -> !event(ship))")
    assert holds(found, "AG !failure")  # what must not give up is tried again
    assert holds(found, "G (objective(line) -> F (objective(last) | !objective(line)))", fair=True)


def test_what_a_driver_counts_ends_the_work_in_a_pause_too(tmp_path: Path) -> None:
    blocks = """<objective name="all" success="succeed" failure="rest"><on event="dose_reached" goto="rest"/>
      <objective name="survey" success="succeed"><on event="ship" pause="deep"/>
      <objective name="line" activities="swim"/></objective><objective name="deep" activities="hover"/>
      </objective><objective name="rest" activities="hover"/>"""
    found = of(tmp_path, blocks)
    assert holds(found, "G (happens(dose_reached) -> X objective(rest))")
    assert holds(found, "EF (objective(deep) & event(dose_reached))")


def test_a_block_is_asked_for_as_a_block(tmp_path: Path) -> None:
    found = of(tmp_path, PAUSE + '<objective name="deep" activities="hover"/>')
    with pytest.raises(InputError, match=r"survey holds blocks: expected block\(survey\)"):
        found.ctl("EF objective(survey)")
    assert found.ctl("EF block(survey)").holds


def checked(folder: Path, blocks: str) -> MissionCheck:
    return check(compose(of(folder, blocks).mission_net.mission))


def test_an_event_that_pulls_out_is_named(tmp_path: Path) -> None:
    blocks = """<objective name="work" activities="swim" success="succeed" failure="halt"/>
      <objective name="halt" activities="hover" success="abort" failure="halt">
      <on event="ship" goto="work"/></objective>"""
    said = [problem.message for problem in checked(tmp_path, blocks).futile]
    assert said == [
        "objective halt leads only to abort by its success: its success leads to abort "
        "(ship may interrupt it before)"
    ]


def test_a_loop_that_waits_for_an_event_says_so(tmp_path: Path) -> None:
    """The door is opened by an event alone: the author forgot no route."""
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="wheels"/>'
        '<fact name="door" values="closed open" initial="closed"/>'
        '<event name="opens"><sets fact="door" to="open"/></event>'
        '<activity name="drive" consumes="wheels"/><activity name="rest"/></robot>'
        '<objective name="wait" activities="rest" success="go" failure="go"/>'
        '<objective name="go" activities="drive" success="succeed"><enter when="door=open" else="wait"/>'
        "</objective></mission>"
    )
    said = check(compose(read_mission(tmp_path / "m.xml"))).verdicts["nominal_success"].explanation
    assert "goes on for ever: wait, and so on; it ends where opens happens" in said
    assert 'nominal="endless"' in said
    assert "success leads to the next block" not in said
