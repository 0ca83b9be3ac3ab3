"""The ROS 2 package with stand-ins for the names of ROS 2 that it needs: four actions and a topic."""

from __future__ import annotations

import importlib
import json
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.conftest import ROOT
from tests.drivers.robots import MISSION, until

PACKAGE = ROOT / "experiments" / "ros2" / "mcpn_ros"
DRIVERS = """
never = ["lidar_EV_RD", "encoders_EV_*", "wheels_EV_*"]

[activities.lidar_driver]
python = "mcpn_ros.bridge:act"
ends = { success = "lidar_EV_OOS", other = "lidar_EV_OOS" }

[activities.localisation]
python = "mcpn_ros.bridge:act"

[activities.drive]
python = "mcpn_ros.bridge:act"
lines = { arrived = "success" }
ends = { other = "failure" }

[activities.hand_over]
python = "mcpn_ros.bridge:act"
ends = { success = "success", other = "failure" }

[sources.panel]
python = "mcpn_ros.bridge:listen"
lines = { "back.*" = "called_back" }
"""


class Future:
    """What rclpy.task.Future says of itself, as far as it is asked."""

    def __init__(self) -> None:
        self._callbacks: list[Callable[[Future], object]] = []
        self._found: Any = None
        self._done = False
        self._lock = threading.Lock()

    def add_done_callback(self, callback: Callable[[Future], object]) -> None:
        with self._lock:
            if not self._done:
                self._callbacks.append(callback)
                return
        callback(self)

    def result(self) -> Any:
        return self._found

    def set_result(self, found: Any) -> None:
        with self._lock:
            self._found, self._done = found, True
        for callback in self._callbacks:
            callback(self)


class Goal:
    """A goal at a server, which is also its handle at the client."""

    def __init__(self, asked: Any, feedback: Callable[[Any], None], accepted: bool) -> None:
        self.asked, self.accepted = asked, accepted
        self._feedback, self._result = feedback, Future()
        self.cancelled = False

    def get_result_async(self) -> Future:
        return self._result

    def cancel_goal_async(self) -> Future:
        self.cancelled = True
        self.ends("cancelled")
        return Future()

    def says(self, line: str) -> None:
        self._feedback(SimpleNamespace(feedback=SimpleNamespace(line=line)))

    def ends(self, outcome: str) -> None:
        self._result.set_result(SimpleNamespace(result=SimpleNamespace(outcome=outcome)))


class Ros:
    """The stand-ins, and what a robot's side sees of them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.goals: list[Goal] = []
        self.published: list[dict[str, Any]] = []
        self.heard: list[Callable[[Any], None]] = []
        self.errors: list[str] = []
        self.parameters: dict[str, str] = {}
        self.refusing: set[str] = set()
        self.clients = 0
        ros = self

        class LifecycleNode:
            def __init__(self, name: str) -> None:
                self.name = name

            def declare_parameter(self, name: str, value: str) -> None:
                ros.parameters.setdefault(name, value)

            def get_parameter(self, name: str) -> Any:
                return SimpleNamespace(value=ros.parameters[name])

            def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
                assert topic == "mission/journal"
                return SimpleNamespace(publish=lambda told: ros.published.append(json.loads(told.data)))

            def destroy_publisher(self, publisher: Any) -> None:
                pass

            def create_subscription(
                self, kind: type, topic: str, callback: Any, depth: int, *, callback_group: Any
            ) -> Any:
                assert topic == "mission/event"
                ros.heard.append(callback)
                return callback

            def destroy_subscription(self, callback: Any) -> None:
                ros.heard.remove(callback)

            def get_logger(self) -> Any:
                return SimpleNamespace(info=lambda text: None, error=ros.errors.append)

        class ActionClient:
            def __init__(self, node: Any, kind: Any, name: str, *, callback_group: Any) -> None:
                assert isinstance(node, LifecycleNode)
                self.name = name
                ros.clients += 1

            def wait_for_server(self, timeout_sec: float) -> bool:
                return True

            def send_goal_async(self, asked: Any, *, feedback_callback: Callable[[Any], None]) -> Future:
                assert asked.activity == self.name
                goal, accepted = Goal(asked, feedback_callback, self.name not in ros.refusing), Future()
                ros.goals.append(goal)
                threading.Timer(0.01, accepted.set_result, [goal]).start()
                return accepted

            def destroy(self) -> None:
                ros.clients -= 1

        names: dict[str, dict[str, Any]] = {
            "rclpy": {},
            "rclpy.action": {"ActionClient": ActionClient},
            "rclpy.callback_groups": {"ReentrantCallbackGroup": object},
            "rclpy.executors": {"MultiThreadedExecutor": object},
            "rclpy.lifecycle": {
                "LifecycleNode": LifecycleNode,
                "TransitionCallbackReturn": SimpleNamespace(SUCCESS="success", FAILURE="failure"),
            },
            "rclpy.signals": {"SignalHandlerOptions": object},
            "std_msgs": {},
            "std_msgs.msg": {"String": SimpleNamespace},
            "mcpn_interfaces": {},
            "mcpn_interfaces.action": {"Activity": SimpleNamespace(Goal=SimpleNamespace)},
        }
        for name, content in names.items():
            module = ModuleType(name)
            vars(module).update(content)
            monkeypatch.setitem(sys.modules, name, module)
        monkeypatch.syspath_prepend(PACKAGE)
        for name in ("mcpn_ros", "mcpn_ros.bridge", "mcpn_ros.node"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        self.node = importlib.import_module("mcpn_ros.node").MissionController()

    def goal(self, activity: str, number: int = 0) -> Goal:
        """The goal of some number that an activity's server has."""

        def some() -> list[Goal]:
            return [goal for goal in self.goals if goal.asked.activity == activity]

        until(lambda: len(some()) > number)
        return some()[number]

    @property
    def events(self) -> list[str]:
        return [step["event"] for step in self.published]


