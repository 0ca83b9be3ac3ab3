"""The questions of a safety engineer: each is answered with no for its own reason, by every engine."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given

from mcpn.answers.causes.find import find_causes
from mcpn.answers.claims import claims_of_losses
from mcpn.answers.safety import ASKED, SafetyAnswer, robot_safety
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.errors import InputError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import SPACE_ENGINES, Asked
from mcpn.testing import missions
from tests.commands import mcpn, output

ROOT = Path(__file__).parents[2]

ROBOT = """<hardware name="lamp" faulty="false"/><hardware name="wheels"/>
    <hardware name="camera" detected="late"/><event name="stop"/>
    <activity name="shine" consumes="lamp"/><activity name="drive" consumes="wheels"/>
    <activity name="look" consumes="camera"/><activity name="stand"/>"""
BLOCKS = {
    "ends_safely": """<on event="stop" goto="halt"/>
        <objective name="go" activities="stand" success="succeed" failure="fail"/>
        <objective name="halt" activities="stand" success="abort" failure="halt"/>""",
    "no_event_ignored": """<objective name="go" activities="stand" failure="go"/>
        <objective name="last" activities="stand" failure="last">
        </objective>""",
    "dark_after_stop": """<on event="stop" goto="halt"/>
        <objective name="go" activities="stand" success="succeed" failure="go"/>
        <objective name="halt" activities="shine" success="abort" failure="halt"/>""",
    "no_single_loss_endangers": """<on event="stop" goto="home"/>
        <objective name="go" activities="drive" success="succeed" failure="home"/>
        <objective name="home" activities="drive" success="abort" failure="home"/>""",
    "no_late_loss_endangers": """<on event="stop" goto="go"/>
        <objective name="go" activities="look" success="succeed" failure="go"/>""",
    "no_abort_by_failure": """<on event="stop" goto="halt"/>
        <objective name="go" activities="stand" success="succeed" failure="halt"/>
        <objective name="halt" activities="stand" success="abort" failure="abort"/>""",
    "succeeds_if_nothing_fails": """<on event="stop" goto="go"/>
        <objective name="go" activities="stand" success="go" failure="succeed"/>""",
}
"""By question, blocks of a mission in which it is answered with no."""
ALSO = {
    "no_event_ignored": ["dark_after_stop"],  # the stop is what is ignored
    "no_late_loss_endangers": ["no_single_loss_endangers"],  # it cannot abort, and the camera is lost alone
}
"""By question, which others the same mission answers with no."""


def mission_of(blocks: str) -> str:
    head = '<mission name="m" xmlns="urn:mcpn:mission:1">'
    return f'{head}<robot name="r">{ROBOT}</robot>{blocks}</mission>'


def asked(name: str, folder: Path, engine: Asked = "auto") -> dict[str, SafetyAnswer]:
    path = folder / "m.xml"
    path.write_text(mission_of(BLOCKS[name]))
    found = robot_safety(compose(read_mission(path)), dangerous=["shine"], stops=["stop"], engine=engine)
    assert [each.name for each in found] == list(ASKED)
    return {each.name: each for each in found}


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize("name", BLOCKS)
def test_each_question_is_answered_with_no_where_it_should_be(
    name: str, engine: Asked, tmp_path: Path
) -> None:
    found = asked(name, tmp_path, engine)
    assert found[name].holds is False
    assert found[name].why
    failing = {other for other, answer in found.items() if answer.holds is False}
    assert failing == {name, *ALSO.get(name, ())}


def test_a_stop_that_is_ignored_stops_nothing(tmp_path: Path) -> None:
    """In formulas it never happens, and all would be well after it."""
    path = tmp_path / "m.xml"
    path.write_text(mission_of('<objective name="go" activities="shine" failure="go"/>'))
    found = robot_safety(compose(read_mission(path)), dangerous=["shine"], stops=["stop"])
    (dark,) = [each for each in found if each.name == "dark_after_stop"]
    assert (dark.holds, dark.why) == (False, ("stop is ignored during go.",))


@pytest.mark.parametrize("after", ["light", "abort"])
def test_a_stop_that_is_answered_already_still_stops(after: str, tmp_path: Path) -> None:
    """``halt`` is entered by the stop, and in the ordinary way too: a stop that comes then leads nowhere."""
    path = tmp_path / "m.xml"
    blocks = f"""<objective name="go" activities="stand" success="halt" failure="halt">
        <on event="stop" goto="halt"/></objective>
        <objective name="halt" activities="stand" success="abort" failure="halt">
        <route when="done(go)" goto="{after}"/></objective>
        <objective name="light" activities="shine" success="succeed" failure="abort">
        <on event="stop" goto="abort"/></objective>"""
    path.write_text(mission_of(blocks))
    found = robot_safety(compose(read_mission(path)), dangerous=["shine"], stops=["stop"])
    said = {each.name: each for each in found}
    assert said["no_event_ignored"].holds
    dark = said["dark_after_stop"]
    if after == "light":
        assert (dark.holds, dark.why) == (False, ("shine may run after stop during halt",))
    else:
        assert dark.holds


def test_an_event_with_two_outcomes_is_not_answered(tmp_path: Path) -> None:
    """Two activities want one lamp; the questions that need states say that they are open."""
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="lamp"/>'
        '<activity name="a" consumes="lamp"/><activity name="b" consumes="lamp"/></robot>'
        '<objective name="go" activities="a b" success="abort"/></mission>'
    )
    found = {each.name: each for each in robot_safety(compose(read_mission(path)))}
    assert found["events_answered"].holds is False
    single = found["no_single_loss_endangers"]
    assert (single.holds, single.applies, single.is_open) == (None, True, True)
    assert single.why[0].startswith("not known: ")


def test_of_which_events_the_answer_speaks(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><event name="stop"/>'
        '<event name="leak"/><activity name="a"/></robot><on event="stop" goto="home"/>'
        '<objective name="go" activities="a"><on event="leak" goto="home"/></objective>'
        '<objective name="home" activities="a"/></mission>'
    )
    found = {each.name: each for each in robot_safety(compose(read_mission(path)))}
    answered = found["events_answered"]
    assert answered.holds
    assert answered.notes == (
        "Whatever runs, the mission handles stop.",
        "leak changes nothing during home, where it leads.",
    )


def test_a_mission_that_cannot_abort_is_safe_where_it_succeeds(tmp_path: Path) -> None:
    """``lamp`` is needed from the start; ``wheels`` only once the robot is called back."""
    path = tmp_path / "m.xml"
    path.write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="lamp"/>'
        '<hardware name="wheels" detected="late"/><hardware name="spare"/><event name="called"/>'
        '<activity name="shine" consumes="lamp"/><activity name="drive" consumes="wheels"/>'
        '<activity name="stand"/></robot>'
        '<objective name="go" activities="stand" failure="go"><on event="called" goto="back"/></objective>'
        '<objective name="look" activities="shine" success="succeed" failure="fail"/>'
        '<objective name="back" activities="drive" success="look" failure="fail"/></mission>'
    )
    found = {each.name: each for each in robot_safety(compose(read_mission(path)))}
    single = found["no_single_loss_endangers"]
    assert single.why == ("lamp alone", "wheels alone, at the worst moment")
    assert single.notes == ("the mission cannot be aborted: its only safe end is success",)
    assert single.run is not None
    assert "the loss of wheels alone leaves no safe end" in found["no_late_loss_endangers"].why
    assert found["ends_safely"].notes


WORKED = {
    "experiments/courier/mission.xml": (
        {"no_event_ignored", "no_single_loss_endangers"},
        ["drawer_lock", "radio", "wheels"],
    ),
    "experiments/drone/mission.xml": ({"no_event_ignored"}, []),
    "experiments/glider/mission.xml": (
        {"no_event_ignored", "no_single_loss_endangers"},
        ["satellite_radio"],
    ),
    "experiments/rover/mission.xml": ({"no_event_ignored"}, []),
    "experiments/ulysse/mission.xml": ({"no_single_loss_endangers"}, ["thruster_actuator"]),
    "tests/natural/auv.xml": ({"no_event_ignored", "no_late_loss_endangers"}, []),
    "tests/natural/guard.xml": ({"no_event_ignored"}, []),
}
"""By worked mission the questions that it answers with no, and what leaves no safe end alone."""


@pytest.mark.parametrize("file", WORKED)
def test_worked_missions(file: str) -> None:
    """Each no was read: what is meant by the mission stands in its text."""
    found = {each.name: each for each in robot_safety(compose(read_mission(ROOT / file)))}
    failing, alone = WORKED[file]
    assert {name for name, answer in found.items() if answer.is_open} == failing
    assert [line.split()[0] for line in found["no_single_loss_endangers"].why] == alone


@given(missions(late=True, aborts=1, events=2))
def test_they_say_what_check_and_causes_say(mission: Mission) -> None:
    net = compose(mission)
    found = {each.name: each.holds for each in robot_safety(net)}
    checked = check(net)
    safely = checked.verdicts.get("can_always_end_safely", checked.verdicts["can_always_finish"])
    assert found["ends_safely"] == safely.holds
    assert found["no_event_ignored"] == (not checked.ignored)
    late = found["no_late_loss_endangers"]
    assert found["succeeds_if_nothing_fails"] == checked.verdicts["nominal_success"].holds
    hardware = {each.name for each in mission.late}
    try:
        causes = find_causes(net)
    except SemanticsError:
        assert late is (None if hardware and not checked.late else False if hardware else None)
        return
    sets = [lost for of in (causes.safety or causes.mission).moments.values() for lost in of]
    # Asked without declared events as help, and after objectives that failed by themselves.
    if found["no_single_loss_endangers"]:
        assert not [lost for lost in sets if len(lost) < 2]
    kind = "loss_defeats" if causes.safety is None else "loss_endangers"
    alone = {c.subject for c in claims_of_losses(causes.prospects) if c.kind == kind and c.holds}
    endangering = [lost for lost in {*alone, *sets} if len(lost) == 1 and lost[0] in hardware]
    assert late is (None if not hardware else not (checked.late or endangering))


def test_names_are_looked_up_before_anything_is_explored(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{ROBOT}</robot>'
        f"{BLOCKS['ends_safely']}</mission>"
    )
    net = compose(read_mission(tmp_path / "m.xml"))
    with pytest.raises(InputError, match="no activity is named blaze"):
        robot_safety(net, dangerous=["blaze"])
    with pytest.raises(InputError, match="halt_now"):
        robot_safety(net, stops=["halt_now"])


def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(
        f'<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{ROBOT}</robot>'
        f"{BLOCKS['dark_after_stop']}</mission>"
    )
    options = ("--robot-safety", "--dangerous", "shine", "--stop", "stop")
    told = mcpn("ask", tmp_path / "m.xml", *options)
    assert told.returncode == 1
    assert "shine may run after stop" in told.stdout
    assert mcpn("ask", tmp_path / "m.xml", "--robot-safety").returncode == 0  # what does not apply is no no
    without = output("ask", tmp_path / "m.xml", "--robot-safety")
    assert {each["question"]: each["holds"] for each in without}["dark_after_stop"] is None
    assert {each["question"]: each["applies"] for each in without}["dark_after_stop"] is False
    assert mcpn("ask", tmp_path / "m.xml", "--dangerous", "shine").returncode == 2
    assert mcpn("ask", tmp_path / "m.xml", "--robot-safety", "EF success").returncode == 2


def test_a_loss_endangers_after_an_objective_that_fails_by_itself(tmp_path: Path) -> None:
    """The survey fails with all hardware in service; parked, the robot needs its anchor."""
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="camera"/>'
        '<hardware name="anchor"/><activity name="film" consumes="camera"/>'
        '<activity name="hold" consumes="anchor"/></robot>'
        '<objective name="survey" activities="film" success="succeed" failure="park"/>'
        '<objective name="park" activities="hold" success="abort" failure="park"/></mission>'
    )
    found = {each.name: each for each in robot_safety(compose(read_mission(tmp_path / "m.xml")))}
    single = found["no_single_loss_endangers"]
    assert single.holds is False
    assert single.why == ("anchor alone, at the worst moment",)
    assert single.run is not None
