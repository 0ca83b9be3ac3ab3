"""Runs a mission controller: events in, actions out. Needs nothing but Python.

    from mcpn.runtime import Controller

    controller = Controller.load("controller.json")
    for action in controller.handle("MISSION_EV_START"):
        print(action)

What it promises:

- An event that the controller cannot take now is never lost silently: :meth:`Controller.handle` raises
  :class:`Refused`, or calls the ``on_refused`` that it was given, and logs it either way. A refused event
  changes nothing.
- A full queue is an error of the thread that puts an event (:class:`QueueFull`), never a lost event.
- A snapshot that is truncated, changed or of another controller is an error, and changes nothing.
- A hook that fails stops neither the controller nor the other hooks: all are called, then the errors are
  raised together, the state being the new one.
"""

from mcpn.runtime.controller import Controller, Step
from mcpn.runtime.machines import ControllerFileError
from mcpn.runtime.queue import AsyncController, EventQueue, QueueFull
from mcpn.runtime.tables import Action, ParameterValue, Refused, SnapshotError

__all__ = [
    "Action",
    "AsyncController",
    "Controller",
    "ControllerFileError",
    "EventQueue",
    "ParameterValue",
    "QueueFull",
    "Refused",
    "SnapshotError",
    "Step",
]
