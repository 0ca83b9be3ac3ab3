"""The sections of a mission, each with its type, and where its places stand in the net of the whole."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

from mcpn.mission.flatten import Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.mortal import mortal
from mcpn.net.petri import Provenance
from mcpn.net.sections import KINDS_OF_SECTIONS, Element, LocalPart, Renaming, UsedRenaming, exit_on
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


def _by_element(provenances: Iterable[Provenance | None]) -> dict[Element, list[int]]:
    found: dict[Element, list[int]] = {}
    for index, origin in enumerate(provenances):
        if origin is not None:
            found.setdefault((origin.kind, origin.name), []).append(index)
    return found


class Overlay:
    """The places of a local net, or its transitions, in the net of the whole: for sections that use the same.

    Each element is drawn in the same order in both nets. Of what several activities share, the local net has
    the interfaces of its own activities alone: there names are compared.

    Args:
        local: The places, or the transitions, of the type's local net by element.
        whole: Those of the whole net.
        names: From what the type uses to what these sections use.
        by_name: Where those of these sections' own local net lie, found by their names.

    Attributes:
        shared: By number in the local net, where those lie that are of no section, else :data:`NOWHERE`.
        locals: The reverse.
        own: Those that are of sections, by element.
    """

    def __init__(
        self,
        local: Mapping[Element, list[int]],
        whole: Mapping[Element, list[int]],
        names: UsedRenaming,
        by_name: Callable[[], list[int]],
    ) -> None:
        self.whole = whole
        self.shared = [NOWHERE] * sum(map(len, local.values()))
        self.own = {element: here for element, here in local.items() if element[0] in KINDS_OF_SECTIONS}
        for element, here in local.items():
            if element in self.own or element[0] == "exit":
                continue
            there = whole[names.elements.get(element, element)]
            if len(there) != len(here) and element[0] != "mission":
                found = by_name()
                there = [found[i] for i in here]
            for i, where in zip(here, there, strict=False):
                self.shared[i] = where
        self.locals = {where: i for i, where in enumerate(self.shared) if where != NOWHERE}

    def own_of(
        self, sections: Mapping[Element, Element], by_name: Callable[[], list[int]]
    ) -> Iterator[tuple[int, int]]:
        """What is of the objectives and blocks of one section: number in the local net, and in the whole one.

        Args:
            sections: From the type's objectives and blocks to the section's own.
            by_name: Where the places, or the transitions, of the section's own local net lie.
        """
        for element, here in self.own.items():
            there = self.whole[sections[element]]
            if len(there) != len(here):
                found = by_name()
                there = [found[i] for i in here]
            yield from zip(here, there, strict=True)


class Placement:
    """A type of sections and what those of its sections use that run the same activities.

    Args:
        type: The type.
        part: One of these sections.
        elements: What the whole net has of each element.
        templates: The set of templates that the mission is composed with.
    """

    def __init__(
        self, type_: SectionType, part: LocalPart, elements: Elements, templates: TemplateSet | None
    ) -> None:
        self.type = type_
        self.part = part
        self.elements = elements
        self.templates = templates
        self.names = UsedRenaming(type_.part.used, part.used)

    @cached_property
    def places(self) -> Overlay:
        """Where places lie."""
        drawn = self.type.net.net.places
        local = self.type.remembered("places", lambda: _by_element(place.provenance for place in drawn))
        return Overlay(local, self.elements.places, self.names, lambda: self.places_by_name(self.part))

    @cached_property
    def transitions(self) -> Overlay:
        """Where transitions lie."""
        drawn = self.type.net.net.transitions
        local = self.type.remembered("transitions", lambda: _by_element(t.provenance for t in drawn))
        by_name = partial(self.transitions_by_name, self.part)
        return Overlay(local, self.elements.transitions, self.names, by_name)

    def places_by_name(self, part: LocalPart) -> list[int]:
        """By place of a section's own local net, the place of the whole net, or :data:`NOWHERE`."""
        own, whole = self._own_net(part).net.places, self.elements.mission_net.net.place_index
        assert len(own) == len(self.type.net.net.places), "sections of one type differ in names only"
        return [whole.get(place.name, NOWHERE) for place in own]

    def transitions_by_name(self, part: LocalPart) -> list[int]:
        """By transition of a section's own local net, the transition of the whole net."""
        own, whole = self._own_net(part).net.transitions, self.elements.mission_net.net.transition_index
        assert len(own) == len(self.type.net.net.transitions), "sections of one type differ in names only"
        return [whole[transition.name] for transition in own]

    def _own_net(self, part: LocalPart) -> MissionNet:
        """A section's own local net: that of its type with other names, place by place."""
        own = part.net(self.templates)
        return mortal(own) if len(self.type.layout.bits) > 1 else own


@dataclass(frozen=True, eq=False)
class PlacedSection:
    """A section of the mission with its type.

    Args:
        section: The section.
        part: What it uses; its elements stand in the order of those of the type's.
        placement: Its type, and where in the whole net that stands which it uses.
    """

    section: Section
    part: LocalPart
    placement: Placement

    @property
    def name(self) -> str:
        """The section's name."""
        return self.section.name

    @property
    def type(self) -> SectionType:
        """The section's type."""
        return self.placement.type

    @property
    def layout(self) -> Layout:
        """The store of the composite."""
        return self.placement.type.layout

    @property
    def templates(self) -> TemplateSet | None:
        """The set of templates that the mission is composed with."""
        return self.placement.templates

    @property
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
    def objectives(self) -> tuple[str, ...]:
        """The elementary objectives of the section, in the order of the type's."""
        return tuple(section.name for section in self.part.graph.walk())

    @cached_property
    def kind(self) -> tuple[Hashable, ...]:
        """Equal for sections that differ in the names of objectives alone: exits to itself count, too."""
        return self.placement, tuple(exit_ for exit_, route in self.routes.items() if route == self.name)

    @cached_property
    def renaming(self) -> Renaming:
        """From the names in the type's local net to the section's own."""
        return Renaming(self.type.part, self.part, self.placement.names)

    @cached_property
    def own_places(self) -> Mapping[int, int]:
        """By place of the whole net that is of the section's objectives and blocks, the local place."""
        by_name = partial(self.placement.places_by_name, self.part)
        own = self.placement.places.own_of(self.renaming.sections, by_name)
        return {where: local for local, where in own}

    @cached_property
    def own_transitions(self) -> Mapping[int, int]:
        """By transition of the whole net that is of the section's objectives and blocks, the local one."""
        by_name = partial(self.placement.transitions_by_name, self.part)
        own = self.placement.transitions.own_of(self.renaming.sections, by_name)
        return {where: local for local, where in own}

    @property
    def places(self) -> list[int]:
        """By place of the local net, the place of the whole net, or :data:`NOWHERE`."""
        return _filled(self.placement.places.shared, self.own_places)

    @cached_property
    def transitions(self) -> list[int]:
        """By transition of the local net, the transition of the whole net."""
        return _filled(self.placement.transitions.shared, self.own_transitions)

    def local_place(self, place: int) -> int | None:
        """The place of the local net that is a place of the whole, if it has one."""
        local = self.own_places.get(place)
        return self.placement.places.locals.get(place) if local is None else local

    def local_transition(self, transition: int) -> int | None:
        """The transition of the local net that is a transition of the whole, if it has one."""
        local = self.own_transitions.get(transition)
        return self.placement.transitions.locals.get(transition) if local is None else local


def _filled(shared: list[int], own: Mapping[int, int]) -> list[int]:
    found = shared.copy()
    for where, local in own.items():
        found[local] = where
    return found
