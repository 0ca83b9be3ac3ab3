"""The sections of a mission, each with its type, and where its places lie in the net of the whole."""

from __future__ import annotations

from array import array
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar, overload

from mcpn._kernel import Zdd
from mcpn.composite.explored_section import explore_local
from mcpn.composite.layout import Layout, Toggle
from mcpn.composite.renaming import Renaming, renamed_sections, renamed_statuses
from mcpn.composite.section_type import ALL, Allowed, Exit, SectionType
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.permanent_loss import mortal
from mcpn.drawing.sections import LocalPart, Used
from mcpn.drawing.status import Element
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.copied import KINDS, CopiedNet, elements_of_no_copy
from mcpn.drawing.templates.stencil import Copy, Kind, Stencil
from mcpn.events import START, Event, What
from mcpn.mission.core.objectives_graph import ObjectivesGraph, Section
from mcpn.mission.core.routes import routes_of
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.nets.petri import NetBuilder, Place, Transition
from mcpn.nets.provenance import Provenance
from mcpn.spaces.diagrams.encoding import Levels
from mcpn.spaces.memoized import memoized
from mcpn.spaces.projections import Bit

Found = TypeVar("Found")

BEGIN = "(begin)"
"""The name of the stage before the mission has begun; no section can have it."""

NOWHERE = -1
"""For a place of a local net without a counterpart in the whole net, as one of an exit by an event."""


