"""Which section of a mission a picture is of, its local net and its local graph."""

from __future__ import annotations

from mcpn.errors import InputError
from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart, section_part
from mcpn.space.alternatives import DEFAULT_MAX_STATES, AlternativesGraph
from mcpn.space.clash import in_mission_words
from mcpn.space.confluence import direct_with_proof
from mcpn.space.local.composing import in_section

MOST_NAMED = 12
"""Sections that an error lists at most."""


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


def local_graph(
    mission_net: MissionNet, name: str, max_states: int | None = None
) -> tuple[MissionNet, AlternativesGraph]:
    """The local net of a section and its alternatives graph, from every state of its hardware.

    Raises:
        InputError: There is no such section.
        SemanticsError: It is not safe, or not confluent.
        LimitError: It has too many states.
    """
    local = part_of(mission_net, name).net()
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    with in_section(name), in_mission_words(local):
        return local, direct_with_proof(local.net, max_states=limit)
