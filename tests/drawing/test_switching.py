"""Sharing and switching back: what a designer sees of them, event by event."""

from __future__ import annotations

import pytest
from hypothesis import event, given

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.events import START, Event, What
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.testing import missions


def activity(
    name: str, *alternatives: str, produces: tuple[str, ...] = (), switch_back: bool = False
) -> Activity:
    ways = tuple(
        Alternative(name=f"{name}{i}", consumes=tuple(k.split())) for i, k in enumerate(alternatives)
    )
    return Activity(name=name, alternatives=ways, produces=produces, switch_back=switch_back)


def out(name: str) -> Event:
    return Event(What.OUT_OF_SERVICE, name)


def back(name: str) -> Event:
    return Event(What.REPAIRED, name)


def ok(name: str) -> Event:
    return Event(What.SUCCESS, name)


def drone(*, exclusive: bool = False, switch_back: bool = False, shared: bool = False) -> Mission:
    """Two branches that both need the position: by GPS, else by the camera."""
    return Mission(
        name="drone",
        robots=(
            Robot(
                name="r",
                hardware=tuple(Hardware(name=h, shared=shared) for h in ("gps", "camera", "motor")),
                software=(Software(name="position", exclusive=exclusive),),
                activities=(
                    activity("locate", "gps", "camera", produces=("position",), switch_back=switch_back),
                    activity("fly", "position motor"),
                    activity("map", "position"),
                    activity("rest", ""),
                ),
            ),
        ),
        blocks=(
            Parallel(
                name="both",
                blocks=(
                    Objective(name="cruise", activities=("fly",)),
                    Recursive(
                        name="science",
                        blocks=(
                            Objective(name="pause", activities=("rest",)),
                            Objective(name="survey", activities=("map",)),
                        ),
                    ),
                ),
            ),
        ),
    )


def run(mission: Mission, *events: Event) -> Situation:
    """What the robot does after some events."""
    found = compose(mission)
    graph = by_reduction(explore(found.net))
    state = 0
    for happened in (START, *events):
        (state,) = {
            target
            for label, target in graph.successors(state)
            if graph.net.transitions[label].event == happened
        }
    return situation(found, graph.marking(state))


def test_who_comes_while_the_producer_runs_is_served_at_once() -> None:
    situated = run(drone(), ok("pause"))
    assert situated.mode == {"locate": "locate0", "fly": "fly0", "map": "map0"}


def test_the_producer_goes_on_until_the_last_release() -> None:
    assert run(drone(), ok("pause"), ok("cruise")).mode == {"locate": "locate0", "map": "map0"}
    assert run(drone(), ok("pause"), ok("survey")).mode == {"locate": "locate0", "fly": "fly0"}
    ended = run(drone(), ok("pause"), ok("cruise"), ok("survey"))
    assert (ended.mode, ended.outcome) == ({}, "success")


def test_a_producer_that_falls_back_does_not_disturb_its_consumers() -> None:
    situated = run(drone(), ok("pause"), out("gps"))
    assert situated.mode == {"locate": "locate1", "fly": "fly0", "map": "map0"}


def test_each_consumer_gets_the_error() -> None:
    situated = run(drone(), ok("pause"), out("gps"), out("camera"))
    assert (situated.mode, situated.refused) == ({}, ("fly", "map"))
    # The one stopped and started again later is served; the other has told its objective.
    assert run(drone(), out("gps"), out("camera"), back("gps"), ok("pause")).mode == {
        "locate": "locate0",
        "map": "map0",
    }


def test_an_exclusive_resource_is_waited_for() -> None:
    situated = run(drone(exclusive=True), ok("pause"))
    assert situated.mode == {"locate": "locate0", "fly": "fly0"}
    assert compose(drone(exclusive=True)).usage.contentions
    assert not compose(drone()).usage.contentions