@dataclass(eq=False)
class Stage(Levels):
    """A section of the mission, or the stage before the mission has begun, or at one of its ends.

    Args:
        name: Its name.
        type: Its type.
        part: What it uses; its elements stand in the order of those of the type's.
        routes: By exit, the stage that it leads to.
        places: By place of its local net, that of the whole net, or :data:`NOWHERE`.
        transitions: The same of transitions.
        used: Both, restricted to what the section uses (:data:`NOWHERE` for its control). Sections of one
            type that use the same share these lists.

    Attributes:
        objectives: Its elementary objectives, in the order of the type's.
        alike: Equal for stages that differ in the names of objectives alone: exits to itself count, too.
    """

    name: str
    type: SectionType
    part: LocalPart
    routes: Mapping[Exit, str]
    places: Sequence[int]
    transitions: Sequence[int]
    used: Mapping[Kind, Sequence[int]]

    def __post_init__(self) -> None:
        self.layout = self.type.layout
        self.store = self.layout.store
        self.carried = self.layout.carried(self.part)  # in the order of the type's
        self.slots = self.layout.slots_of(self.carried)  # which sets of its states leave open
        # Kept as they are: what is added to an object later takes several times as much.
        self.objectives = tuple([section.name for section in self.part.graph.walk()])
        again = [exit_ for exit_, route in self.routes.items() if route == self.name]
        self.alike: Hashable = (self.type, self.part.used, self.carried, *again)

    def at(self, place: int) -> int | None:
        """The index in its local net of a place of the whole net; ``None`` where it has none."""
        places = self.places
        if isinstance(places, Moved):
            return places.number_of(place)
        try:
            return places.index(place)  # sections are many, and are asked of few places each
        except ValueError:
            return None

    @cached_property
    def _own(self) -> Mapping[int, tuple[int, bool]]:
        """By own slot, the level of the local net that holds its status, and whether it is negated."""
        found, both = dict[int, tuple[int, bool]](), zip(self.carried, self.type.carried, strict=True)
        for own, theirs in both:
            place, reverse = self.type.net.flag_bits[theirs]
            level, opposite = self.type.encoding.bit(place)
            found[self.layout.slots[own]] = level, reverse != opposite
        return found

    def bit(self, place: int) -> Bit:
        """Where a set of its states says whether a place of the whole net is marked."""
        if (local := self.at(place)) is not None:
            return self.type.encoding.bit(local)
        if place not in self.layout.status:
            return bool(self.layout.idle[place])
        # An interface of the section's own hardware that the section does not use follows its status.
        slot, reverse = self.layout.status[place]
        level, opposite = self._own.get(slot, (slot, False))
        return level, reverse != opposite

    def marking(self, part: Zdd, place: int) -> Zdd:
        """Those of some of its states that mark a place of the whole net."""
        bit = self.bit(place)
        return self.type.marking(part, *bit) if not isinstance(bit, bool) else part if bit else part - part

    def closed(self, part: Zdd) -> Zdd:
        """A set of its states with its own slots unmarked, so that each state is there once."""
        return part.subset(unmarked=self.slots)

    def entered(self, status: Zdd) -> Zdd:
        """First states, entered with all elements in some status."""
        return self.type.entered(status, self.slots)

    def entries(self, inside: Zdd) -> Zdd:
        """The status of all elements with which it is entered in some of its states."""
        return self.type.entries(inside, self.slots)

    def ends(self, status: Mapping[str, Zdd]) -> Zdd:
        """States after its exits, with all elements in some status by the route."""
        after = tuple((exit_, status[route]) for exit_, route in self.routes.items() if route in status)
        return self.type.ends(after, self.slots)

    def leave(self, part: Zdd, allowed: Allowed = ALL) -> Iterator[tuple[str, Zdd]]:
        """By route, the status of all elements where one of its own events has ended it."""
        found = self.type.leave(part, self.slots, allowed)
        return ((route, found[exit_]) for exit_, route in self.routes.items() if exit_ in found)

    def toggling(self, allowed: Allowed = ALL) -> list[Toggle]:
        """Failures and repairs of hardware that the section does not use.

        Those of its own hardware are events of its local net.
        """
        return self.layout.toggling(allowed.beside, self.carried)

    def stuck(self, part: Zdd) -> Zdd:
        """States with no event at all, of the section or of hardware beside it."""
        return (part & self.type.graph.dead).without([toggle.condition for toggle in self.toggling()])

    def named(self, own: Mapping[int, Found], beside: Mapping[int, Found]) -> Iterator[tuple[int, Found]]:
        """Values of both kinds of events by transition of the whole net: renames those of the local net."""
        yield from ((self.transitions[t], value) for t, value in own.items())
        yield from beside.items()

    def forth(self, part: Zdd, allowed: Allowed) -> Zdd:
        """States one event after some states: an event of its own or of hardware beside it."""
        return self.type.forth(part, allowed, self.carried)

    def back(self, part: Zdd, allowed: Allowed, within: Zdd) -> Zdd:
        """States of a set one event before some states: an event of its own or of hardware beside it."""
        return self.type.backward(part, allowed, self.carried) & within


