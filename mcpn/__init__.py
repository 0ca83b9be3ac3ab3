"""mcpn: a symbolic and compositional verifier of robot missions.

What a Python user types first; each name is loaded when it is first used.

>>> import mcpn
>>> mission = mcpn.read_mission("experiments/ulysse/mission.xml")
>>> found = mcpn.check(mission)
>>> found.passed, found.stable_sizes
(True, (260, 1332))
>>> mcpn.ctl(mission, "AG EF (success | failure)").holds
True
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcpn.check import Check
    from mcpn.controller import Generate
    from mcpn.face import causes, ctl, picture, read_mission, states

    check: Check
    controller: Generate

__all__ = ["causes", "check", "controller", "ctl", "picture", "read_mission", "states"]
__version__ = "0.1.0"

_ROOMS = ("check", "controller")
"""Rooms that are called like functions."""


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"mcpn.{name}")
    if name in __all__:
        return getattr(import_module("mcpn.face"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
