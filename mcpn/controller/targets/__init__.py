"""What a controller can be written as; each target is one module."""

from __future__ import annotations

from mcpn.controller.hierarchy import Controller
from mcpn.controller.targets import json
from mcpn.net.compose import MissionNet

TARGETS = ("json",)


def files(controller: Controller, mission_net: MissionNet, target: str) -> dict[str, str]:
    """The files of a target by name, the same byte for byte for the same mission.

    Args:
        controller: The controller.
        mission_net: The mission's net.
        target: One of :data:`TARGETS`.
    """
    assert target == "json"
    return {json.FILE_NAME: json.write_json(controller, mission_net)}
