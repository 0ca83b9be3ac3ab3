"""A mission's picture as SVG."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.net.compose import MissionNet
from mcpn.report.pictures.boxes import boxes
from mcpn.report.pictures.layout import lay_out
from mcpn.report.templates import environment


class MissionPicture:
    """The picture of a mission; a notebook shows it by itself.

    Args:
        mission_net: The mission's net.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        self.mission_net = mission_net

    @cached_property
    def svg(self) -> str:
        """The picture as an SVG text that stands alone."""
        mission = self.mission_net.mission
        root, _ = boxes(mission, self.mission_net.graph)
        template = environment().get_template("mission.svg")
        return template.render(picture=lay_out(root, mission), name=mission.name, alone=True)

    def save(self, path: Path | str) -> None:
        """Writes the picture, whole or not at all.

        Raises:
            InputError: The suffix is not ``.svg``, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix.lower() != ".svg":
            raise InputError.at(Source(str(path)), f"found the suffix {path.suffix!r}, expected .svg")
        write_atomically(path, self.svg)

    def _repr_svg_(self) -> str:
        return self.svg

    def __repr__(self) -> str:
        return f"<picture of the mission {self.mission_net.mission.name}>"
