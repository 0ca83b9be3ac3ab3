"""A lifecycle node that runs a mission: configured it has verified it, activated it runs it.

Parameters: ``mission`` and ``drivers``, the paths of both files. Each step is published on the topic
``mission/journal``, a line of JSON (mcpn.robot.runtime.journal). Deactivated in the middle of a mission, it
stops what runs; so it does on SIGINT and SIGTERM.
"""

from __future__ import annotations

import asyncio
import json
import signal
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

from mcpn.controller.document import document
from mcpn.errors import McpnError
from mcpn.robot.drivers.mapping import check_plan
from mcpn.robot.drivers.reading import read_drivers
from mcpn.robot.drivers.running import RobotRun
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.journal import step_object
from mcpn.study import open_study
from mcpn_ros import bridge

DEPTH = 100


class MissionController(LifecycleNode):
    """The node."""

    def __init__(self) -> None:
        super().__init__("mission_controller")
        self.declare_parameter("mission", "mission.xml")
        self.declare_parameter("drivers", "drivers.toml")
        self._thread: threading.Thread | None = None

    def on_configure(self, state: Any) -> TransitionCallbackReturn:
        """Verifies the mission, and holds the drivers against it."""
        bridge.node = self
        try:
            study = open_study(Path(self.get_parameter("mission").value))
            if not study.verdicts().passed:
                self.get_logger().error("the mission is not verified: mcpn check says why")
                return TransitionCallbackReturn.FAILURE
            self.plan = read_drivers(Path(self.get_parameter("drivers").value))
            self.tables = Tables(document(study.controller("auto"), study.mission_net))
            check_plan(self.plan, self.tables)
        except McpnError as error:
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        self.journal = self.create_publisher(String, "mission/journal", DEPTH)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> TransitionCallbackReturn:
        """Starts the mission, on a thread of its own."""
        controller = Controller(self.tables)
        controller.observe(lambda step: self.journal.publish(String(data=json.dumps(step_object(step)))))
        self.controller = controller
        self.runner = RobotRun(controller, self.tables, self.plan, told=self._told)
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="mission")
        self._thread.start()
        return TransitionCallbackReturn.SUCCESS

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self.loop) as loop:
            try:
                loop.run(self.runner.run())
            except McpnError as error:
                self.get_logger().error(str(error))
        self.get_logger().info(f"the mission has ended: {self.controller.outcome or 'stopped'}")

    def _told(self, name: str, line: str) -> None:
        self.get_logger().info(f"{name}: {line}")

    def on_deactivate(self, state: Any) -> TransitionCallbackReturn:
        """Stops what runs, and waits for it."""
        if self._thread is not None:
            with suppress(RuntimeError):  # the mission has ended, and its loop is closed
                self.loop.call_soon_threadsafe(self.runner.end)
            self._thread.join()
            self._thread = None
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: Any) -> TransitionCallbackReturn:
        """Forgets the mission."""
        self.destroy_publisher(self.journal)
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: Any) -> TransitionCallbackReturn:
        """Stops what runs."""
        return self.on_deactivate(state)


def main() -> None:
    """Spins the node on other threads, since drivers that end wait for what callbacks tell."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    node = MissionController()
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    try:
        with suppress(KeyboardInterrupt):
            threading.Event().wait()
    finally:
        node.on_deactivate(None)
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
