"""The package for ROS 2: does what the runtime does, with stand-ins for the names of ROS 2 that it needs."""

from __future__ import annotations

import ast
import importlib
import json
import random
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from lxml import etree

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet
from mcpn.files import write_folder
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.targets import files
from tests.controller.small import WATCH, composed
from tests.controller.traces import canonical
from tests.controller.treed import FORMS, START, Modelled


class Ros:
    """The stand-ins for rclpy, and what is seen of a node from outside."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.told: list[tuple[str, str]] = []
        self.heard: list[Callable[[Any], None]] = []
        self.timers: list[Callable[[], None]] = []
        self.publishers = 0
        ros = self

        class LifecycleNode:
            def __init__(self, name: str) -> None:
                self.name = name
                self.parameters: dict[str, object] = {}

            def declare_parameter(self, name: str, value: object) -> None:
                self.parameters[name] = value

            def get_parameter(self, name: str) -> Any:
                return SimpleNamespace(value=self.parameters[name])

            def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
                ros.publishers += 1
                return SimpleNamespace(publish=lambda told: ros.told.append((topic, told.data)))

            def destroy_publisher(self, publisher: Any) -> None:
                ros.publishers -= 1

            def create_subscription(self, kind: type, topic: str, callback: Any, depth: int) -> Any:
                assert topic == "~/event"
                ros.heard.append(callback)
                return callback

            def destroy_subscription(self, callback: Any) -> None:
                ros.heard.remove(callback)

            def create_timer(self, period: float, callback: Any) -> Any:
                ros.timers.append(callback)
                return callback

            def destroy_timer(self, callback: Any) -> None:
                ros.timers.remove(callback)

            def get_logger(self) -> Any:
                return SimpleNamespace(warning=lambda text: None)

        names: dict[str, dict[str, Any]] = {
            "rclpy": {},
            "rclpy.lifecycle": {
                "LifecycleNode": LifecycleNode,
                "TransitionCallbackReturn": SimpleNamespace(SUCCESS="success", FAILURE="failure"),
            },
            "std_msgs": {},
            "std_msgs.msg": {"String": SimpleNamespace},
        }
        for name, content in names.items():
            module = ModuleType(name)
            vars(module).update(content)
            monkeypatch.setitem(sys.modules, name, module)

    def tell(self, event: str) -> None:
        (heard,) = self.heard
        heard(SimpleNamespace(data=event))

    def orders(self) -> list[str]:
        """What was ordered since the last time, in the words of the runtime."""
        found = []
        for topic, text in self.told:
            if topic == "~/action":
                told = json.loads(text)
                who = told.get("activity") or told.get("hardware") or told["objective"]
                found.append(" ".join(filter(None, (told["verb"], who, told.get("alternative")))))
        self.told.clear()
        return found


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Ros:
    return Ros(monkeypatch)


def node_of(texts: dict[str, str], folder: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The node of a package that lies in a folder of its name, as it is installed."""
    (package,) = [name for name in texts if "." not in name]
    write_folder(folder / package, texts)
    monkeypatch.syspath_prepend(folder)
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    return importlib.import_module(f"{package}.node").Mission()


def lockstep(
    net: MissionNet, form: Form, folder: Path, ros: Ros, monkeypatch: pytest.MonkeyPatch, steps: int
) -> None:
    controller = generate(net, form)
    node = node_of(files(document(controller, net), "ros2"), folder, monkeypatch)
    assert node.on_configure(None) == "success"
    model = Modelled(net.mission, Tables(document(controller, net)))
    for event in model.events(random.Random(11), steps):
        before = model.running
        said = model.line(event)
        if not before and event != START and event:
            ros.tell(event)
            assert ros.orders() == []
            continue
        if not event:
            node.on_deactivate(None)
        elif before:
            ros.tell(event)
        else:
            node.on_activate(None)
        state = [json.loads(text) for topic, text in ros.told if topic == "~/state"]
        expected = said.partition(":")[2].partition("|")[0].strip()
        assert "; ".join(ros.orders()) == expected, event
        if event and said.startswith("taken"):
            mode = " ".join(sorted(f"{a}.{way}" for a, way in state[-1]["mode"].items()))
            assert canonical(f"x | {mode} |").split(" | ")[1] == said.split(" | ")[1].rstrip(" |")
            assert state[-1]["outcome"] == model.controller.outcome
            assert state[-1]["out_of_service"] == sorted(model.controller.out_of_service)
        if event and model.controller.outcome is not None and not model.running:
            node.on_deactivate(None)
            assert ros.orders() == []  # all was stopped before
    node.on_shutdown(None)
    assert node.on_cleanup(None) == "success"
    assert (ros.publishers, ros.heard, ros.timers) == (0, [], [])


@pytest.mark.parametrize("form", FORMS)
def test_the_node_in_lockstep_with_the_runtime(
    form: Form, ulysse_net: MissionNet, ros: Ros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lockstep(ulysse_net, form, tmp_path, ros, monkeypatch, 3_000)


@pytest.mark.parametrize("form", FORMS)
def test_faults_crashes_facts_timers_and_aborts(
    form: Form, ros: Ros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lockstep(composed(WATCH, tmp_path), form, tmp_path, ros, monkeypatch, 3_000)


def test_timers_are_the_node_s(ros: Ros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    net = composed(WATCH, tmp_path)
    time = 0.0
    monkeypatch.setattr("time.monotonic", lambda: time)
    node = node_of(files(document(generate(net), net), "ros2"), tmp_path, monkeypatch)
    node.on_configure(None)
    node.on_activate(None)
    (passed,) = ros.timers
    passed()
    assert "arm watch_try1" in ros.orders()
    time = 4.9
    passed()
    assert ros.orders() == []
    time = 5.0
    passed()
    assert "arm watch_try2" in ros.orders()


def test_what_is_refused_is_told(ros: Ros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    net = composed(WATCH, tmp_path)
    node = node_of(files(document(generate(net), net), "ros2"), tmp_path, monkeypatch)
    node.on_configure(None)
    node.on_activate(None)
    ros.told.clear()
    ros.tell("no such event")
    assert ros.told == [("~/refused", "no such event")]


@pytest.mark.parametrize("name", ["x", "a__b_", "_9", "class"])
def test_the_package_is_well_formed(name: str, tmp_path: Path) -> None:
    """Whatever the mission is called, as far as missions may be: names of packages are narrower."""
    net = composed(WATCH.replace('name="twice"', f'name="{name}"'), tmp_path)
    texts = files(document(generate(net), net), "ros2")
    (package,) = [each for each in texts if "." not in each]
    assert package == {"x": "x", "a__b_": "a_b", "_9": "mission_9", "class": "class"}[name] + (
        "" if name == "_9" else "_mission"
    )
    assert etree.fromstring(texts["package.xml"].encode()).findtext("name") == package
    for file, text in texts.items():
        if file.endswith(".py"):
            ast.parse(text)
    assert f'"mission = {package}.node:main"' in texts["setup.py"]
