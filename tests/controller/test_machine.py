"""The controller: a machine that says what the net does."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import event, given

from mcpn.controller.document import document as document_of
from mcpn.controller.generate import generate
from mcpn.controller.machine import VERBS, Machine, PlannedAction, controller
from mcpn.controller.run_to_completion import Runner
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.robot.targets.json import write_json
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from tests.draws import composed, fewer


@pytest.fixture(scope="module")
def machine(ulysse_net: MissionNet) -> Machine:
    return controller(ulysse_net, direct(ulysse_net.net))


def step(machine: Machine, state: int, event: str) -> tuple[int, tuple[PlannedAction, ...]]:
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
    assert PlannedAction("select", "localisation", "gps_localisation") in actions
    state, actions = step(machine, state, "GPS_sensor_EV_OOS")
    assert actions == (
        PlannedAction("stop", "gps_driver"),
        PlannedAction("release", hardware="GPS_sensor"),
        PlannedAction("select", "imu_driver", "imu_driver"),
        PlannedAction("select", "localisation", "imu_localisation"),
        PlannedAction("start", "imu_driver"),
    )
    assert machine.states[state].out_of_service == ("GPS_sensor",)
    state, actions = step(machine, state, "IMU_sensor_EV_OOS")
    assert machine.states[state].refused == ("manual_moving",)
    assert {a.activity for a in actions if a.verb == "stop"} == {
        "imu_driver",
        "localisation",
        "thruster_driver",
        "manual_moving",
    }
    assert {a.verb for a in actions} == {"stop", "release"}
    assert "OBJ_coral_head.manual_moving_EV_OK" not in {
        str(e.event) for e in machine.edges if e.source == state
    }


def test_between_two_sections_everything_is_stopped(machine: Machine) -> None:
    state, _ = step(machine, machine.initial, "MISSION_EV_START")
    _, actions = step(machine, state, "OBJ_coral_head.manual_moving_EV_OK")
    shared = ["gps_driver", "thruster_driver", "localisation"]
    names = {verb: [a.activity for a in actions if a.verb == verb] for verb in VERBS}
    # The producer of a resource for one consumer stops with it; the next objective asks it anew.
    assert names["stop"] == ["manual_moving", "localisation", "thruster_driver", "gps_driver"]
    assert names["start"] == [*shared, "isopheric_observation"] == names["select"]
    assert [a.hardware for a in actions if a.verb == "release"] == ["thruster_actuator", "GPS_sensor"]
    assert actions[-1] == PlannedAction(
        "start", "isopheric_observation", objective="coral_head.isopheric_observation"
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
    assert actions == (
        PlannedAction("stop", "a"),
        PlannedAction("release", hardware="H"),
        PlannedAction("select", "a", "a", objective="x"),
        PlannedAction("start", "a", objective="x"),
    )


def test_json_says_the_whole_machine(ulysse_net: MissionNet) -> None:
    document = json.loads(write_json(document_of(generate(ulysse_net, "flat"), ulysse_net)))
    assert (document["format"], document["version"], document["mission"]) == ("mcpn-controller", 1, "ulysse")
    (machine,) = document["types"]
    assert len(machine["states"]) == 236
    assert set(machine["edges"][0]) == {
        *("from", "event", "to", "actions"),
        *("open", "happened", "gained", "lost"),
    }
    assert document["objectives"]["transect.diving"]["parameters"]["depth"] == {"value": "10", "unit": "m"}
    assert document["activities"]["localisation"]["alternatives"]["imu_localisation"]["consumes"] == [
        "IMU_acceleration"
    ]
    assert {e["to"] for e in machine["edges"] if isinstance(e["to"], str)} == {"success", "failure"}


def test_the_text_is_the_same_each_time(ulysse: Mission) -> None:
    one, other = compose(ulysse), compose(ulysse)
    assert write_json(document_of(generate(one), one)) == write_json(document_of(generate(other), other))


@fewer(0.5)
@given(missions() | stacked_missions())
def test_what_activities_leave_on_an_edge_is_what_one_event_after_the_other_shows(given: Mission) -> None:
    net = composed(given)
    try:
        graph = direct(net.net, max_states=3_000)
    except (LimitError, SemanticsError):
        return
    runner = Runner(net)
    numbers, kinds = runner.passages(graph)
    packed = [int.from_bytes(row.tobytes(), "little") for row in graph.markings]
    for edge, (source, label, target) in enumerate(
        zip(graph.sources.tolist(), graph.labels.tolist(), graph.targets.tolist(), strict=True)
    ):
        passage = runner.fire(packed[source], label)
        found = kinds[numbers[edge]]
        assert (passage.marking, passage.activities, passage.idled) == (
            packed[target],
            found.activities,
            found.idled,
        )
    event(f"restarts: {any(kind.idled for kind in kinds)}")


def test_an_edge_to_elsewhere_is_refused(ulysse_net: MissionNet) -> None:
    graph = direct(ulysse_net.net)
    wrong = graph.targets.copy()
    wrong[3] = (wrong[3] + 1) % graph.states
    with pytest.raises(AssertionError, match="an edge ends where"):
        Runner(ulysse_net).passages(replace(graph, targets=wrong))
