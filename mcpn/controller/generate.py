"""From a mission's net to its controller."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from mcpn.controller.hierarchy import Controller, flat_controller, hierarchical_controller
from mcpn.errors import LimitError
from mcpn.net.compose import MissionNet
from mcpn.space.alternatives import DEFAULT_MAX_STATES as DEFAULT_MAX_FLAT
from mcpn.space.clash import in_mission_words
from mcpn.space.confluence import direct_with_proof
from mcpn.space.local.composite import Composite
from mcpn.space.local.gluing import glue
from mcpn.space.local.graph import LocalGraph
from mcpn.space.local.placing import DEFAULT_MAX_STATES, Making

Form = Literal["flat", "hierarchical"]
Progress = Callable[[int, int], None]


def generate(
    mission_net: MissionNet,
    form: Form = "hierarchical",
    *,
    max_states: int | None = None,
    progress: Progress | None = None,
    told: Callable[[str], object] | None = None,
) -> Controller:
    """Generates the controller of a mission.

    Args:
        mission_net: The mission's net.
        form: Hierarchical, whose size is the sum of the sizes of types of sections; or flat.
        max_states: How many states a machine may have.
        progress: Called as the spaces are explored.
        told: Called with the sizes, in words, before large sections are listed.

    Raises:
        SemanticsError: The mission is not safe or not confluent, or a section hands on more than hardware.
        LimitError: A machine would have more states than allowed; the message says how many.
    """
    if form == "flat":
        faulty = sum(h.faulty for h in mission_net.mission.hardware)
        limit = DEFAULT_MAX_FLAT if max_states is None else max_states
        if 1 << faulty > limit:
            raise LimitError(
                f"{faulty} hardware resources that may fail have 2^{faulty} states and a flat controller has "
                f"more, the limit is {limit}: the hierarchical one needs no such product"
            )
        with in_mission_words(mission_net):
            graph = direct_with_proof(mission_net.net, progress=progress, max_states=limit)
        return flat_controller(mission_net, graph)
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    composite = glue(mission_net.usage, mission_net.graph, Making(max_states=limit, progress=progress))
    sizes = _unlisted(composite)
    if sizes:
        most = max(sizes.values())
        text = "; ".join(f"section {name} has {size:,} states" for name, size in sizes.items())
        if most > limit:
            raise LimitError(f"{text}: a machine lists every state, the limit is {limit:,} (--max-states)")
        if told:
            told(f"{text}: listing them")
        making = Making(max_states=limit, most_listed=None, progress=progress)
        composite = glue(mission_net.usage, mission_net.graph, making)
        if sizes := _unlisted(composite):
            raise LimitError(f"section {next(iter(sizes))} cannot be listed: the limit is {limit:,}")
    return hierarchical_controller(composite)


def _unlisted(composite: Composite) -> dict[str, int]:
    """Sections whose states are a diagram, the first of each type, with how many they are."""
    found: dict[int, tuple[str, int]] = {}
    for placed in composite.sections:
        if not isinstance(placed.local, LocalGraph):
            found.setdefault(id(placed.local), (placed.section.name, placed.local.size))
    return dict(found.values())
