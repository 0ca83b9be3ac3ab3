"""The net of a mission of which some sections are copies: they are drawn when somebody asks for them.

What is copied lies together, after what is the same for all sections, so that its places and transitions have
numbers by arithmetic, and what nets are asked for often (the initial marking, events, who needs a place) is
known by stencil. A mission may have thousands of sections of a few types.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from typing import Any, get_args

from mcpn.drawing.templates.canvas import Canvas, Role
from mcpn.drawing.templates.stencil import Copy, Kind, Stencil
from mcpn.events import Event
from mcpn.mission.core.objectives_graph import Section
from mcpn.nets.event_index import EventIndex
from mcpn.nets.numbering import Nodes, Numbering
from mcpn.nets.petri import EVENTS, Arcs, Marking, PetriNet, Place, Transition, numbered_ranks
from mcpn.nets.provenance import Provenance

KINDS: tuple[Kind, ...] = get_args(Kind)


class CopiedSections:
    """The copies in a net, and where they lie.

    Args:
        every: The copies, in their order.
        places: Where their places lie.
        transitions: Where their transitions lie.
        outside: By route that leads to no copy, the numbers of the places that it marks.
    """

    def __init__(
        self,
        every: Sequence[Copy],
        places: Numbering,
        transitions: Numbering,
        outside: Mapping[str, Sequence[int]],
    ) -> None:
        self.every, self.places, self.transitions, self.outside = every, places, transitions, outside
        self.by_section = {copy.section.name: copy for copy in every}

    def numbering(self, kind: Kind) -> Numbering:
        """Where their places, or their transitions, lie."""
        return self.places if kind == "places" else self.transitions

    def entry(self, route: str) -> Sequence[int]:
        """The numbers of the places that a route marks."""
        copy = self.by_section.get(route)
        return self.outside[route] if copy is None else copy.stencil.entered(copy)

    def place(self, copy: int, number: int) -> Place:
        """Draws a place of a copy."""
        return self.every[copy].stencil.place(self.every[copy], number)

    def transition(self, copy: int, number: int) -> Transition:
        """Draws a transition of a copy."""
        return self.every[copy].stencil.transition(self.every[copy], number, self.entry)


class CopiedNet(PetriNet):
    """A net with copies; with other fields (:func:`dataclasses.replace`) it is a net as any other.

    Attributes:
        copies: The copies.
    """

    copies: CopiedSections
    _places: Sequence[Place]
    _transitions: Nodes[Transition]

    def __new__(cls, *fields: Any, **named: Any) -> Any:
        """A net of the given fields, which has no copies."""
        return PetriNet(*fields, **named)

    @staticmethod
    def of(
        name: str,
        places: Sequence[Place],
        transitions: Sequence[Transition],
        copies: CopiedSections,
        units: tuple[tuple[int, ...], ...] = (),
    ) -> CopiedNet:
        """The net.

        Args:
            name: Its name.
            places: The places that are of no copy, in their order.
            transitions: The same of transitions.
            copies: The copies.
            units: As in all nets.
        """
        net: CopiedNet = object.__new__(CopiedNet)
        drawn = Nodes(transitions, copies.transitions, copies.transition)
        net.__dict__.update(copies=copies, _places=places, _transitions=drawn)
        PetriNet.__init__(net, name, Nodes(places, copies.places, copies.place), drawn, True, units)
        return net

    def __eq__(self, other: object) -> bool:
        compared = (each.name for each in fields(self) if each.compare)
        return isinstance(other, PetriNet) and all(getattr(self, n) == getattr(other, n) for n in compared)

    def __hash__(self) -> int:
        return super().__hash__()

    def __reduce__(self) -> tuple[Any, ...]:
        every = self.name, tuple(self.places), tuple(self.transitions), self.priorities, self.units
        return PetriNet, every

    def transitions_of_no_copy(self) -> Iterator[tuple[int, Transition]]:
        """The transitions that are of no copy, with their numbers."""
        return zip(self.copies.transitions.directly(), self._transitions.direct, strict=True)

    def elements_of_no_copy(self, kind: Kind) -> Iterator[tuple[int, Provenance | None]]:
        """What has made the places, or the transitions, that are of no copy, with their numbers."""
        nodes: Sequence[Place | Transition] = self._places if kind == "places" else self._transitions.direct
        return zip(self.copies.numbering(kind).directly(), (one.provenance for one in nodes), strict=True)

    @cached_property
    def _rarest_known(self) -> dict[int, dict[int, tuple[bool, int]]]:
        """By stencil and transition, whether its rarest place is one of the copy, and which."""
        return {}

    @cached_property
    def initial(self) -> Marking:
        """The initial marking."""
        marking = [0] * len(self.places)
        for number, place in zip(self.copies.places.directly(), self._places, strict=True):
            marking[number] = place.initial
        for copy in self.copies.every:
            for number, tokens in copy.stencil.initial:
                marking[copy.place + number] = tokens
        return tuple(marking)

    @cached_property
    def events(self) -> EventIndex:
        """Which transitions carry which event."""
        every, direct = self.copies.every, [transition.event for transition in self._transitions.direct]
        return EventIndex(self.copies.transitions.row(direct, lambda c: every[c].stencil.events(every[c])))

    @cached_property
    def ranks(self) -> tuple[int, ...]:
        """The rank of each transition, :data:`mcpn.nets.petri.EVENTS` for events."""
        every = self.copies.every
        direct = [t.rank if t.internal else EVENTS for t in self._transitions.direct]
        return tuple(self.copies.transitions.row(direct, lambda c: every[c].stencil.ranks))

    @cached_property
    def internal_users(self) -> Mapping[int, Sequence[int]]:
        """The internal transitions that consume or read each place, where there are some."""
        return _Users(self.copies, self.transitions_of_no_copy())

    def _crowded(self, most: int) -> list[int]:
        users = self.internal_users
        assert isinstance(users, _Users)
        return users.crowded(most)

    def _rarest(self, transition: int) -> int:
        number, within = self.copies.transitions.at(transition)
        if number is None:
            return super()._rarest(transition)
        copy = self.copies.every[number]
        known = self._rarest_known.setdefault(id(copy.stencil), {})
        if within not in known:
            found = super()._rarest(transition)
            own = self.copies.places.at(found)[0] == number
            known[within] = own, found - copy.place if own else found
        own, place = known[within]
        return copy.place + place if own else place

    def event(self, transition: int) -> Event | None:
        """The event of a transition."""
        number, within = self.copies.transitions.at(transition)
        if number is None:
            one = self._transitions.direct[within]
            return one.event
        if self._transitions.drawn:
            return super().event(transition)
        return (copy := self.copies.every[number]).stencil.event(copy, within)

    def arcs(self, transition: int) -> tuple[Arcs, Arcs, Arcs]:
        """What a transition consumes, produces and reads."""
        number, within = self.copies.transitions.at(transition)
        if number is None:
            one = self._transitions.direct[within]
            return one.consume, one.produce, one.read
        if self._transitions.drawn:
            return super().arcs(transition)
        return (copy := self.copies.every[number]).stencil.arcs(copy, within, self.copies.entry)

    def needs(self, transition: int) -> Arcs:
        """What a transition consumes, and what it reads."""
        number, within = self.copies.transitions.at(transition)
        if number is None:
            one = self._transitions.direct[within]
            return (*one.consume, *one.read)
        if self._transitions.drawn:
            return super().needs(transition)
        return (copy := self.copies.every[number]).stencil.needs(copy, within)

    def origin(self, place: int) -> Provenance | None:
        """What has made a place."""
        number, within = self.copies.places.at(place)
        if number is None:
            return self._places[within].provenance
        return (copy := self.copies.every[number]).stencil.origin(copy, within)

    def consuming(self, places: Collection[int]) -> Mapping[int, Sequence[int]]:
        """By some places, none of which is of a copy, the transitions that consume from them."""
        found: dict[int, list[int]] = {}
        for t, transition in self.transitions_of_no_copy():
            for place, _ in transition.consume:
                if place in places:
                    found.setdefault(place, []).append(t)
        for copy in self.copies.every:
            for place, consumers in copy.stencil.consumers.items():
                if place in places:
                    found.setdefault(place, []).extend(copy.transition + n for n in consumers)
        return {place: sorted(transitions) for place, transitions in found.items()}

    def extended(
        self,
        changed: Mapping[int, Transition],
        places: Sequence[Place],
        transitions: Sequence[Transition],
        units: Sequence[tuple[int, ...]] = (),
    ) -> PetriNet:
        """The net with some transitions changed, and with more nodes after all that it has."""
        copies, kept = self.copies, list(self._transitions.direct)
        for number, transition in changed.items():
            copy, within = copies.transitions.at(number)
            if copy is not None:
                return super().extended(changed, places, transitions, units)
            kept[within] = transition
        more = CopiedSections(
            copies.every,
            copies.places.extended(len(places)),
            copies.transitions.extended(len(transitions)),
            copies.outside,
        )
        every = [*self._places, *places], [*kept, *transitions]
        return CopiedNet.of(self.name, *every, more, (*self.units, *units))


def of_no_copy(net: PetriNet) -> Iterator[tuple[int, Transition]]:
    """The transitions of a net that are of no copy, with their numbers."""
    return net.transitions_of_no_copy() if isinstance(net, CopiedNet) else enumerate(net.transitions)


def elements_of_no_copy(net: PetriNet, kind: Kind) -> Iterator[tuple[int, Provenance | None]]:
    """What has made the places, or the transitions, of a net that are of no copy, with their numbers."""
    if isinstance(net, CopiedNet):
        return net.elements_of_no_copy(kind)
    nodes: Sequence[Place | Transition] = net.places if kind == "places" else net.transitions
    return enumerate(one.provenance for one in nodes)


class _Users(Mapping[int, Sequence[int]]):
    """By place, the internal transitions that need it; those of places of copies are found when asked for."""

    def __init__(self, copies: CopiedSections, direct: Iterator[tuple[int, Transition]]) -> None:
        self._copies = copies
        shared: dict[int, list[int]] = {}
        for number, t in direct:
            for place, _ in (*t.consume, *t.read) if t.internal else ():
                shared.setdefault(place, []).append(number)
        outer = {
            id(stencil): [(stencil.fixed(n), users) for n, users in stencil.users.items() if n >= stencil.own]
            for stencil in {id(copy.stencil): copy.stencil for copy in copies.every}.values()
        }
        for copy in copies.every:
            for place, users in outer[id(copy.stencil)]:
                shared.setdefault(place, []).extend([copy.transition + n for n in users])
        self._shared = {place: sorted(users) for place, users in shared.items()}

    def __getitem__(self, place: int) -> Sequence[int]:
        number, within = self._copies.places.at(place)
        if number is None:
            return self._shared[place]
        copy = self._copies.every[number]
        own = [copy.transition + n for n in copy.stencil.users.get(within, ())]
        users = sorted((*own, *self._shared.get(place, ())))
        if not users:
            raise KeyError(place)
        return users

    def __iter__(self) -> Iterator[int]:
        of_copies = (
            copy.place + n for copy in self._copies.every for n in copy.stencil.users if n < copy.stencil.own
        )
        return iter({*self._shared, *of_copies})

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def crowded(self, most: int) -> list[int]:
        """The places that more of them need than a number."""
        found = {place for place, users in self._shared.items() if len(users) > most}
        for copy in self._copies.every:
            many = (n for n, users in copy.stencil.users.items() if len(users) > most)
            found.update(copy.place + n for n in many if n < copy.stencil.own)
        return sorted(found)


class Copying:
    """CopiedSections in the making.

    Args:
        canvas: Where all other parts of the mission are drawn.
    """

    def __init__(self, canvas: Canvas) -> None:
        self._canvas = canvas
        self._copies = list[Copy]()
        self._led: dict[str, Sequence[str]] = {}
        self._places, self._transitions = 0, 0  # in copies so far

    def copy(self, stencil: Stencil, section: Section) -> None:
        """Puts a copy of what is drawn of a section after all that is there."""
        places, drafts = self._canvas.drawn
        first = len(places) + self._places, len(drafts) + self._transitions
        self._copies.append(Copy(stencil, section, *first))
        self._places += stencil.own
        self._transitions += len(stencil.transitions)

    def led(self, route: str, places: Sequence[str]) -> None:
        """Notes what a route marks, of which what is no copy makes use, or which leads to no copy."""
        self._led[route] = places

    def finish(self) -> tuple[PetriNet, Mapping[str, int], Mapping[int, Role]]:
        """The net, the numbers of the places that are of no copy, and what the places of copies say."""
        canvas, every = self._canvas, self._copies
        places, drafts = canvas.drawn
        of_places, of_transitions = (
            Numbering([c.first(kind) for c in every], [c.stencil.size(kind) for c in every], len(drawn))
            for kind, drawn in zip(KINDS, (places, drafts), strict=True)
        )
        index = {place.name: n for place, n in zip(places, of_places.directly(), strict=True)}
        stencils = {id(copy.stencil): copy.stencil for copy in every}.values()
        ranks = numbered_ranks(canvas.internal_ranks.union(*(stencil.internal_ranks for stencil in stencils)))
        for stencil in stencils:
            stencil.put(index, ranks)
        by_section, known, outside = {c.section.name: c for c in every}, dict(index), {}
        for route, names in self._led.items():
            if (copy := by_section.get(route)) is None:
                outside[route] = [index[name] for name in names]
            else:
                known |= zip(names, copy.stencil.entered(copy), strict=True)
        copies = CopiedSections(every, of_places, of_transitions, outside)
        transitions = list(canvas.transitions_at(known, ranks))
        net = CopiedNet.of(canvas.name, list(places), transitions, copies, canvas.units_at(known))
        canvas.names.note_later(lambda: {w: n for c in every for w, n in c.stencil.given(c).items()})
        return net, index, dict(said for copy in every for said in copy.stencil.roles(copy))
