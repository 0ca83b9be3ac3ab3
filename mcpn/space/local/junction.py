"""Junctions: from one section to the next, where what stops meets what begins.

The paper's templates make every junction of sections confluent whose own nets are (``papers/composition.md``
has the argument): what stops gives back and asks for nothing, or else the next section is entered only when
all of it is over (:mod:`mcpn.mission.handover`). Of a caller's own templates nothing is known, so each
junction of two sections that share anything, hardware included, is proved on the net of both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcpn.errors import SemanticsError
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.usage import Usage
from mcpn.net.petri import PetriNet
from mcpn.net.sections import LocalPart, junction_part
from mcpn.net.templates import TemplateSet
from mcpn.space.alternatives import AlternativesGraph, direct
from mcpn.space.confluence import prove_confluent
from mcpn.space.local.placing import AS_USUAL, Making, PlacedSection, in_section, results_of
from mcpn.space.local.protocol import TornHere

Pair: TypeAlias = tuple[PlacedSection, PlacedSection]


@dataclass(frozen=True, eq=False)
class Junction:
    """Two sections in a row whose junction is not confluent for all states of their hardware.

    Args:
        first: The section that is left, in its own names.
        second: The section that is entered.
        graph: The alternatives graph of both together, torn.
        templates: Those that the mission is composed with.
    """

    first: PlacedSection
    second: PlacedSection
    graph: AlternativesGraph
    templates: TemplateSet | None

    def torn(self, inside: Any) -> Iterator[TornHere]:
        """Events after some states of the first section's local space whose outcome is not one state."""
        own, net = self.first.net(self.templates).net, self.graph.net
        places = [net.place_index[place.name] for place in own.places]
        for state, transition, error in self.graph.torn:
            tokens = self.graph.marking(state)
            here = self.first.local.among(inside, [tokens[p] for p in places])
            if here:
                yield TornHere(here, net.transitions[transition].event, error)


def open_junctions(
    usage: Usage, graph: ObjectivesGraph, placed: list[PlacedSection], making: Making = AS_USUAL
) -> list[Junction]:
    """Proves the junctions of a mission confluent where the templates are a caller's own.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        placed: Its sections.
        making: How the sections were made.

    Returns:
        Those that are not confluent for all states of their hardware, whether the mission comes there or not.

    Raises:
        LimitError: A limit was hit.
    """
    templates, max_states = making.templates, making.max_states
    if templates is None:
        return []
    pairs = list(sharing_pairs(graph, {p.section.name: p for p in placed}))
    nets = [junction_part(usage, *(p.section for p in pair)).net(templates).net for pair in pairs]
    found: list[Junction] = []
    proofs = results_of([(is_confluent, net, max_states) for net in nets], making.executor)
    for number, (first, second) in enumerate(pairs):
        with in_section(f"{first.section.name} to {second.section.name}"):
            if not next(proofs):
                torn = direct(nets[number], tear=True, max_states=max_states)
                found.append(Junction(first, second, torn, templates))
        if making.progress:
            making.progress(number + 1, len(pairs))
    return found


def is_confluent(net: PetriNet, max_states: int) -> bool:
    """Whether internal evolution of a net is confluent and ends."""
    try:
        prove_confluent(net, max_states=max_states)
    except SemanticsError:
        return False
    return True


def sharing_pairs(graph: ObjectivesGraph, placed: Mapping[str, PlacedSection]) -> Iterator[Pair]:
    """Sections in a row that share activities or hardware.

    Args:
        graph: The objectives graph.
        placed: Its sections by name.

    Yields:
        A section that is left and one that is entered, each pair once.
    """
    used = {name: _used(section.part) for name, section in placed.items()}
    for first in graph.sections:
        for name in dict.fromkeys(target.name for target in graph.targets(first)):
            if not used[first.name].isdisjoint(used[name]):
                yield placed[first.name], placed[name]


def _used(part: LocalPart) -> set[tuple[str, str]]:
    activities, hardware = part.parts.activities, part.parts.hardware
    return {("activity", a.name) for a in activities} | {("hardware", h.name) for h in hardware}
