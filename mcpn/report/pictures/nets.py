"""Nets as pictures: the units of a mission's net and what joins them, or one section place by place.

The paper's colours: what is internal to a unit is red, a place that no stable marking marks is orange
(temporary), the interface between units is green. Borders differ as well, for those who see no colours.
"""

from __future__ import annotations

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError, SemanticsError
from mcpn.nets.petri import PetriNet
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import drawing
from mcpn.report.pictures.place_picture import net_picture
from mcpn.report.pictures.unit_picture import units_picture

MOST_LISTED = 20_000
"""Most stable markings that are listed to find which places are temporary."""


def net_drawing(net: PetriNet) -> Drawing:
    """The picture of a net, place by place."""
    return drawing(net_picture(net, f"Net {net.name}"))


def section_net_drawing(spaces: MissionSpaces, section: str) -> Drawing:
    """The picture of the local net of a section, place by place.

    Args:
        spaces: The mission's spaces.
        section: The section's name.

    Raises:
        InputError: There is no such section.
    """
    local = spaces.section(section).mission
    try:
        _, graph = spaces.local(section, MOST_LISTED)
    except (LimitError, SemanticsError):
        return drawing(net_picture(local.net, f"Net of the section {section}"))
    marked = {
        place for state in range(graph.states) for place, tokens in enumerate(graph.marking(state)) if tokens
    }
    stable = {local.net.place_index[graph.net.places[place].name] for place in marked}
    stable |= {*local.saying("open"), *local.saying("happened")}
    return drawing(net_picture(local.net, f"Net of the section {section}", stable))


def units_drawing(mission_net: MissionNet) -> Drawing:
    """The picture of the units of a mission's net; curves are interface places between two of them."""
    return drawing(units_picture(mission_net.net, f"Net of the mission {mission_net.mission.name}"))
