"""The picture of a mission as it was written."""

from __future__ import annotations

from mcpn.drawing.compose import MissionNet
from mcpn.report.pictures.boxes import boxes
from mcpn.report.pictures.drawing import Drawing, rendered
from mcpn.report.pictures.layout import lay_out


def mission_drawing(mission_net: MissionNet) -> Drawing:
    """The picture of a mission: blocks in blocks, routes, activities and hardware."""
    mission = mission_net.mission
    root, _ = boxes(mission, mission_net.graph)
    return Drawing(
        f"the mission {mission.name}",
        lambda: rendered("mission.svg", picture=lay_out(root, mission), name=mission.name),
    )