class WholeNet:
    """The net of the whole mission, and where those of its sections lie in it.

    Args:
        mission_net: The net of the whole mission.
        templates: The set of templates that it is composed with.
    """

    def __init__(self, mission_net: MissionNet, templates: TemplateSet | None = None) -> None:
        self.mission_net = mission_net
        self.templates = templates
        net = mission_net.net
        self.copies = net.copies if isinstance(net, CopiedNet) else None
        # What sections that run the same activities use lies in one place for all of them.
        self._used: dict[tuple[SectionType, Used], dict[Kind, array[int]]] = {}
        # Of those that are copies of one, only the first is looked for: the others lie as it does.
        self._first: dict[tuple[SectionType, Stencil], tuple[Copy, dict[Kind, Lying]]] = {}

    def stage(self, section: Section, part: LocalPart, type_: SectionType) -> Stage:
        """A section of the mission with its type."""
        copy = None if self.copies is None else self.copies.by_section.get(section.name)
        lie: Mapping[Kind, Sequence[int]]
        if copy is None:
            lie = self._lying(part, type_)
        else:
            first, others = self._first.setdefault((type_, copy.stencil), (copy, {}))
            if not others:
                others |= {kind: Lying(row) for kind, row in self._lying(part, type_).items()}
            size = copy.stencil.size
            lie = {k: Moved(row, first.first(k), copy.first(k), size(k)) for k, row in others.items()}
        used = self._used[type_, part.used]
        return Stage(section.name, type_, part, routes_of(section), lie["places"], lie["transitions"], used)

    def _lying(self, part: LocalPart, type_: SectionType) -> dict[Kind, Sequence[int]]:
        """Where the places and transitions of a section's local net lie."""
        own = self._control(part, type_)
        return {kind: self._located(kind, part, type_, own) for kind in KINDS}

    def section_of(self, kind: Kind, where: int) -> str | None:
        """The section that alone has a place, or a transition, if it is a copy."""
        if self.copies is None:
            return None
        copy, _ = self.copies.numbering(kind).at(where)
        return None if copy is None else self.copies.every[copy].section.name

    @staticmethod
    def _control(part: LocalPart, type_: SectionType) -> Mapping[Element, Element]:
        """The section's control, which no other section has, by the corresponding element of its type."""
        return renamed_sections(type_.part, part) | renamed_statuses(type_.part, part)

    def _located(
        self, kind: Kind, part: LocalPart, type_: SectionType, own: Mapping[Element, Element]
    ) -> array[int]:
        """Where the places, or the transitions, of a section's local net lie."""
        known = self._used.setdefault((type_, part.used), {})
        if kind not in known:
            used = Renaming(type_.part, part).elements
            known[kind] = array("i", [NOWHERE]) * len(getattr(type_.net.net, kind))
            self._locate(known[kind], kind, part, type_, {e: used[e] for e in used.keys() - own.keys()})
        indices = known[kind][:]
        self._locate(indices, kind, part, type_, own)
        return indices

    def _locate(
        self,
        indices: array[int],
        kind: Kind,
        part: LocalPart,
        type_: SectionType,
        names: Mapping[Element, Element],
    ) -> None:
        """Notes where those of some elements lie, by the element of the type.

        Each element is drawn in the same order in both nets. Of what several activities share, the local net
        has the interfaces of its own activities alone: there names are compared.
        """
        theirs, ours = self._elements(kind, type_), self._elements(kind, None)
        if self.copies is not None and (copy := self.copies.by_section.get(part.graph.sections[0].name)):
            ours = {**ours, **copy.stencil.of_element(kind, copy)}
        drawn_whole: Sequence[Place | Transition] = getattr(self.mission_net.net, kind)
        drawn: MissionNet | None = None
        for element, name in names.items():
            if element not in theirs:
                continue
            here, there = theirs[element], ours[name]
            if len(there) != len(here):
                same_names = part.used is type_.part.used and name == element
                if same_names:
                    own = getattr(type_.net.net, kind)
                else:
                    drawn = drawn or self._drawn(part, type_)
                    own = getattr(drawn.net, kind)
                index = {drawn_whole[number].name: number for number in there}
                there = [index.get(own[i].name, NOWHERE) for i in here]
            for i, where in zip(here, there, strict=True):
                indices[i] = where

    def _drawn(self, part: LocalPart, type_: SectionType) -> MissionNet:
        """A section's local net: place by place that of its type, but for names."""
        net = local_net(part, self.templates)
        return mortal(net) if type_.layout.mission_net.saying("dead") else net

    @memoized
    def _elements(self, kind: Kind, type_: SectionType | None) -> Mapping[Element, list[int]]:
        """What a type's local net, or the whole net but for copies, has of each element, in its order."""
        places_of: dict[Element, list[int]] = {}
        net = (self.mission_net if type_ is None else type_.net).net
        for index, origin in elements_of_no_copy(net, kind):
            if origin is not None:
                places_of.setdefault((origin.kind, origin.name), []).append(index)
        return places_of


class Lying(list[int]):
    """Where the nodes of a section lie of which others are copies."""

    @cached_property
    def numbers(self) -> Mapping[int, int]:
        """By value, the first number with it."""
        return {where: number for number, where in reversed([*enumerate(self)])}


