"""Sections of one type are drawn once: what is drawn of one stands for the others, under other names.

A section is drawn on a canvas of its own, with marks in the place of what its routes lead to. All that this
puts there is called after elements of the section; arcs lead to that, to marks, and to places of what is the
same for all sections of the type. A copy is called after the elements of another section, and its arcs lead
to the places that mark the beginning of what that one leads to. It need not be drawn for its places and
transitions to have numbers (:mod:`mcpn.drawing.templates.copied`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

from mcpn.drawing.templates.canvas import Canvas, Role, RoleName
from mcpn.drawing.templates.level import element_of
from mcpn.drawing.templates.net_names import NetNames
from mcpn.events import ENDING, Event
from mcpn.mission.core.objectives_graph import ObjectivesGraph, Section, names_in
from mcpn.nets.petri import EVENTS, Arcs, Draft, Place, Transition
from mcpn.nets.provenance import Provenance

_Side: TypeAlias = Sequence[tuple[int, int]]
"""Numbers of places, each with its weight."""

Kind = Literal["places", "transitions"]

Entry: TypeAlias = Callable[[str], Sequence[int]]
"""By route, the numbers of the places that are marked where it is taken."""


class NotCopied(Exception):
    """What is drawn of a section is not all called after one of its elements each: it is drawn by itself."""


class _Called(NamedTuple):
    """What a name is given to: a part of an element of the section, by the element's number."""

    kind: str
    element: int
    part: tuple[str, ...]


class _DrawnPlace(NamedTuple):
    called: _Called
    initial: int
    origin: int
    role: tuple[RoleName, int] | None


class _DrawnTransition(NamedTuple):
    called: _Called
    sides: tuple[_Side, _Side, _Side]
    event: Event | None
    ended: int | None
    rank: int
    origin: int


class Copy(NamedTuple):
    """A section that is drawn as another one of its type is.

    Args:
        stencil: What is drawn of that one.
        section: The section.
        place: The number of its first place in the whole net.
        transition: The number of its first transition.
    """

    stencil: Stencil
    section: Section
    place: int
    transition: int

    def first(self, kind: Kind) -> int:
        """The number of its first place, or of its first transition."""
        return self.place if kind == "places" else self.transition


