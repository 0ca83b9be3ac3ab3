"""Sections of one type are drawn once: what is drawn of one is copied for the others, under other names.

A section is drawn on a canvas of its own, with marks in the place of what its routes lead to. All that this
puts there is called after elements of the section; arcs lead to that, to marks, and to places of what is the
same for all sections of the type. A copy is called after the elements of another section, and its arcs lead
to the places that mark the beginning of what that one leads to.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import NamedTuple, TypeAlias

from mcpn.drawing.templates.canvas import Canvas, Role, RoleName
from mcpn.drawing.templates.level import element_of
from mcpn.drawing.templates.names import NetNames
from mcpn.events import ENDING, Event
from mcpn.mission.flatten import ObjectivesGraph, Section
from mcpn.mission.graph import names_in
from mcpn.nets.petri import Draft, Place
from mcpn.nets.provenance import Provenance

_Side: TypeAlias = Sequence[tuple[int, int]]
"""Numbers of places, each with its weight."""


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


class Stencil:
    """What is drawn of one section, to be copied for others of its type.

    Args:
        canvas: The section alone.
        section: It.
        marks: By route, the mark that stands for what it leads to.

    Raises:
        NotCopied: See there.
    """

    def __init__(self, canvas: Canvas, section: Section, marks: Sequence[str]) -> None:
        if canvas.meetings:
            raise NotCopied
        self._elements = {name: number for number, name in enumerate(names_in(section))}
        self._origins = {(o.kind, o.name): number for number, o in enumerate(_origins(section))}
        self._names = canvas.names
        places, drafts = canvas.drawn
        self._numbers = {place.name: number for number, place in enumerate(places)}
        self._places = [self._place(place, canvas.roles.get(place.name)) for place in places]
        self._transitions = [self._transition(name, draft) for name, draft in drafts.items()]
        self._others = [*self._numbers][len(self._places) :]
        self._marks = {self._numbers[mark]: n for n, mark in enumerate(marks) if mark in self._numbers}

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
        return [(numbers.setdefault(place, len(numbers)), weight) for place, weight in weights.items()]

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

    def copy(self, canvas: Canvas, section: Section, led: Sequence[Collection[str]]) -> None:
        """Draws another section.

        Args:
            canvas: Where to draw.
            section: One of the type.
            led: By route, the places that are marked where it is taken.
        """
        elements, origins = list(names_in(section)), _origins(section)
        called, names = _Naming(canvas.names, elements), list[str]()
        for one, initial, origin, role in self._places:
            names.append(name := called(one))
            canvas.add_place(Place(name, initial, origins[origin]))
            if role is not None:
                canvas.role(name, (role[0], elements[role[1]]))
        canvas.names.note_later(partial(self._given, called))
        names += self._others
        marks = {number: led[route] for number, route in self._marks.items()}

        def arcs(side: _Side) -> Mapping[str, int]:
            if marks.keys().isdisjoint([number for number, _ in side]):
                return {names[number]: weight for number, weight in side}
            weights: dict[str, int] = {}
            for number, weight in side:
                for place in marks[number] if number in marks else (names[number],):
                    weights[place] = weights.get(place, 0) + weight
            return weights

        for one, sides, event, ended, rank, origin in self._transitions:
            happens = event if event is None or ended is None else event.of(elements[ended])
            consume, produce, read = map(arcs, sides)
            canvas.add_draft(called(one), ((consume, produce, read), happens, rank, origins[origin]))

    def _given(self, called: _Naming) -> Mapping[tuple[str, ...], str]:
        """What the names in a copy are given to."""
        ones = [*(place.called for place in self._places), *(t.called for t in self._transitions)]
        return {called.whole(one): called(one) for one in ones}


class _Naming:
    """What parts of a section's elements are called.

    Args:
        names: All names of the mission.
        elements: Those of the section, by their numbers.
    """

    def __init__(self, names: NetNames, elements: Sequence[str]) -> None:
        self._names = names
        self._elements = elements
        self._stems = dict[tuple[str, int], str | None]()

    def whole(self, one: _Called) -> tuple[str, ...]:
        """What a name is given to, under this section's elements."""
        return one.kind, self._elements[one.element], *one.part

    def __call__(self, one: _Called) -> str:
        kind, element, part = one
        if (kind, element) not in self._stems:
            self._stems[kind, element] = self._names.stem(kind, self._elements[element])
        stem = self._stems[kind, element]
        if stem is None or len(part) > 1:
            return self._names.of(*self.whole(one))
        return f"{stem}_{part[0]}" if part else stem


def _origins(section: Section) -> list[Provenance]:
    """The elements that what is drawn of a section comes from."""
    every = ObjectivesGraph((section,), section.name).all_sections()
    return [Provenance(*element_of(inner), inner.source) for inner in every]
