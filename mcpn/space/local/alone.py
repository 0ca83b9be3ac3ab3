"""A section alone: its local net and its alternatives graph, listed."""

from __future__ import annotations

from mcpn.net.compose import MissionNet
from mcpn.net.sections import part_of
from mcpn.space.local.composing import in_section
from mcpn.space.stable.alternatives import DEFAULT_MAX_STATES, AlternativesGraph
from mcpn.space.stable.clash import in_mission_words
from mcpn.space.stable.confluence import direct_with_proof


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