class Stencil:
    """What is drawn of one section, to be copied for others of its type.

    A number of a place here is that of one of its own or, from :attr:`own` on, of another one.

    Args:
        canvas: The section alone.
        section: It.
        marks: By route, the mark that stands for what it leads to.
        entered: The places that are marked where the section is entered.

    Attributes:
        own: How many places it has.
        entry: The numbers of ``entered``.
        others: The places of others, by their numbers less :attr:`own`.

    Raises:
        NotCopied: See there.
    """

    def __init__(
        self, canvas: Canvas, section: Section, marks: Sequence[str], entered: Sequence[str]
    ) -> None:
        if canvas.meetings:
            raise NotCopied
        self._elements = {name: number for number, name in enumerate(names_in(section))}
        self._origins = {(o.kind, o.name): number for number, o in enumerate(_origins(section))}
        self._names = canvas.names
        places, drafts = canvas.drawn
        self._numbers = {place.name: number for number, place in enumerate(places)}
        self.places = [self._place(place, canvas.roles.get(place.name)) for place in places]
        self.transitions = [self._transition(name, draft) for name, draft in drafts.items()]
        self.own = len(self.places)
        self.entry = [number for number, _ in self._side(dict.fromkeys(entered, 1))]
        self._marks = {self._numbers[mark]: n for n, mark in enumerate(marks) if mark in self._numbers}
        needed = (side for one in self.transitions for side in (one.sides[0], one.sides[2]))
        if any(number in self._marks for side in needed for number, _ in side):
            raise NotCopied
        self.others = [*self._numbers][self.own :]
        self._fixed: Sequence[int] = ()
        self._ranks: Mapping[int, int] = {}

    def _place(self, place: Place, role: Role | None) -> _DrawnPlace:
        said = None if role is None else (role[0], self._element(role[1]))
        return _DrawnPlace(self._called(place.name), place.initial, self._origin(place.provenance), said)

    def _transition(self, name: str, draft: Draft) -> _DrawnTransition:
        (consume, produce, read), event, rank, origin = draft
        ended = self._element(event.element) if event is not None and event.what in ENDING else None
        sides = self._side(consume), self._side(produce), self._side(read)
        return _DrawnTransition(self._called(name), sides, event, ended, rank, self._origin(origin))

    def _side(self, weights: Mapping[str, int]) -> _Side:
        numbers = self._numbers
        every = [(numbers.setdefault(place, len(numbers)), weight) for place, weight in weights.items()]
        return [each for each in every if each[1]]

    def _called(self, name: str) -> _Called:
        kind, element, *part = self._names.meaning(name) or ("", "")
        if not self._elements.keys().isdisjoint(part[1:]):
            raise NotCopied
        return _Called(kind, self._element(element), tuple(part))

    def _element(self, name: str) -> int:
        if name not in self._elements:
            raise NotCopied
        return self._elements[name]

    def _origin(self, origin: Provenance | None) -> int:
        if origin is None or (origin.kind, origin.name) not in self._origins:
            raise NotCopied
        return self._origins[origin.kind, origin.name]

    def size(self, kind: Kind) -> int:
        """How many places, or transitions, it has."""
        return self.own if kind == "places" else len(self.transitions)

    @property
    def internal_ranks(self) -> set[int]:
        """The ranks of its internal transitions, as they are drawn."""
        return {one.rank for one in self.transitions if one.event is None}

    def put(self, index: Mapping[str, int], ranks: Mapping[int, int]) -> None:
        """Puts it into a net: by place of others its number there, and by rank that of its order."""
        marks = {number - self.own for number in self._marks}
        self._fixed = [-1 if n in marks else index[name] for n, name in enumerate(self.others)]
        self._ranks = ranks

    def numbers(self, side: _Side, first: int) -> Iterator[int]:
        """The numbers of places in the net, in a copy whose first place has one; not for what routes mark."""
        return (first + n if n < self.own else self._fixed[n - self.own] for n, _ in side)

    def entered(self, copy: Copy) -> tuple[int, ...]:
        """The numbers of the places that are marked where a copy is entered."""
        return tuple(self.numbers([(number, 1) for number in self.entry], copy.place))

    def place(self, copy: Copy, number: int) -> Place:
        """Draws a place of a copy."""
        called, initial, origin, _ = self.places[number]
        return Place(self._naming(copy)(called), initial, _origins(copy.section)[origin])

    def transition(self, copy: Copy, number: int, entry: Entry) -> Transition:
        """Draws a transition of a copy."""
        called, _, _, _, rank, origin = self.transitions[number]
        event, naming = self.event(copy, number), self._naming(copy)
        consume, produce, read = self.arcs(copy, number, entry)
        order = self._ranks[rank] if event is None else 0
        made = _origins(copy.section)[origin]
        return Transition(naming(called), consume, produce, read, event, order, made)

    def _naming(self, copy: Copy) -> _Naming:
        return _Naming(self._names, list(names_in(copy.section)))

    def event(self, copy: Copy, number: int) -> Event | None:
        """The event of a transition of a copy."""
        _, _, event, ended, _, _ = self.transitions[number]
        if event is None or ended is None:
            return event
        return event.of(list(names_in(copy.section))[ended])

    def origin(self, copy: Copy, number: int) -> Provenance:
        """What has made a place of a copy."""
        return _origins(copy.section)[self.places[number].origin]

    def arcs(self, copy: Copy, number: int, entry: Entry) -> tuple[Arcs, Arcs, Arcs]:
        """What a transition of a copy consumes, produces and reads."""
        consume, produce, read = self.transitions[number].sides
        arcs = self._arcs
        return arcs(copy, consume, entry), arcs(copy, produce, entry), arcs(copy, read, entry)

    def needs(self, copy: Copy, number: int) -> Arcs:
        """What a transition of a copy consumes, and what it reads."""
        others, own = self._needs[number]
        first = copy.place
        return (*others, *[(first + place, weight) for place, weight in own])

    @cached_property
    def _needs(self) -> Sequence[tuple[Sequence[tuple[int, int]], Sequence[tuple[int, int]]]]:
        """By transition what it needs of others, by number in the net, and of its own."""
        every = [(*one.sides[0], *one.sides[2]) for one in self.transitions]
        return [
            (
                [(self.fixed(n), weight) for n, weight in side if n >= self.own],
                [(n, weight) for n, weight in side if n < self.own],
            )
            for side in every
        ]

    def _arcs(self, copy: Copy, side: _Side, entry: Entry) -> Arcs:
        if not side:
            return ()
        marks, weights = self._marks, dict[int, int]()
        for number, weight in side:
            if number in marks:
                routes = list(dict.fromkeys(copy.section.routes))
                for place in entry(routes[marks[number]]):
                    weights[place] = weights.get(place, 0) + weight
            else:
                place = copy.place + number if number < self.own else self._fixed[number - self.own]
                weights[place] = weights.get(place, 0) + weight
        return tuple(sorted(weights.items()))

    def roles(self, copy: Copy) -> Iterator[tuple[int, Role]]:
        """The places of a copy that say something, by their numbers."""
        elements = list(names_in(copy.section))
        return ((copy.place + n, (said, elements[of])) for n, said, of in self._saying)

    @cached_property
    def _saying(self) -> Sequence[tuple[int, RoleName, int]]:
        return [(n, *place.role) for n, place in enumerate(self.places) if place.role is not None]

    @cached_property
    def initial(self) -> Sequence[tuple[int, int]]:
        """Its places that hold tokens in the initial marking, with their number."""
        return [(n, place.initial) for n, place in enumerate(self.places) if place.initial]

    def events(self, copy: Copy) -> list[Event | None]:
        """The event of each transition of a copy."""
        elements = list(names_in(copy.section))
        return [
            one.event if one.event is None or one.ended is None else one.event.of(elements[one.ended])
            for one in self.transitions
        ]

    @cached_property
    def ranks(self) -> Sequence[int]:
        """The rank of each transition in the net, :data:`mcpn.nets.petri.EVENTS` for events."""
        return [self._ranks[one.rank] if one.event is None else EVENTS for one in self.transitions]

    @cached_property
    def users(self) -> Mapping[int, Sequence[int]]:
        """The internal transitions that consume or read each place: by its number here."""
        return self._using([(n, (0, 2)) for n, one in enumerate(self.transitions) if one.event is None])

    @cached_property
    def consumers(self) -> Mapping[int, Sequence[int]]:
        """The transitions that consume from each place of others: by its number in the net."""
        using = self._using([(n, (0,)) for n in range(len(self.transitions))])
        return {self.fixed(place): found for place, found in using.items() if place >= self.own}

    def fixed(self, number: int) -> int:
        """The number in the net of a place of others."""
        return self._fixed[number - self.own]

    def _using(self, sides: Sequence[tuple[int, tuple[int, ...]]]) -> dict[int, list[int]]:
        found: dict[int, list[int]] = {}
        for number, which in sides:
            for side in which:
                for place, _ in self.transitions[number].sides[side]:
                    found.setdefault(place, []).append(number)
        return found

    def of_element(self, kind: Kind, copy: Copy) -> dict[tuple[str, str], list[int]]:
        """The numbers of the places, or transitions, of a copy by the element that they come from."""
        first, origins = copy.first(kind), [(o.kind, o.name) for o in _origins(copy.section)]
        found: dict[tuple[str, str], list[int]] = {}
        drawn: Sequence[_DrawnPlace | _DrawnTransition] = (
            self.places if kind == "places" else self.transitions
        )
        for number, one in enumerate(drawn):
            found.setdefault(origins[one.origin], []).append(first + number)
        return found

    def given(self, copy: Copy) -> Mapping[tuple[str, ...], str]:
        """What the names in a copy are given to."""
        naming = self._naming(copy)
        ones = [*(place.called for place in self.places), *(t.called for t in self.transitions)]
        return {naming.whole(one): naming(one) for one in ones}


class _Naming:
    """What parts of a section's elements are called.

    Args:
        names: All names of the mission.
        elements: Those of the section, by their numbers.
    """

    def __init__(self, names: NetNames, elements: Sequence[str]) -> None:
        self._names = names
        self._elements = elements

    def whole(self, one: _Called) -> tuple[str, ...]:
        """What a name is given to, under this section's elements."""
        return one.kind, self._elements[one.element], *one.part

    def __call__(self, one: _Called) -> str:
        kind, element, part = one
        stem = self._names.stem(kind, self._elements[element])
        if stem is None or len(part) > 1:
            return self._names.of(*self.whole(one))
        return f"{stem}_{part[0]}" if part else stem


def _origins(section: Section) -> list[Provenance]:
    """The elements that what is drawn of a section comes from."""
    every = ObjectivesGraph((section,), section.name).all_sections()
    return [Provenance(*element_of(inner), inner.source) for inner in every]
