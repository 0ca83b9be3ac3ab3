"""Verdicts, their runs, and functioning modes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.verdicts.mission import INFORMATIVE, REQUIRED, MissionCheck, check
from mcpn.answers.verdicts.modes import functioning_modes
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError
from mcpn.events import Event, What
from mcpn.logic.formulas import EU
from mcpn.logic.syntax import parse
from mcpn.mission.model import SUCCEED, Block, Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking
from mcpn.report.words import in_words
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.search.goal import FALSE, TRUE
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.drawing.settling import stabilise
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


@pytest.fixture(scope="module")
def ulysse_check(ulysse_net: MissionNet) -> MissionCheck:
    return check(ulysse_net)


ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def small(*blocks: Block) -> Mission:
    of = robot(hw("H"), activity("use", ("H",)), activity("also", ("H",)), activity("free", ()))
    return mission(of, *blocks)


def play(found: MissionNet, events: list[str]) -> Marking:
    """The stable marking after some events, by the net's own rule; one transition fires on each."""
    net = found.net
    marking = stabilise(net, net.initial)
    for event in events:
        (fired,) = [t for t in net.enabled(marking) if net.transitions[t].event == Event.parse(event)]
        marking = stabilise(net, net.fire(marking, fired))
    return marking


def test_ulysse_holds_all_that_is_required(ulysse_check: MissionCheck) -> None:
    assert ulysse_check.passed
    holds = {name: verdict.holds for name, verdict in ulysse_check.verdicts.items()}
    assert holds == {**dict.fromkeys(REQUIRED, True), "failure_reachable": True, "unselectable": False}
    assert list(holds) == [*REQUIRED, *INFORMATIVE]


def test_ulysse_runs_are_shortest_and_lead_where_they_say(ulysse_check: MissionCheck) -> None:
    found = ulysse_check.mission_net
    # Start, leave the coral head, fail to dive, go up: nothing shorter leads to an end. Success
    # is shown without failures: start, the two objectives of the coral head, dive, three at once, go up.
    for name, place, events in (
        ("success_reachable", found.success, 8),
        ("failure_reachable", found.failure, 4),
    ):
        (run,) = ulysse_check.verdicts[name].runs
        assert play(found, list(map(str, run.events)))[place]
        assert len(run.events) == events
    (run,) = ulysse_check.verdicts["success_reachable"].runs
    assert {event.what for event in run.events} == {What.START, What.SUCCESS}


def test_runs_are_told_in_mission_words(ulysse_check: MissionCheck) -> None:
    (run,) = ulysse_check.verdicts["success_reachable"].runs
    words = [words for _, words in in_words(ulysse_check.mission_net, run)]
    assert words[0] == (
        "mission ulysse starts: coral_head.manual_moving begins, localisation runs as gps_localisation"
    )
    assert words[-1].endswith("the mission ends in success")


def test_ulysse_functioning_modes(ulysse_check: MissionCheck) -> None:
    # The paper, 4.3: an objective that needs the location has two modes, by GPS and by IMU.
    modes = ulysse_check.modes
    for name in ("coral_head.manual_moving", "transect.diving", "transect.advancing", "transect.going_up"):
        assert [mode["localisation"] for mode in modes[name]] == ["gps_localisation", "imu_localisation"]
        assert [set(mode) & {"gps_driver", "imu_driver"} for mode in modes[name]] == [
            {"gps_driver"},
            {"imu_driver"},
        ]
    assert modes["transect.filming"] == [{"filming": "filming"}]


@given(missions(max_objectives=2, max_depth=1))
def test_modes_are_those_of_the_stable_markings(mission: Mission) -> None:
    found = compose(mission)
    try:
        graph = direct(found.net, proof=False, max_states=2000)
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    index = found.net.place_index
    modes = functioning_modes(found, ArraySpace(graph))
    for section in found.graph.walk():
        seen = set()
        closure = {b for a in section.activities for b in found.usage.closure(a)}
        for state in range(graph.states):
            marking = graph.marking(state)
            if marking[index[f"OBJ_{section.name}"]]:
                mode = {
                    (a.name, alternative.name)
                    for a in mission.activities
                    if a.name in closure
                    for i, alternative in enumerate(a.alternatives)
                    if marking[index[f"{a.name}_active{i + 1}"]]
                }
                if set(section.activities) <= {a for a, _ in mode}:
                    seen.add(frozenset(mode))
        assert {frozenset(mode.items()) for mode in modes[section.name]} == seen
        ways = {a.name: [way.name for way in a.alternatives] for a in mission.activities}
        own = [[ways[a].index(mode[a]) for a in section.activities] for mode in modes[section.name]]
        assert own == sorted(own)  # the preferred ones first


def test_modes_stand_in_the_order_of_priority() -> None:
    """Whatever the document's order of activities: what consumes counts before what it consumes."""
    robot = Robot(
        name="r",
        hardware=tuple(Hardware(name=name) for name in ("camera", "sonar", "usbl")),
        software=(Software(name="image"), Software(name="echo"), Software(name="dock")),
        activities=(
            Activity(
                name="see", produces=("image",), alternatives=(Alternative(name="see", consumes=("camera",)),)
            ),
            Activity(
                name="hear", produces=("echo",), alternatives=(Alternative(name="hear", consumes=("sonar",)),)
            ),
            Activity(
                name="locate",
                produces=("dock",),
                alternatives=tuple(
                    Alternative(name=f"by_{way}", consumes=(way,)) for way in ("usbl", "image", "echo")
                ),
            ),
            Activity(
                name="enter",
                alternatives=(Alternative(name="guided", consumes=("dock",)), Alternative(name="blind")),
            ),
        ),
    )
    mission = Mission(name="m", robots=(robot,), blocks=(Objective(name="x", activities=("enter",)),))
    ways = [(m["enter"], m.get("locate")) for m in check(compose(mission)).modes["x"]]
    assert ways == [("guided", "by_usbl"), ("guided", "by_image"), ("guided", "by_echo"), ("blind", None)]


