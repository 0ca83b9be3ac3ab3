"""The controller: a machine that says what the net does."""

from __future__ import annotations

import json

import pytest
from hypothesis import given

from mcpn.controller.machine import Action, Machine, controller
from mcpn.controller.targets.json import write_json
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Robot
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import Event
from mcpn.space.alternatives import direct
from mcpn.testing import missions


@pytest.fixture(scope="module")
def machine(ulysse_net: MissionNet) -> Machine:
    return controller(ulysse_net, direct(ulysse_net.net))


def step(machine: Machine, state: int, event: str) -> tuple[int, tuple[Action, ...]]:
    (edge,) = [e for e in machine.edges if e.source == state and e.event == Event.parse(event)]
    return edge.target, edge.actions


def test_ulysse_has_a_state_for_each_stable_marking(machine: Machine) -> None:
    assert (len(machine.states), len(machine.edges), machine.initial) == (260, 1332, 0)
    # 3 hardware resources with two events each, 7 objectives with two each, and the start.
    assert len(machine.events) == 3 * 2 + 7 * 2 + 1


def test_losing_the_gps_selects_the_imu(machine: Machine) -> None:
    state, actions = step(machine, machine.initial, "MISSION_EV_START")
    assert {a.activity for a in actions if a.verb == "start"} == {
        "gps_driver",
        "localisation",
        "thruster_driver",
        "manual_moving",
    }
    assert Action("select", "localisation", "gps_localisation") in actions
    state, actions = step(machine, state, "GPS_sensor_EV_OOS")
    assert actions == (
        Action("stop", "gps_driver"),
        Action("start", "imu_driver"),
        Action("select", "imu_driver", "imu_driver"),
        Action("select", "localisation", "imu_localisation"),
    )
    assert machine.states[state].out_of_service == ("GPS_sensor",)
    state, actions = step(machine, state, "IMU_sensor_EV_OOS")
    assert machine.states[state].refused == ("manual_moving",)
    assert {a.activity for a in actions} == {
        "imu_driver",
        "localisation",
        "thruster_driver",
        "manual_moving",
    }
    assert {a.verb for a in actions} == {"stop"}
    assert "OBJ_coral_head.manual_moving_EV_OK" not in {
        str(e.event) for e in machine.edges if e.source == state
    }


def test_what_both_objectives_use_goes_on(machine: Machine) -> None:
    state, _ = step(machine, machine.initial, "MISSION_EV_START")
    _, actions = step(machine, state, "OBJ_coral_head.manual_moving_EV_OK")
    assert actions == (
        Action("stop", "manual_moving"),
        Action("start", "isopheric_observation"),
        Action("select", "isopheric_observation", "isopheric_observation"),
    )


def test_a_retried_activity_is_stopped_and_started_again() -> None:
    robot = Robot(
        name="r",
        hardware=(Hardware(name="H"),),
        activities=(Activity(name="a", alternatives=(Alternative(name="a", consumes=("H",)),)),),
    )
    blocks = (Objective(name="x", activities=("a",), failure="x"),)
    found = compose(Mission(name="m", robots=(robot,), blocks=blocks))
    machine = controller(found, direct(found.net))
    state, _ = step(machine, 0, "MISSION_EV_START")
    again, actions = step(machine, state, "OBJ_x_EV_FAIL")
    assert again == state
    assert actions == (Action("stop", "a"), Action("start", "a"), Action("select", "a", "a"))


@given(missions(max_objectives=2, max_depth=1))
def test_actions_lead_from_mode_to_mode(mission: Mission) -> None:
    found = compose(mission)
    try:
        machine = controller(found, direct(found.net, max_states=3000))
    except (ConfluenceError, LimitError):
        return
    order = {"stop": 0, "start": 1, "select": 2}
    seen = set()
    for edge in machine.edges:
        assert (edge.source, edge.event) not in seen
        seen.add((edge.source, edge.event))
        verbs = [order[action.verb] for action in edge.actions]
        assert verbs == sorted(verbs)
        mode: dict[str, str | None] = dict(machine.states[edge.source].mode)
        for action in edge.actions:
            if action.verb == "stop":
                del mode[action.activity]
            elif action.verb == "start":
                assert action.activity not in mode
                mode[action.activity] = None
            else:
                assert action.activity in mode
                mode[action.activity] = action.alternative
        assert mode == machine.states[edge.target].mode


def test_json_says_the_whole_machine(machine: Machine, ulysse_net: MissionNet) -> None:
    document = json.loads(write_json(machine, ulysse_net))
    assert (document["format"], document["version"], document["mission"]) == ("mcpn-controller", 1, "ulysse")
    assert [s["id"] for s in document["states"]] == list(range(260))
    assert len(document["edges"]) == 1332
    assert set(document["edges"][0]) == {"from", "event", "to", "actions"}
    assert document["objectives"]["transect.diving"]["parameters"]["depth"] == {"value": "10", "unit": "m"}
    assert document["activities"]["localisation"]["alternatives"]["imu_localisation"]["consumes"] == [
        "IMU_acceleration"
    ]
    assert sum(s["outcome"] == "success" for s in document["states"]) == 8  # any hardware may be out by then