def test_a_producer_keeps_its_alternative_unless_it_switches_back() -> None:
    lost = (ok("pause"), out("gps"), back("gps"))
    assert run(drone(), *lost).mode["locate"] == "locate1"
    assert run(drone(switch_back=True), *lost).mode == {"locate": "locate0", "fly": "fly0", "map": "map0"}
    # Another resource that returns is none of its business.
    others = (ok("pause"), out("gps"), out("motor"), back("motor"))
    assert run(drone(switch_back=True), *others).mode["locate"] == "locate1"


def test_an_activity_switches_back_when_a_producer_is_possible_again() -> None:
    mission = Mission(
        name="m",
        robots=(
            Robot(
                name="r",
                hardware=tuple(Hardware(name=h) for h in ("gps", "imu", "eye")),
                software=(Software(name="position"),),
                activities=(
                    activity("locate", "gps", "imu", produces=("position",)),
                    activity("steer", "position eye", "eye", "", switch_back=True),
                ),
            ),
        ),
        blocks=(Objective(name="go", activities=("steer",)),),
    )
    lost = (out("gps"), out("imu"), out("eye"))
    assert run(mission, *lost).mode == {"steer": "steer2"}
    assert run(mission, *lost, back("imu")).mode == {"steer": "steer2"}
    assert run(mission, *lost, back("imu"), back("eye")).mode == {"locate": "locate1", "steer": "steer0"}
    assert run(mission, *lost, back("eye")).mode == {"steer": "steer1"}
    assert run(mission, *lost, back("eye"), back("gps")).mode == {"locate": "locate0", "steer": "steer0"}


@pytest.mark.parametrize("shared", [False, True])
def test_hardware_that_is_shared_serves_several(shared: bool) -> None:
    camera = Hardware(name="camera", shared=shared)
    robot = Robot(
        name="r", hardware=(camera,), activities=(activity("film", "camera"), activity("look", "camera"))
    )
    blocks = (Objective(name="both", activities=("film", "look")),)
    mission = Mission(name="m", robots=(robot,), blocks=blocks)
    if not shared:
        with pytest.raises(ConfluenceError):
            run(mission)
        return
    assert run(mission).mode == {"film": "film0", "look": "look0"}
    assert run(mission, out("camera")).refused == ("film", "look")
    assert run(mission, out("camera"), back("camera")).out_of_service == ()


@given(missions(own_hardware=True, shared_activities=False, alternatives=3))
def test_who_switches_back_never_runs_what_is_not_the_best(mission: Mission) -> None:
    """In each stable marking; what is possible is decided here by the hardware that works."""
    found = compose(mission)
    try:
        graph = by_reduction(explore(found.net, max_states=20_000))
    except LimitError:
        return
    assert not found.usage.contentions
    producer = {s: a for a in mission.activities for s in a.produces}

    def possible(way: Alternative, lost: set[str]) -> bool:
        return all(
            any(possible(each, lost) for each in producer[k].alternatives) if k in producer else k not in lost
            for k in way.consumes
        )

    switched = False
    for state in range(graph.states):
        robot = situation(found, graph.marking(state))
        lost = set(robot.out_of_service)
        for a in mission.activities:
            if a.name in robot.mode:
                running = [w.name for w in a.alternatives].index(robot.mode[a.name])
                assert possible(a.alternatives[running], lost)
                if found.usage.switching.switches_back(a.name):
                    switched |= running > 0
                    assert not any(possible(w, lost) for w in a.alternatives[:running])
    event(f"runs a fallback: {switched}")


@pytest.mark.parametrize("shared", [False, True])
def test_what_an_activity_and_its_supplier_both_hold_makes_no_alternative_possible(shared: bool) -> None:
    hardware = (Hardware(name="arm", shared=shared), Hardware(name="gps"), Hardware(name="camera"))
    activities = (
        activity("locate", "gps", "arm camera", produces=("position",)),
        activity("fly", "arm position", "", switch_back=True),
    )
    robot = Robot(name="r", hardware=hardware, software=(Software(name="position"),), activities=activities)
    mission = Mission(name="m", robots=(robot,), blocks=(Objective(name="go", activities=("fly",)),))
    ways = compose(mission).usage.switching.better("fly", 1)
    assert ways == [("arm", "gps"), ("arm", "camera")][: 1 + shared]
