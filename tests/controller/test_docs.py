"""The sketch of a ROS 2 node: run with stand-ins for ROS 2, of which it needs a handful of names."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet
from mcpn.robot.targets import files

PAGE = Path(__file__).parents[2] / "docs" / "ros2.md"


def test_the_node_hands_on_events_and_actions(
    ulysse_net: MissionNet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ((name, text),) = files(document(generate(ulysse_net), ulysse_net), "json").items()
    (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    published: dict[str, list[str]] = {}
    heard: list[Any] = []

    class Node:
        def __init__(self, name: str) -> None:
            self.name = name

        def declare_parameter(self, name: str, value: str) -> Any:
            return SimpleNamespace(value=value)

        def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
            sent = published.setdefault(topic, [])
            return SimpleNamespace(publish=lambda message: sent.append(message.data))

        def create_subscription(self, kind: type, topic: str, call: Any, depth: int) -> None:
            heard.append(call)

        def get_logger(self) -> Any:
            return SimpleNamespace(warning=lambda text: None)

    modules = {name: ModuleType(name) for name in ("rclpy", "rclpy.node", "std_msgs", "std_msgs.msg")}
    modules["rclpy"].init = lambda: None  # type: ignore[attr-defined]
    modules["rclpy"].spin = lambda node: None  # type: ignore[attr-defined]
    modules["rclpy.node"].Node = Node  # type: ignore[attr-defined]
    modules["std_msgs.msg"].String = SimpleNamespace  # type: ignore[attr-defined]
    for module, stand_in in modules.items():
        monkeypatch.setitem(sys.modules, module, stand_in)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.S)
    exec(compile(code, str(PAGE), "exec"), {"__name__": "node"})
    (event,) = heard
    event(SimpleNamespace(data="MISSION_EV_START"))
    event(SimpleNamespace(data="no_such_EV"))
    assert published["/mission/action"][-1] == "start manual_moving"
    assert published["/mission/refused"] == ["no_such_EV"]
