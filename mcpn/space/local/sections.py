"""The sections of a mission, each with its type, and where its places stand in the net of the whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from mcpn.mission.flatten import Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.mortal import mortal
from mcpn.net.petri import Provenance
from mcpn.net.sections import LocalPart, Renaming, exit_on
from mcpn.net.templates import TemplateSet
from mcpn.space.local.layout import Layout
from mcpn.space.local.local_states import Exit
from mcpn.space.local.section_type import SectionType

BEGIN = "(begin)"
"""What stands for a section before the mission has begun; no section can have this name."""

NOWHERE = -1
"""The place of the whole net for a place of a local net that says by which event the section was left."""

ENDS = (SUCCEED, FAIL)
"""What stands for a section after the mission: the routes to its ends."""


class Elements:
    """Places and transitions of the whole net by the element that they are of, in the net's order.

    Args:
        mission_net: The net of the whole mission.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        self.mission_net = mission_net
        net = mission_net.net
        self.places = _by_element(place.provenance for place in net.places)
        self.transitions = _by_element(transition.provenance for transition in net.transitions)


def _by_element(provenances: Iterable[Provenance | None]) -> dict[tuple[str, str], list[int]]:
    found: dict[tuple[str, str], list[int]] = {}
    for index, origin in enumerate(provenances):
        if origin is not None:
            found.setdefault((origin.kind, origin.name), []).append(index)
    return found


@dataclass(frozen=True, eq=False)
class PlacedSection:
    """A section of the mission with its type.

    Args:
        section: The section.
        part: What it uses; its elements stand in the order of those of the type's.
        type: Its type.
        layout: The store of the composite.
        elements: What the whole net has of each element.
        templates: The set of templates that the mission is composed with.
    """

    section: Section
    part: LocalPart
    type: SectionType
    layout: Layout
    elements: Elements
    templates: TemplateSet | None = None

    @property
    def name(self) -> str:
        """The section's name."""
        return self.section.name

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """Hardware of the section that can fail, in the order of the type's."""
        return self.part.faulty

    @cached_property
    def slots(self) -> list[int]:
        """The section's own slots, which sets of its states leave open."""
        return sorted(self.layout.slots_of(self.faulty))

    def bit_of(self, slot: int) -> tuple[int, bool]:
        """The local level that says what one of the section's own slots would, and whether the reverse."""
        theirs, role = next(
            (name, role)
            for name, mine in zip(self.type.faulty, self.faulty, strict=True)
            for own, role in zip(self.layout.slots[mine], self.layout.bits, strict=True)
            if own == slot
        )
        return self.type.encoding.bit(self.type.net.by_role[role, theirs][0])

    @property
    def routes(self) -> Mapping[Exit, str]:
        """By exit, the section that it leads to, or an end of the mission."""
        events = {exit_on(i.event): i.target for i in self.section.interruptions}
        return {"success": self.section.success, "failure": self.section.failure, **events}

    @cached_property
    def renaming(self) -> Renaming:
        """From the names in the type's local net to the section's own."""
        return Renaming(self.type.part, self.part)

    @cached_property
    def _own(self) -> MissionNet:
        """The section's own local net: that of its type with other names, place by place."""
        own = self.part.net(self.templates)
        return mortal(own) if len(self.layout.bits) > 1 else own

    @cached_property
    def places(self) -> list[int]:
        """By place of the local net, the place of the whole net, or :data:`NOWHERE`."""
        places, whole = self.type.net.net.places, self.elements.mission_net.net.place_index
        found = self._placed([place.provenance for place in places], self.elements.places)
        if found is None:
            own = self._own.net.places
            found = [whole.get(place.name, NOWHERE) for place in own]
            assert len(own) == len(places), "sections of one type differ in names only"
        return found

    @cached_property
    def transitions(self) -> list[int]:
        """By transition of the local net, the transition of the whole net."""
        transitions, whole = self.type.net.net.transitions, self.elements.mission_net.net.transition_index
        origins = [transition.provenance for transition in transitions]
        found = self._placed(origins, self.elements.transitions)
        if found is None:
            own = self._own.net.transitions
            found = [whole[transition.name] for transition in own]
            assert len(own) == len(transitions), "sections of one type differ in names only"
        return found

    def _placed(
        self, origins: list[Provenance | None], whole: Mapping[tuple[str, str], list[int]]
    ) -> list[int] | None:
        """The same by order, where each element is drawn alike in both nets; else names must be compared.

        Of what several activities share, the local net has the interfaces of its own activities alone.
        """
        own, mission = self.renaming.elements, self.type.net.mission.name
        taken: dict[tuple[str, str], int] = {}
        found = []
        for origin in origins:
            assert origin is not None, "what templates draw has a provenance"
            if origin.kind == "exit":
                found.append(NOWHERE)
                continue
            key = origin.kind, origin.name
            mine = key if key == ("mission", mission) else (origin.kind, own[key])
            found.append(whole[mine][taken.setdefault(mine, 0)])
            taken[mine] += 1
        alike = all(len(whole[mine]) == count for mine, count in taken.items() if mine[0] != "mission")
        return found if alike else None

    @cached_property
    def _local_places(self) -> Mapping[int, int]:
        return {place: local for local, place in enumerate(self.places) if place != NOWHERE}

    def local_place(self, place: int) -> int | None:
        """The place of the local net that is a place of the whole, if it has one."""
        return self._local_places.get(place)

    @cached_property
    def _local_transitions(self) -> Mapping[int, int]:
        return {t: local for local, t in enumerate(self.transitions)}

    def local_transition(self, transition: int) -> int | None:
        """The transition of the local net that is a transition of the whole, if it has one."""
        return self._local_transitions.get(transition)

    @cached_property
    def own_transitions(self) -> frozenset[int]:
        """The transitions of the whole net that the local net has."""
        return frozenset(self.transitions)