def test_contention_fails_confluence_with_two_runs_and_words() -> None:
    found = check(
        compose(
            small(
                Parallel(
                    name="both",
                    blocks=(
                        Objective(name="x", activities=("use",)),
                        Objective(name="y", activities=("also",)),
                    ),
                )
            )
        )
    )
    verdict = found.verdicts["confluent"]
    assert verdict.holds is False
    assert len(verdict.runs) == 2
    assert (
        "also (objective y) and use (objective x), both in parallel block both, ask for H"
        in verdict.explanation
    )
    assert not found.passed
    assert found.alternatives is None
    assert found.verdicts["can_always_finish"].holds is True  # decided on the markings graph


def test_a_mission_that_loops_for_ever_cannot_finish() -> None:
    found = check(compose(small(Objective(name="x", activities=("use",), success="x", failure="x"))))
    assert found.verdicts["success_reachable"].holds is False
    assert found.verdicts["can_always_finish"].holds is False
    (run,) = found.verdicts["can_always_finish"].runs
    assert run.events == []  # from the start
    assert found.verdicts["failure_reachable"].holds is False
    assert found.verdicts["deadlock_free"].holds is True
    assert not found.passed


def test_a_trap_on_the_way_is_shown_by_its_shortest_run() -> None:
    found = check(
        compose(
            small(
                Objective(name="x", activities=("free",), success=SUCCEED, failure="y"),
                Objective(name="y", activities=("free",), success="y", failure="y"),
            )
        )
    )
    assert found.verdicts["success_reachable"].holds is True
    (run,) = found.verdicts["can_always_finish"].runs
    assert list(map(str, run.events)) == ["MISSION_EV_START", "OBJ_x_EV_FAIL"]


def test_what_can_never_be_selected_is_found() -> None:
    robot = Robot(
        name="r",
        hardware=(Hardware(name="H", faulty=False), Hardware(name="spare")),
        activities=(
            Activity(
                name="a",
                alternatives=(
                    Alternative(name="first", consumes=("H",)),
                    Alternative(name="second", consumes=("spare",)),
                ),
            ),
        ),
    )
    mission = Mission(name="m", robots=(robot,), blocks=(Objective(name="x", activities=("a",)),))
    found = check(compose(mission))
    assert found.passed
    assert found.verdicts["unselectable"].holds is True
    assert [p.message for p in found.unselectable] == [
        "alternative a.second can never be selected",
        "resource spare is never used",
    ]


def test_an_unsafe_net_leaves_the_rest_unknown(ulysse_net: MissionNet) -> None:
    # The reference net is known not to be 1-safe without its priorities.
    net = replace(ulysse_net.net, priorities=False)
    found = check(replace(ulysse_net, net=net))
    assert found.verdicts["safe"].holds is False
    assert found.verdicts["bounded"].holds is None
    assert len(found.verdicts["safe"].runs) == 1
    assert not found.passed


def test_what_no_route_reaches_is_told_with_its_line(tmp_path: Path) -> None:
    text = (
        '<mission name="m" xmlns="urn:mcpn:mission:1">\n'
        '<robot name="r"><hardware name="H"/><activity name="look" consumes="H"/>\n'
        '<activity name="surface"/></robot>\n'
        '<objective name="survey" success="succeed" failure="backup">\n'
        '<objective name="look" activities="look" failure="succeed"/></objective>\n'
        '<parallel name="both">\n<objective name="backup" activities="surface"/></parallel>\n'
        "</mission>"
    )
    path = tmp_path / "m.xml"
    path.write_text(text.replace('"backup">', '"both">'))
    found = compose(read_mission(path))
    for engine in ENGINES:
        checked = check(found, engine=engine)
        assert checked.passed  # a warning, as for everything unselectable
        assert checked.verdicts["unselectable"].holds is True
        assert [(p.source and p.source.line, p.message) for p in checked.unselectable] == [
            (7, "objective backup can never be entered: no route reaches it"),
        ]
    assert [(p.source and p.source.line, p.message) for p in find_warnings(found.mission)] == [
        (3, "activity surface is never started"),
        (7, "objective backup can never be entered: no route reaches it"),
    ]
    assert parse("EF objective(backup)", MissionNames(found)) == EU(TRUE, FALSE)


def test_only_what_is_held_above_explains_what_is_never_selected() -> None:
    of = robot(
        (*hw("H"), *hw("sure", "spare", faulty=False)), activity("use", ("H",)), activity("also", ("H",))
    )
    of = replace(of, activities=(*of.activities, activity("a", ("sure",), ("spare",))))
    both = Parallel(
        name="both",
        blocks=(Objective(name="x", activities=("use",)), Objective(name="y", activities=("also",))),
    )
    found = check(compose(mission(of, both, Objective(name="z", activities=("a",)))))
    assert found.mission_net.usage.contentions
    assert [p.message for p in found.unselectable if "selected" in p.message] == [
        "alternative a.a_1 can never be selected"
    ]
