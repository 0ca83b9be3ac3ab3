"""Runs a mission controller: events in, actions out. Needs nothing but Python.

    from mcpn.robot.runtime import Controller

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
  raised together (:class:`HookErrors`), the state being the new one. A queue logs them and goes on, unless
  it is configured otherwise.
- A file that is damaged is refused when it is loaded (:class:`ControllerFileError`), not while the robot
  runs.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcpn.robot.runtime.actions import Action, ParameterValue, Refused
    from mcpn.robot.runtime.controller import Controller, Step, Where
    from mcpn.robot.runtime.file_schema import ControllerFileError, DamagedFile
    from mcpn.robot.runtime.hooks import HookError, HookErrors
    from mcpn.robot.runtime.journal import Journal, JournalError
    from mcpn.robot.runtime.monitors import Decision, Monitors
    from mcpn.robot.runtime.queue import AsyncController, EventQueue, QueueClosed, QueueFull
    from mcpn.robot.runtime.restoring import SnapshotError
    from mcpn.robot.runtime.watchdog import Watchdog

__all__ = [
    "Action",
    "AsyncController",
    "Controller",
    "ControllerFileError",
    "DamagedFile",
    "Decision",
    "EventQueue",
    "HookError",
    "HookErrors",
    "Journal",
    "JournalError",
    "Monitors",
    "ParameterValue",
    "QueueClosed",
    "QueueFull",
    "Refused",
    "SnapshotError",
    "Step",
    "Watchdog",
    "Where",
]

# What writes a controller's file takes its digest from this package, and need not load all of it.
_HOMES = {
    "Action": "actions",
    "AsyncController": "queue",
    "Controller": "controller",
    "ControllerFileError": "file_schema",
    "DamagedFile": "file_schema",
    "Decision": "monitors",
    "EventQueue": "queue",
    "HookError": "hooks",
    "HookErrors": "hooks",
    "Journal": "journal",
    "JournalError": "journal",
    "Monitors": "monitors",
    "ParameterValue": "actions",
    "QueueClosed": "queue",
    "QueueFull": "queue",
    "Refused": "actions",
    "SnapshotError": "restoring",
    "Step": "controller",
    "Watchdog": "watchdog",
    "Where": "controller",
}
"""By name, the module that has it."""


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(f"mcpn.robot.runtime.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
