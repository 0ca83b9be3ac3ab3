"""What a controller can be written as; each target is one module."""

from __future__ import annotations

from collections.abc import Callable

from mcpn.controller.hierarchy import Controller
from mcpn.net.compose import MissionNet

Writer = Callable[[Controller, MissionNet], dict[str, str]]
TARGETS = ("json", "c", "python", "scxml")


def files(controller: Controller, mission_net: MissionNet, target: str) -> dict[str, str]:
    """The files of a target by name, the same byte for byte for the same mission.

    Args:
        controller: The controller.
        mission_net: The mission's net.
        target: One of :data:`TARGETS`.
    """
    return _writer(target)(controller, mission_net)


def _writer(target: str) -> Writer:
    if target == "c":
        from mcpn.controller.targets.c import write_c

        return write_c
    if target == "scxml":
        from mcpn.controller.targets.scxml import write_scxml

        return write_scxml
    if target == "python":
        from mcpn.controller.targets.python import write_python

        return write_python
    from mcpn.controller.targets.json import FILE_NAME, write_json

    return lambda controller, mission_net: {FILE_NAME: write_json(controller, mission_net)}
