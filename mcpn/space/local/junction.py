"""Junctions: from one section to the next, where both start or reach the same activities.

Sections that share hardware only meet at its places alone: releasing and taking it do not compete. Where they
share activities, a release on its way from the one may meet a request of the other, and whether the outcome
depends on their order is proved on the net of both.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
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
    """Proves the junctions of a mission confluent, each type of pairs once.

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
    pairs = _pairs(usage, graph, {p.section.name: p for p in placed}, templates)
    nets = [junction_part(usage, *(p.section for p in of[0])).net(templates).net for of in pairs]
    found: list[Junction] = []
    proofs = results_of([(is_confluent, net, max_states) for net in nets], making.executor)
    for number, of in enumerate(pairs):
        with in_section(" to ".join(p.section.name for p in of[0])):
            if not next(proofs):
                for first, second in of:
                    part = junction_part(usage, first.section, second.section)
                    torn = direct(part.net(templates).net, tear=True, max_states=max_states)
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


def _pairs(
    usage: Usage, graph: ObjectivesGraph, placed: dict[str, PlacedSection], templates: TemplateSet | None
) -> list[list[Pair]]:
    """Sections in a row that share activities, those of one type of pair together."""
    found: dict[Hashable, list[Pair]] = {}
    for first in graph.sections:
        used = {a.name for a in placed[first.name].part.parts.activities}
        for second in graph.targets(first):
            if not used.isdisjoint(a.name for a in placed[second.name].part.parts.activities):
                part: LocalPart = junction_part(usage, first, second)
                kind = part.type if templates is None else (first.name, second.name)
                found.setdefault(kind, []).append((placed[first.name], placed[second.name]))
    return list(found.values())