@pytest.fixture
def ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Ros:
    (tmp_path / "mission.xml").write_text(MISSION)
    (tmp_path / "drivers.toml").write_text(DRIVERS)
    monkeypatch.chdir(tmp_path)
    return Ros(monkeypatch)


def test_activities_are_actions_and_events_come_from_a_topic(ros: Ros) -> None:
    assert ros.node.on_configure(None) == "success"
    assert ros.node.on_activate(None) == "success"
    drive = ros.goal("drive")
    assert (drive.asked.objective, drive.asked.names, drive.asked.values) == ("travel", ["room"], ["12"])
    assert ros.goal("localisation").asked.alternative == "by_scan"
    ros.goal("lidar_driver").ends("lost")
    assert ros.goal("localisation", 1).asked.alternative == "by_odometry"
    until(lambda: ros.goal("localisation").cancelled)
    drive.says("half way")
    drive.says("arrived")
    ros.goal("hand_over")
    until(lambda: ros.heard)
    ros.heard[0](SimpleNamespace(data="back, please"))
    home = ros.goal("drive", 1)
    until(lambda: ros.goal("hand_over").cancelled)
    assert home.asked.values == ["base"]
    home.says("arrived")
    until(lambda: ros.node.controller.outcome)
    assert ros.node.on_deactivate(None) == "success"
    assert ros.events == [
        "MISSION_EV_START",
        "lidar_EV_OOS",
        "OBJ_travel_EV_OK",
        "called_back",
        "OBJ_home_EV_OK",
    ]
    assert ros.node.controller.outcome == "success"
    assert (ros.clients, ros.heard, ros.errors) == (0, [], [])


def test_deactivated_in_the_middle_nothing_is_left_running(ros: Ros) -> None:
    ros.node.on_configure(None)
    ros.node.on_activate(None)
    running = [ros.goal(name) for name in ("lidar_driver", "localisation", "drive")]
    assert ros.node.on_deactivate(None) == "success"
    assert all(goal.cancelled for goal in running)
    assert (ros.clients, ros.heard, ros.node.controller.outcome) == (0, [], None)
    assert ros.node.on_activate(None) == "success"  # the mission anew
    ros.goal("drive", 1).ends("stuck")
    ros.goal("drive", 2).says("arrived")
    until(lambda: ros.node.controller.outcome)
    assert ros.node.on_shutdown(None) == "success"
    assert ros.events[-3:] == ["MISSION_EV_START", "OBJ_travel_EV_FAIL", "OBJ_home_EV_OK"]


def test_an_action_that_is_refused_is_a_failure(ros: Ros) -> None:
    ros.refusing.add("drive")
    ros.node.on_configure(None)
    ros.node.on_activate(None)
    until(lambda: ros.node.controller.outcome)
    ros.node.on_deactivate(None)
    assert ros.events == ["MISSION_EV_START", "OBJ_travel_EV_FAIL", "OBJ_home_EV_FAIL"]


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("drivers.toml", "[activities.drive]", "[activities.dive]", "drivers.toml:13"),
        ("mission.xml", 'activities="hand_over"', 'activities="hand"', "mission.xml:19"),
        (
            "mission.xml",
            "<objective name=",
            '<requirement name="r" formula="G !success"/><objective name=',
            "check",
        ),
    ],
)
def test_what_is_wrong_is_told_when_it_is_configured(
    ros: Ros, file: str, old: str, new: str, message: str
) -> None:
    text = Path(file).read_text()
    Path(file).write_text(text.replace(old, new, 1))
    assert ros.node.on_configure(None) == "failure"
    (error,) = ros.errors
    assert message in error
