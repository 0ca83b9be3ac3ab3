"""Sections glued at their interface: steps and closures of the composite.

A state of the whole is a section, a state of its local net, and the state of the hardware beside it; before
and after the mission there is the state of the hardware alone. What one section hands to the next is its exit
and the state of all hardware.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache, cached_property

from mcpn._kernel import Zdd
from mcpn.net.events import What
from mcpn.space.algebra import Guards
from mcpn.space.local.layout import Layout
from mcpn.space.local.local_states import ALL, Allowed, Exit
from mcpn.space.local.sections import BEGIN, ENDS, Elements, Outside, PlacedSection, Stage
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
        begin, *ends = (Outside(name, self.mission_net, layout) for name in (BEGIN, *ENDS))
        self.stages: dict[str, Stage] = {s.name: s for s in (begin, *sections, *ends)}
        self.nothing = CompositeSet(self, {})
        self._order = {name: i for i, name in enumerate(self.stages)}
        self.into: dict[str, list[tuple[Stage, Exit]]] = {name: [] for name in self.stages}
        for stage in self.stages.values():
            for exit_, route in stage.routes.items():
                self.into[route].append((stage, exit_))

    def in_order(self, names: Iterable[str]) -> list[str]:
        """Names of sections, and of what is before and after them, in the mission's order."""
        return sorted(names, key=self._order.__getitem__)

    def closed(self, name: str, part: Zdd) -> Zdd:
        """A part of a set with the section's own slots unmarked, so that each state is there once."""
        return part.subset(unmarked=self.stages[name].slots)

    def of(self, parts: Mapping[str, Zdd]) -> CompositeSet:
        """The set of some parts, of which some may be empty."""
        return CompositeSet(self, {name: part for name, part in parts.items() if part})

    @cached_property
    def initial(self) -> CompositeSet:
        """The state before the mission with all hardware in service."""
        return CompositeSet(self, {BEGIN: self.stages[BEGIN].entered(self.layout.store.singleton([]))})

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
            whole, empty = self.stages[name].transitions.whole, self.layout.store.empty()
            local = None if wanted is None else frozenset(i for i, t in enumerate(whole) if t in wanted)
            guarded = [(i, t) for i, t in enumerate(whole) if t in limits] if limits else []
            return Allowed(local, pairs, tuple((i, limits[t].parts.get(name, empty)) for i, t in guarded))

        return cache(of)

    def _toggled_by(self, wanted: frozenset[int]) -> frozenset[tuple[str, str]]:
        """Idle hardware with the kinds of its events that some transitions carry."""
        return frozenset(
            (name, kind) for name, kinds in self.toggles.items() for kind, t in kinds.items() if t in wanted
        )

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
            stage = self.stages[name]
            add(name, stage.type.before_step(part, allowed(name)))
            add(name, part.images(stage.beside(allowed(name), undone=True)))
            for before, exit_ in self.into[name]:
                if allowed(before.name).local != frozenset():
                    add(before.name, before.leaving(exit_, stage.entries(part), allowed(before.name)))
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
            stage = self.stages[name]
            inside, leaving = stage.step(part, allowed(name))
            add(name, inside)
            add(name, part.images(stage.beside(allowed(name), undone=False)))
            for route, hardware in leaving:
                add(route, self.stages[route].entered(hardware))
        return CompositeSet(self, found)

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
            entries = self.stages[name].entries(found[name])
            for before, exit_ in self.into[name]:
                if (room := within.get(before.name)) is not None:
                    waiting.widen(before.name, before.leaving(exit_, entries, allowed(before.name)) & room)
        return self.of(found)

    def reaching_inside(self, name: str, goal: Zdd, along: Zdd | None, allowed: Allowed) -> Zdd:
        """The closure within one stage."""
        return goal if along is None else self.stages[name].type.reaching(goal, along, allowed)

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
            return self.stages[name].type.inside if along is None else along.parts.get(name)

        found = {
            name: part & room for name, part in begin.parts.items() if (room := within(name)) is not None
        }
        found = {name: part for name, part in found.items() if part}
        waiting = Waiting(found, self._order.__getitem__)
        for name in waiting:
            room, stage = within(name), self.stages[name]
            assert room is not None, "only parts of what runs may pass are found"
            found[name] = stage.type.reached(found[name], room, allowed(name))
            for route, hardware in stage.step(found[name], allowed(name))[1]:
                onward = within(route)
                if onward is not None:
                    waiting.widen(route, self.stages[route].entered(hardware) & onward)
        return self.of(found)

    def staying(self, along: CompositeSet, asked: CompositeSet | None = None) -> CompositeSet:
        """States from which some maximal run, endless or ending in a dead state, stays in a set."""
        found = dict((along & self.everything).parts)
        ends = self.dead.parts
        empty = self.layout.store.empty()
        waiting = Waiting(found, lambda name: -self._order[name])
        for name in waiting:
            part, stage = found.get(name, empty), self.stages[name]
            onward = ends.get(name, empty)
            for exit_, route in stage.routes.items():
                if route in found:
                    onward |= stage.leaving(exit_, self.stages[route].entries(found[route]))
            before = None
            while before != part:
                before = part
                ways = part.images(stage.beside(undone=True)) | stage.type.before_step(part)
                part = part & (ways | onward)
            if part != found.get(name, empty):
                found[name] = part
                for earlier, _ in self.into[name]:
                    if earlier.name in found:
                        waiting.again(earlier.name)
        return self.of(found)

    @cached_property
    def dead(self) -> CompositeSet:
        """States in which neither the section nor hardware beside it can do anything."""
        found = {}
        for name, part in self.everything.parts.items():
            if resting := part & self.stages[name].type.dead:
                found[name] = resting - self.stages[name].able(resting)
        return self.of(found)

    def leaving_for(self, name: str, hardware: Zdd) -> CompositeSet:
        """States with an event that enters a section with all hardware in some states."""
        found = self.nothing
        for before, exit_ in self.into[name]:
            part = self.everything.parts.get(before.name)
            if part is not None:
                found |= self.of({before.name: before.leaving(exit_, hardware) & part})
        return found

    def entering(self, placed: PlacedSection) -> Zdd:
        """States before the entry of a section, as the mission comes to enter it."""
        hardware = self.layout.store.empty()
        for before, _ in self.into[placed.name]:
            part = self.everything.parts.get(before.name)
            if part is not None:
                for route, states in before.step(part)[1]:
                    if route == placed.name:
                        hardware |= states
        return placed.type.from_slots(hardware, placed.faulty)

    @cached_property
    def regions(self) -> Sequence[CompositeSet]:
        """Sections that lead to each other, and each other section alone: no cycle leaves a region."""
        import networkx as nx

        parts = self.everything.parts
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(parts)
        graph.add_edges_from(
            (name, route) for name in parts for route in self.stages[name].routes.values() if route in parts
        )
        regions = nx.strongly_connected_components(graph)
        return [CompositeSet(self, {name: parts[name] for name in self.in_order(r)}) for r in regions]
