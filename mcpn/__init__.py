"""mcpn: a symbolic and compositional verifier of robot missions.

What a Python user types first; each name is loaded when it is first used.

>>> import mcpn
>>> study = mcpn.open("experiments/ulysse/mission.xml")
>>> study.check().passed, study.states().states
(True, 44299)
>>> study.ctl("AG EF (success | failure)").holds
True

A study keeps what it has built for one question for the next. Who asks a mission once may call a function:

>>> mission = mcpn.read_mission("experiments/ulysse/mission.xml")
>>> mcpn.check(mission, engine="local").stable_sizes
(260, 1332)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcpn.check import Check
    from mcpn.controller import Generate
    from mcpn.face import causes, ctl, graph, picture, read_mission, states
    from mcpn.study import Study
    from mcpn.study import open_study as open

    check: Check
    controller: Generate

__all__ = [
    "Study",
    "causes",
    "check",
    "controller",
    "ctl",
    "graph",
    "open",
    "picture",
    "read_mission",
    "states",
]
__version__ = "0.1.0"

_ROOMS = ("check", "controller")
"""Rooms that are called like functions."""

_STUDY = {"Study": "Study", "open": "open_study"}
"""Names of :mod:`mcpn.study`."""


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"mcpn.{name}")
    if name in _STUDY:
        return getattr(import_module("mcpn.study"), _STUDY[name])
    if name in __all__:
        return getattr(import_module("mcpn.face"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
