"""The sections of a mission, each with its type, and where its places stand in the net of the whole."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Literal, TypeAlias, get_args

from mcpn._kernel import Zdd
from mcpn.mission.flatten import Section
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.events import START, Event, What
from mcpn.net.mortal import mortal
from mcpn.net.petri import NetBuilder, PetriNet, Place, Provenance, Transition
from mcpn.net.sections import KINDS_OF_SECTIONS, Element, LocalPart, Renaming, Used, UsedRenaming, exit_on
from mcpn.net.templates import TemplateSet
from mcpn.space.diagrams.symbolic import reach
from mcpn.space.local.layout import Layout
from mcpn.space.local.local_states import ALL, Allowed, Exit
from mcpn.space.local.section_type import SectionType

BEGIN = "(begin)"
"""What stands for a section before the mission has begun; no section can have this name."""

NOWHERE = -1
"""The place of the whole net for a place of a local net that says by which event the section was left."""

ENDS = (SUCCEED, FAIL)
"""What stands for a section after the mission: the routes to its ends."""


Kind: TypeAlias = Literal["places", "transitions"]
KINDS: tuple[Kind, ...] = get_args(Kind)


def drawn_in(net: PetriNet, kind: Kind) -> Sequence[Place | Transition]:
    """The places of a net, or its transitions."""
    return net.places if kind == "places" else net.transitions


def by_element(net: PetriNet, kind: Kind) -> dict[Element, list[int]]:
    """The places of a net, or its transitions, by the element that they are of, in the net's order."""
    found: dict[Element, list[int]] = {}
    for index, drawn in enumerate(drawn_in(net, kind)):
        if drawn.provenance is not None:
            found.setdefault((drawn.provenance.kind, drawn.provenance.name), []).append(index)
    return found


def _is_of_section(element: Element) -> bool:
    return element[0] in KINDS_OF_SECTIONS


class Elements:
    """Places and transitions of the whole net by the element that they are of.

    Args:
        mission_net: The net of the whole mission.
    """

    def __init__(self, mission_net: MissionNet) -> None:
        self.mission_net = mission_net
        net = mission_net.net
        self.of = {kind: by_element(net, kind) for kind in KINDS}
        self.numbers = {"places": net.place_index, "transitions": net.transition_index}


class Located:
    """Where the places of a local net, or its transitions, lie in the net of the whole.

    Args:
        shared: By number in the local net, where those lie that are of no section, else :data:`NOWHERE`.
        locals: The reverse.
        own: The reverse for those that are of the section's objectives and blocks.
    """

    def __init__(self, shared: list[int], locals: Mapping[int, int], own: Mapping[int, int]) -> None:
        self.shared = shared
        self.locals = locals
        self.own = own

    @cached_property
    def whole(self) -> list[int]:
        """By number in the local net, that in the net of the whole, or :data:`NOWHERE`."""
        found = self.shared.copy()
        for where, local in self.own.items():
            found[local] = where
        return found

    def local(self, where: int) -> int | None:
        """The number in the local net by that in the net of the whole, if it is there."""
        local = self.own.get(where)
        return self.locals.get(where) if local is None else local


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
        self.shared = {kind: self._shared(kind) for kind in KINDS}
        self.locals = {
            kind: {where: i for i, where in enumerate(self.shared[kind]) if where != NOWHERE}
            for kind in KINDS
        }

    def _of_type(self, kind: Kind, *, of_sections: bool) -> dict[Element, list[int]]:
        """What the local net has of each element: of objectives and blocks, or of what they use."""

        def compute() -> dict[Element, list[int]]:
            found = by_element(self.type.net.net, kind).items()
            return {element: here for element, here in found if _is_of_section(element) == of_sections}

        return self.type.remembered((kind, of_sections), compute)

    def _shared(self, kind: Kind) -> list[int]:
        """By number in the local net, where those lie that are of no section, else :data:`NOWHERE`."""
        found = [NOWHERE] * len(drawn_in(self.type.net.net, kind))
        for element, here in self._of_type(kind, of_sections=False).items():
            if element[0] not in ("exit", "mission"):
                there = self._there(kind, self.names.elements.get(element, element), here, self.part)
                for i, where in zip(here, there, strict=True):
                    found[i] = where
        return found

    def _there(self, kind: Kind, element: Element, here: list[int], part: LocalPart) -> list[int]:
        """Where what an element has in the local net lies in the whole one.

        Each element is drawn in the same order in both nets. Of what several activities share, the local net
        has the interfaces of its own activities alone: there names are compared.
        """
        there = self.elements.of[kind][element]
        if len(there) == len(here):
            return there
        net = part.net(self.templates)  # that of the type with other names, place by place
        own = drawn_in((mortal(net) if len(self.type.layout.bits) > 1 else net).net, kind)
        return [self.elements.numbers[kind].get(own[i].name, NOWHERE) for i in here]

    def located(self, kind: Kind, part: LocalPart, sections: Mapping[Element, Element]) -> Located:
        """Where the places, or the transitions, of one of these sections lie.

        Args:
            kind: Which of the two.
            part: The section.
            sections: From the type's objectives and blocks to the section's own.
        """
        own = {
            where: i
            for element, here in self._of_type(kind, of_sections=True).items()
            for i, where in zip(here, self._there(kind, sections[element], here, part), strict=True)
        }
        return Located(self.shared[kind], self.locals[kind], own)


