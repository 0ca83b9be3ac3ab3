"""Sections glued at their interface: steps and closures of the composite.

A state of the whole is a section, a state of its local net, and the state of the hardware beside it; before
and after the mission there is the state of the hardware alone. What one section hands to the next is its exit
and the state of all hardware.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache, cached_property

import numpy as np

from mcpn._kernel import Zdd
from mcpn.net.events import What
from mcpn.space.algebra import Guards
from mcpn.space.local.layout import Layout
from mcpn.space.local.local_states import ALL, Allowed, Exit, beside
from mcpn.space.local.sections import BEGIN, ENDS, Elements, PlacedSection
from mcpn.space.local.sets import CompositeSet, Waiting


class Glued:
    """The sections of a mission, glued.

    Args:
        elements: The net of the whole mission by its elements; it is not explored.
        layout: The diagram store.
        sections: Every section with its type, in document order.
    """

    def __init__(self, elements: Elements, layout: Layout, sections: Sequence[PlacedSection]) -> None:
        self.elements = elements
        self.mission_net = elements.mission_net
        self.net = self.mission_net.net
        self.layout = layout
        self.sections = {placed.name: placed for placed in sections}
        self.nothing = CompositeSet(self, {})
        self._order = {name: i for i, name in enumerate((BEGIN, *self.sections, *ENDS))}
        self.into: dict[str, list[tuple[str, Exit]]] = {}
        for placed in sections:
            for exit_, route in placed.routes.items():
                self.into.setdefault(route, []).append((placed.name, exit_))
        entry = self.mission_net.graph.entry
        self.into.setdefault(entry, []).append((BEGIN, "success"))

    def in_order(self, names: Iterable[str]) -> list[str]:
        """Names of sections, and of what is before and after them, in the mission's order."""
        return sorted(names, key=self._order.__getitem__)

    def closed(self, name: str, part: Zdd) -> Zdd:
        """A part of a set with the section's own slots unmarked, so that each state is there once."""
        placed = self.sections.get(name)
        return part if placed is None else part.subset(unmarked=placed.slots)

    def of(self, parts: Mapping[str, Zdd]) -> CompositeSet:
        """The set of some parts, of which some may be empty."""
        return CompositeSet(self, {name: part for name, part in parts.items() if part})

    @cached_property
    def initial(self) -> CompositeSet:
        """The state before the mission with all hardware in service."""
        return CompositeSet(self, {BEGIN: self.layout.store.singleton([])})

    @cached_property
    def everything(self) -> CompositeSet:
        """All reachable states."""
        return self._reached(self.initial, None)

    @cached_property
    def stable(self) -> CompositeSet:
        """All states: each is stable."""
        return self.everything

    @cached_property
    def toggles(self) -> dict[str, dict[str, int]]:
        """By hardware, the transitions of the whole net with which it fails and so on while idle."""
        kinds = {What.OUT_OF_SERVICE: "fails", What.REPAIRED: "repaired", What.LOST: "dies"}
        found: dict[str, dict[str, int]] = {name: {} for name in self.layout.hardware}
        initial = self.net.initial
        for t, transition in enumerate(self.net.transitions):
            event = transition.event
            if event is None or event.what not in kinds or event.element not in found:
                continue
            if event.what is What.OUT_OF_SERVICE and not all(initial[p] for p, _ in transition.consume):
                continue  # the failure of a resource in use
            found[event.element][kinds[event.what]] = t
        return found

    def filtered(
        self, transitions: Collection[int] | None, guards: Guards[CompositeSet] = None
    ) -> Callable[[str], Allowed]:
        """What edges may carry, as each section sees it; guards are of sections' events."""
        if transitions is None and not guards:
            return lambda name: ALL
        wanted, limits = None if transitions is None else frozenset(transitions), guards or {}
        pairs = None if wanted is None else self._toggled_by(wanted)

        def of(name: str) -> Allowed:
            if name not in self.sections:
                start = wanted is None or self.mission_net.start in wanted
                return Allowed(None if start else frozenset(), pairs)
            placed, local = self.sections[name], None
            if wanted is not None:
                local = frozenset([own for own, t in enumerate(placed.transitions) if t in wanted])
            guarded = [(own, t) for own, t in enumerate(placed.transitions) if t in limits] if limits else []
            empty = self.layout.store.empty()
            return Allowed(local, pairs, tuple((own, limits[t].parts.get(name, empty)) for own, t in guarded))

        return cache(of)

    def _toggled_by(self, wanted: frozenset[int]) -> frozenset[tuple[str, str]]:
        """Idle hardware with the kinds of its events that some transitions carry."""
        return frozenset(
            (name, kind) for name, kinds in self.toggles.items() for kind, t in kinds.items() if t in wanted
        )

    def entries(self, name: str, inside: Zdd) -> Zdd:
        """The states of all hardware with which a section, or an end, is entered in some of its states."""
        placed = self.sections.get(name)
        return inside if placed is None else placed.type.entries(inside, placed.faulty)

    def enter(self, name: str, hardware: Zdd) -> Zdd:
        """First states of a section, or of an end, entered with all hardware in some states."""
        placed = self.sections.get(name)
        return hardware if placed is None else placed.type.entered(hardware, placed.faulty)

    def leaving(self, before: str, exit_: Exit, hardware: Zdd, allowed: Allowed) -> Zdd:
        """States with an event that ends a section by an exit with all hardware in some states."""
        if before == BEGIN:
            start = allowed.local is None or bool(allowed.local)
            return hardware if start else self.layout.store.empty()
        placed = self.sections[before]
        ended = placed.type.from_slots(hardware, placed.faulty, exit_) & placed.type.ended[exit_]
        return placed.type.before_step(ended, allowed)

    def before(
        self,
        states: CompositeSet,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States with an edge into some states."""
        allowed, found = self.filtered(transitions, guards), dict[str, Zdd]()

        def add(name: str, part: Zdd) -> None:
            part = part & self.everything.parts.get(name, self.layout.store.empty())
            if part:
                found[name] = found[name] | part if name in found else part

        for name, part in states.parts.items():
            placed = self.sections.get(name)
            if placed is not None:
                add(name, placed.type.before_step(part, allowed(name)))
            add(name, part.images(self.beside_it(name, allowed(name), undone=True)))
            for before, exit_ in self.into.get(name, ()):
                if allowed(before).local != frozenset():
                    add(before, self.leaving(before, exit_, self.entries(name, part), allowed(before)))
        return CompositeSet(self, found)

    def after(
        self,
        states: CompositeSet,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States that an edge leads to from some states."""
        allowed, found = self.filtered(transitions, guards), dict[str, Zdd]()

        def add(name: str, part: Zdd) -> None:
            if part:
                found[name] = found[name] | part if name in found else part

        for name, part in states.parts.items():
            inside, leaving = self.step(name, part, allowed(name))
            add(name, inside)
            add(name, part.images(self.beside_it(name, allowed(name), undone=False)))
            for route, hardware in leaving:
                add(route, self.enter(route, hardware))
        return CompositeSet(self, found)

    def step(self, name: str, part: Zdd, allowed: Allowed) -> tuple[Zdd, list[tuple[str, Zdd]]]:
        """States of the section one of its own events later, and how all hardware is where it ends."""
        if name in ENDS:
            return self.layout.store.empty(), []
        if name == BEGIN:
            start = allowed.local is None or bool(allowed.local)
            return self.layout.store.empty(), [(self.mission_net.graph.entry, part)] if start else []
        placed = self.sections[name]
        after = placed.type.after(part, allowed)
        leaving = [
            (route, placed.type.to_slots(ended, placed.faulty, exit_))
            for exit_, route in placed.routes.items()
            if (ended := after & placed.type.ended[exit_])
        ]
        return after & placed.type.inside, leaving

    def reaching(
        self,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        within = (self.everything if along is None else along).parts
        allowed = self.filtered(transitions, guards)
        found = dict(goal.parts)
        waiting = Waiting(found, lambda name: -self._order[name])
        for name in waiting:
            found[name] = self.reaching_inside(name, found[name], within.get(name), allowed(name))
            entries = self.entries(name, found[name])
            for before, exit_ in self.into.get(name, ()):
                if before in within:
                    waiting.widen(
                        before, self.leaving(before, exit_, entries, allowed(before)) & within[before]
                    )
        return self.of(found)

    def reaching_inside(self, name: str, goal: Zdd, along: Zdd | None, allowed: Allowed) -> Zdd:
        """The closure within one section, or within what is before or after them."""
        if along is None:
            return goal
        placed = self.sections.get(name)
        if placed is not None:
            return placed.type.reaching(goal, along, allowed)
        return goal.saturate(beside(self.layout, allowed, undone=True), within=along | goal)

    def reached(
        self,
        begin: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        return self._reached(begin, self.everything if along is None else along, transitions, guards)

    def _reached(
        self,
        begin: CompositeSet,
        along: CompositeSet | None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> CompositeSet:
        """The same; without ``along`` through all that local nets allow."""
        allowed = self.filtered(transitions, guards)

        def within(name: str) -> Zdd | None:
            if along is not None:
                return along.parts.get(name)
            placed = self.sections.get(name)
            return self.layout.universe if placed is None else placed.type.inside

        found = {
            name: part & room for name, part in begin.parts.items() if (room := within(name)) is not None
        }
        found = {name: part for name, part in found.items() if part}
        waiting = Waiting(found, self._order.__getitem__)
        for name in waiting:
            room, placed = within(name), self.sections.get(name)
            assert room is not None, "only parts of what runs may pass are found"
            if placed is not None:
                found[name] = placed.type.reached(found[name], room, allowed(name))
            else:
                toggles = beside(self.layout, allowed(name), undone=False)
                found[name] = found[name].saturate(toggles, within=room)
            for route, hardware in self.step(name, found[name], allowed(name))[1]:
                onward = within(route)
                if onward is not None:
                    waiting.widen(route, self.enter(route, hardware) & onward)
        return self.of(found)

    def staying(self, along: CompositeSet, asked: CompositeSet | None = None) -> CompositeSet:
        """States from which some maximal run, endless or ending in a dead state, stays in a set."""
        found = dict((along & self.everything).parts)
        ends = self.dead.parts
        empty = self.layout.store.empty()
        waiting = Waiting(found, lambda name: -self._order[name])
        for name in waiting:
            part, placed = found.get(name, empty), self.sections.get(name)
            onward = empty
            for route, exit_ in self.exits(name):
                if route in found:
                    onward |= self.leaving(name, exit_, self.entries(route, found[route]), ALL)
            dead, before = ends.get(name, empty), None
            while before != part:
                before = part
                ways = part.images(self.beside_it(name, ALL, undone=True))
                if placed is not None:
                    ways |= placed.type.before_step(part)
                part = part & (ways | onward | dead)
            if part != found.get(name, empty):
                found[name] = part
                for earlier, _ in self.into.get(name, ()):
                    if earlier in found:
                        waiting.again(earlier)
        return self.of(found)

    @cached_property
    def dead(self) -> CompositeSet:
        """States in which neither the section nor hardware beside it can do anything."""
        found = {}
        for name, part in self.everything.parts.items():
            placed = self.sections.get(name)
            if name != BEGIN:
                resting = part if placed is None else part & placed.type.dead
                found[name] = resting - self._able(name, resting, ALL) if resting else resting
        return self.of(found)

    def _able(self, name: str, part: Zdd, allowed: Allowed) -> Zdd:
        """Those of some states in which hardware beside the section can do something that is allowed."""
        placed = self.sections.get(name)
        own = set() if placed is None else set(placed.faulty)
        found = self.layout.store.empty()
        for hardware in self.layout.hardware:
            if hardware in own:
                continue
            for kind, (marked, unmarked) in self.layout.needs(hardware).items():
                if allowed.beside is None or (hardware, kind) in allowed.beside:
                    found |= part.subset(marked, unmarked)
        return found

    def beside_it(self, name: str, allowed: Allowed, *, undone: bool) -> list[int]:
        """Events of the store for what hardware beside a section does, or what undoes it.

        Closures may take those of all hardware (:func:`mcpn.space.local.section_type.beside`), since a
        section's own slots are open: they change nothing there, but they would look like steps.
        """
        placed = self.sections.get(name)
        return beside(self.layout, allowed, undone=undone, but=() if placed is None else placed.faulty)

    def exits(self, name: str) -> list[tuple[str, Exit]]:
        """Where a section leads, and by which exit."""
        if name == BEGIN:
            return [(self.mission_net.graph.entry, "success")]
        placed = self.sections.get(name)
        return [] if placed is None else [(route, exit_) for exit_, route in placed.routes.items()]

    def leaving_for(self, name: str, hardware: Zdd) -> CompositeSet:
        """States with an event that enters a section with all hardware in some states."""
        found = self.nothing
        for before, exit_ in self.into.get(name, ()):
            part = self.everything.parts.get(before)
            if part is not None:
                found |= self.of({before: self.leaving(before, exit_, hardware, ALL) & part})
        return found

    def entering(self, placed: PlacedSection) -> Zdd:
        """States before the entry of a section, as the mission comes to enter it."""
        hardware = self.layout.store.empty()
        for before, _ in self.into.get(placed.name, ()):
            part = self.everything.parts.get(before)
            if part is not None:
                for route, states in self.step(before, part, ALL)[1]:
                    if route == placed.name:
                        hardware |= states
        return placed.type.from_slots(hardware, placed.faulty)

    @cached_property
    def regions(self) -> Sequence[CompositeSet]:
        """Sections that lead to each other, and each other section alone: no cycle leaves a region."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        names = list(self.everything.parts)
        number = {name: i for i, name in enumerate(names)}
        pairs = [
            (number[before], number[name])
            for name in names
            for before, _ in self.into.get(name, ())
            if before in number
        ]
        ends = np.array(pairs, np.int64).reshape(-1, 2)
        matrix = coo_matrix((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), (len(names),) * 2)
        _, component = connected_components(matrix.tocsr(), directed=True, connection="strong")
        found: dict[int, dict[str, Zdd]] = {}
        for name, part in self.everything.parts.items():
            found.setdefault(int(component[number[name]]), {})[name] = part
        return [CompositeSet(self, parts) for parts in found.values()]
