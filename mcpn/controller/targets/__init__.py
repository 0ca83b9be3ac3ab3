"""What a controller can be written as; each target is one module."""

from __future__ import annotations

from mcpn.controller.modular import AnyController, ModularController
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError

TARGETS = ("json", "c", "python", "scxml", "btcpp", "ros2")
OF_RULES = ("json", "c", "python", "btcpp", "ros2")
"""Those of modular controllers."""


def files(controller: AnyController, mission_net: MissionNet, target: str) -> dict[str, str]:
    """The files of a target by name, the same byte for byte for the same mission.

    Args:
        controller: The controller.
        mission_net: The mission's net.
        target: One of :data:`TARGETS`.

    Raises:
        InputError: A modular controller has no such target.
    """
    if target == "json":
        from mcpn.controller.targets.json import FILE_NAME, write_json

        return {FILE_NAME: write_json(controller, mission_net)}
    if target == "c":
        from mcpn.controller.targets.c import write_c

        return write_c(controller, mission_net)
    if target == "python":
        from mcpn.controller.targets.python import write_python

        return write_python(controller, mission_net)
    if target == "btcpp":
        from mcpn.controller.targets.btcpp import write_btcpp

        return write_btcpp(controller, mission_net)
    if target == "ros2":
        from mcpn.controller.targets.python import write_ros2

        return write_ros2(controller, mission_net)
    if isinstance(controller, ModularController):
        expected = f"{', '.join(OF_RULES[:-1])} or {OF_RULES[-1]}"
        raise InputError.at(None, f"found the target {target} of a modular controller, expected {expected}")
    from mcpn.controller.targets.scxml import write_scxml

    return write_scxml(controller, mission_net)
