"""The nets of sections that stand alone: each is a part of the net of the whole mission."""

from __future__ import annotations

from mcpn.drawing.compose import MissionNet, compose_parts
from mcpn.drawing.permanent_loss import entered_otherwise
from mcpn.drawing.sections import LocalPart, section_part
from mcpn.drawing.templates import TemplateSet
from mcpn.errors import InputError

MOST_NAMED = 12
"""Sections that an error lists at most."""


def local_net(part: LocalPart, templates: TemplateSet | None = None) -> MissionNet:
    """The net of a part, before which any status may have become another one."""
    return entered_otherwise(compose_parts(part.usage, part.parts, templates))


def part_of(mission_net: MissionNet, name: str) -> LocalPart:
    """A section of a mission, by its name, alone.

    Raises:
        InputError: There is no such section.
    """
    sections = {section.name: section for section in mission_net.graph.sections}
    if name not in sections:
        some = ", ".join([*sections][:MOST_NAMED]) + (", …" if len(sections) > MOST_NAMED else "")
        raise InputError.at(None, f"found the section {name!r}, expected one of {some}")
    return section_part(mission_net.usage, sections[name])