class Stage:
    """A section of the mission, or what stands before the first one or after the last.

    Args:
        name: Its name.
        type_: Its type.
        faulty: Its hardware that can fail, in the order of the type's.
        routes: By exit, the stage that it leads to.
    """

    def __init__(
        self, name: str, type_: SectionType, faulty: tuple[str, ...], routes: Mapping[Exit, str]
    ) -> None:
        self.name = name
        self.type = type_
        self.faulty = faulty
        self.routes = routes
        self.layout = type_.layout
        self.slots = sorted(type_.layout.slots_of(faulty))
        """Its own slots, which sets of its states leave open."""

    @property
    def alike(self) -> Hashable:
        """Equal for stages that differ in the names of objectives alone."""
        return self.name

    @property
    def objectives(self) -> tuple[str, ...]:
        """Its elementary objectives, in the order of the type's."""
        return ()

    def located(self, kind: Kind) -> Located:
        """Where the places, or the transitions, of its local net lie."""
        raise NotImplementedError

    @cached_property
    def places(self) -> Located:
        """Where places lie."""
        return self.located("places")

    @cached_property
    def transitions(self) -> Located:
        """Where transitions lie."""
        return self.located("transitions")

    @cached_property
    def own_bits(self) -> Mapping[int, int]:
        """By each of its own slots, the local place that says the same."""
        return {
            slot: self.type.net.by_role[role, theirs][0]
            for theirs, mine in zip(self.type.faulty, self.faulty, strict=True)
            for slot, role in zip(self.layout.slots[mine], self.layout.bits, strict=True)
        }

    # --- its interface to the stages before and after it ---

    def entered(self, hardware: Zdd) -> Zdd:
        """First states, entered with all hardware in some states."""
        return self.type.entered(hardware, self.faulty)

    def entries(self, inside: Zdd) -> Zdd:
        """The states of all hardware with which it is entered in some of its states."""
        return self.type.entries(inside, self.faulty)

    def ending(self, exit_: Exit, hardware: Zdd) -> Zdd:
        """States after an exit with all hardware in some states."""
        return self.type.from_slots(hardware, self.faulty, exit_) & self.type.ended[exit_]

    def leaving(self, exit_: Exit, hardware: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States with an event that ends it by an exit with all hardware in some states."""
        return self.type.before_step(self.ending(exit_, hardware), allowed)

    def step(self, part: Zdd, allowed: Allowed = ALL) -> tuple[Zdd, list[tuple[str, Zdd]]]:
        """States one of its own events later, and how all hardware is where it ends."""
        after = self.type.after(part, allowed)
        leaving = [
            (route, self.type.to_slots(ended, self.faulty, exit_))
            for exit_, route in self.routes.items()
            if (ended := after & self.type.ended[exit_])
        ]
        return after & self.type.inside, leaving

    # --- hardware beside it ---

    def beside(self, allowed: Allowed = ALL, *, undone: bool) -> list[int]:
        """Events of the store for what hardware beside it does, or what undoes it.

        Closures may take those of all hardware, since its own slots are open: they change nothing there, but
        they would look like steps.
        """
        return self.layout.beside(allowed.beside, undone=undone, but=self.faulty)

    def able(self, part: Zdd, allowed: Allowed = ALL) -> Zdd:
        """Those of some states in which hardware beside it can do something that is allowed."""
        found = self.layout.store.empty()
        for hardware, toggles in self.layout.toggles.items():
            for kind, toggle in toggles.items() if hardware not in self.faulty else ():
                if allowed.beside is None or (hardware, kind) in allowed.beside:
                    found |= part.subset(toggle.marked, toggle.unmarked)
        return found

    def toggling(self, part: Zdd, goal: Zdd) -> list[tuple[str, str, Zdd]]:
        """Events of hardware beside it that lead from some states into others."""

        def compute() -> list[tuple[str, str, Zdd]]:
            return [
                (hardware, kind, before)
                for hardware, toggles in self.layout.toggles.items()
                if hardware not in self.faulty
                for kind, toggle in toggles.items()
                if (before := goal.images([toggle.undo]) & part)
            ]

        return self.type.remembered(("toggling", part, goal, self.faulty), compute)


class PlacedSection(Stage):
    """A section of the mission with its type.

    Args:
        section: The section.
        part: What it uses; its elements stand in the order of those of the type's.
        placement: Its type, and where in the whole net that stands which it uses.
    """

    def __init__(self, section: Section, part: LocalPart, placement: Placement) -> None:
        events = {exit_on(i.event): i.target for i in section.interruptions}
        routes = {"success": section.success, "failure": section.failure, **events}
        super().__init__(section.name, placement.type, part.faulty, routes)
        self.section = section
        self.part = part
        self.placement = placement

    @property
    def alike(self) -> tuple[Hashable, ...]:
        """Equal for sections that differ in the names of objectives alone: exits to itself count, too."""
        return self.placement, *(exit_ for exit_, route in self.routes.items() if route == self.name)

    @cached_property
    def objectives(self) -> tuple[str, ...]:
        """The elementary objectives of the section, in the order of the type's."""
        return tuple(section.name for section in self.part.graph.walk())

    @cached_property
    def renaming(self) -> Renaming:
        """From the names in the type's local net to the section's own."""
        return Renaming(self.type.part, self.part, self.placement.names)

    def located(self, kind: Kind) -> Located:
        """Where the places, or the transitions, of its local net lie."""
        return self.placement.located(kind, self.part, self.renaming.sections)


class Outside(Stage):
    """What stands before the mission or after it: one state of its own, with no hardware of its own.

    Args:
        name: One of :data:`BEGIN` and :data:`ENDS`.
        mission_net: The net of the whole mission.
        layout: The store of the composite.
    """

    def __init__(self, name: str, mission_net: MissionNet, layout: Layout) -> None:
        builder = NetBuilder(name, priorities=True)
        for place in ("before", "here", "success", "failure"):
            builder.place(place, initial=int(place == "before"))
        builder.transition("entered", consume=["before"], produce=["here"], event=START)
        if name == BEGIN:
            left, origin = Event(What.NAMED, "left"), Provenance("mission", name)
            builder.transition("left", consume=["here"], produce=["success"], event=left, provenance=origin)
        net, mission = builder.build(), mission_net.mission.name
        local = replace(mission_net, net=net, roles={2: ("success", mission), 3: ("failure", mission)})
        part = LocalPart(Used(mission_net.usage, ()), mission_net.graph)
        routes = {"success": mission_net.graph.entry} if name == BEGIN else {}
        super().__init__(name, SectionType(part, local, reach(net), layout), (), routes)
        place_of = {BEGIN: mission_net.beginning, SUCCEED: mission_net.success, FAIL: mission_net.failure}
        self._own = {"places": {place_of[name]: 1}, "transitions": {mission_net.start: 1} if routes else {}}

    def located(self, kind: Kind) -> Located:
        """Where the places, or the transitions, of its local net lie."""
        drawn = drawn_in(self.type.net.net, kind)
        return Located([NOWHERE] * len(drawn), {}, self._own[kind])
