"""Drivers that a file of drivers names: an activity is an action of ROS 2, events come from a topic.

Each is a function on a thread of its own (mcpn.robot.drivers); callbacks are the executor's, in groups that
are reentrant, so that they come while the node is being deactivated. They share the node of
:mod:`mcpn_ros.node`, which puts itself into :data:`node`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from mcpn_interfaces.action import Activity
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from std_msgs.msg import String

from mcpn.robot.drivers.functions import Call

LOOKS = 0.05
"""Seconds between two looks at whether the driver is to end."""

CANCELLED = 3.0
"""Seconds that an action has to end after it was cancelled; the grace of its driver should be longer."""

DEPTH = 100

node: Any = None


def act(call: Call) -> str:
    """Runs the action that has the activity's name; its outcome is what ``ends`` maps to an event.

    Returns:
        The outcome of the action's result; ``absent`` where no server came, ``rejected`` where it refused.
    """
    client = ActionClient(node, Activity, call.activity, callback_group=ReentrantCallbackGroup())
    try:
        while not client.wait_for_server(timeout_sec=LOOKS):
            if call.stopping.is_set():
                return "absent"
        parameters = dict(call.parameters)
        goal = Activity.Goal(
            activity=call.activity,
            alternative=call.alternative or "",
            objective=call.objective or "",
            names=list(parameters),
            values=list(parameters.values()),
        )
        sent = client.send_goal_async(goal, feedback_callback=lambda told: call.say(told.feedback.line))
        handle = _awaited(sent, lambda: False)  # whether it was accepted must be known to cancel it
        if not handle.accepted:
            return "rejected"
        result = handle.get_result_async()
        if (found := _awaited(result, call.stopping.is_set)) is None:
            handle.cancel_goal_async()
            _over(result).wait(CANCELLED)
            return "cancelled"
        return str(found.result.outcome)
    finally:
        client.destroy()


def listen(call: Call) -> None:
    """A source: each text on the topic ``mission/event`` is a line, which ``lines`` maps to an event."""
    heard = node.create_subscription(
        String,
        "mission/event",
        lambda message: call.say(message.data),
        DEPTH,
        callback_group=ReentrantCallbackGroup(),
    )
    call.stopping.wait()
    node.destroy_subscription(heard)


def _over(future: Any) -> threading.Event:
    over = threading.Event()
    future.add_done_callback(lambda _: over.set())
    return over


def _awaited(future: Any, given_up: Callable[[], bool]) -> Any:
    """What a future becomes, or ``None`` where the wait for it is given up."""
    over = _over(future)
    while not over.wait(LOOKS):
        if given_up():
            return None
    return future.result()