class Moved(Sequence[int]):
    """Where the nodes of a section lie that is a copy: its own as those of another copy, moved.

    Args:
        other: Where those of the other copy lie; one object for all copies of it.
        theirs: The first number of that copy's own.
        first: That of this one's.
        size: How many there are.
    """

    __slots__ = ("_end", "_moved", "_theirs", "other")

    def __init__(self, other: Lying, theirs: int, first: int, size: int) -> None:
        self.other, self._theirs, self._end, self._moved = other, theirs, theirs + size, first - theirs

    @property
    def own(self) -> tuple[int, int]:
        """The first number of its own, and that after the last."""
        return self._theirs + self._moved, self._end + self._moved

    def number_of(self, where: int) -> int | None:
        """The first number with a value; ``None`` where there is none."""
        if self._theirs <= where - self._moved < self._end:
            return self.other.numbers.get(where - self._moved)
        return None if self._theirs <= where < self._end else self.other.numbers.get(where)

    @property
    def kept(self) -> Sequence[int]:
        """The same of what is not the section's own, :data:`NOWHERE` for all that is."""
        begin, end = self._theirs, self._end
        return [NOWHERE if begin <= where < end else where for where in self.other]

    def __len__(self) -> int:
        return len(self.other)

    def __iter__(self) -> Iterator[int]:
        begin, end, moved = self._theirs, self._end, self._moved
        return iter([where + moved if begin <= where < end else where for where in self.other])

    @overload
    def __getitem__(self, number: int) -> int: ...

    @overload
    def __getitem__(self, number: slice) -> Sequence[int]: ...

    def __getitem__(self, number: int | slice) -> int | Sequence[int]:
        if isinstance(number, slice):
            return [*self][number]
        where = self.other[number]
        return where + self._moved if self._theirs <= where < self._end else where

    def __contains__(self, where: object) -> bool:
        return isinstance(where, int) and self.number_of(where) is not None

    def index(self, where: int, start: int = 0, stop: int | None = None) -> int:
        """The first number with a value."""
        if (number := self.number_of(where)) is None:
            raise ValueError(where)
        return number


def ends_of(mission_net: MissionNet) -> dict[str, int]:
    """The mission's ends by the route that leads there, each with its place of the whole net."""
    routes = {"success": SUCCEED, "failure": FAIL, "abort": ABORT}
    return {routes[end]: place for end, place in mission_net.ends.items()}


def outside(name: str, mission_net: MissionNet, layout: Layout) -> Stage:
    """The stage before the mission, or at one of its ends: one state, without elements of its own."""
    builder = NetBuilder(name, priorities=True)
    for place in ("before", "here", "success", "failure"):
        builder.place(place, initial=int(place == "before"))
    builder.transition("entered", consume=["before"], produce=["here"], event=START)
    if name == BEGIN:
        left, origin = Event(What.DECLARED, BEGIN), Provenance("mission", name)
        builder.transition("left", consume=["here"], produce=["success"], event=left, provenance=origin)
    net, mission = builder.build(), mission_net.core.name
    local = replace(mission_net, net=net, roles={2: ("success", mission), 3: ("failure", mission)})
    part = LocalPart(Used(mission_net.usage, ()), ObjectivesGraph((), ""))
    here = mission_net.beginning if name == BEGIN else ends_of(mission_net)[name]
    routes = {"success": mission_net.graph.entry} if name == BEGIN else {}
    places, transitions = [NOWHERE, here, NOWHERE, NOWHERE], [NOWHERE, mission_net.start][: 1 + len(routes)]
    type_ = SectionType(part, local, explore_local(net), layout)
    used: dict[Kind, list[int]] = {
        "places": [NOWHERE] * len(places),
        "transitions": [NOWHERE] * len(transitions),
    }
    return Stage(name, type_, part, routes, places, transitions, used)
