"""The composite: a mission's alternatives graph as the states of its sections, never put together.

A set of states is a diagram for each section; places and transitions are those of the net of the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial, reduce
from operator import or_
from typing import TypeVar

from mcpn._kernel import Zdd
from mcpn.composite.filters import Filter
from mcpn.composite.glued import CompositeSet, Glued, Member, SectionSets
from mcpn.composite.sections import NOWHERE, Moved, Stage
from mcpn.nets.petri import Marking
from mcpn.spaces.algebra import Edge, Guards, Piece
from mcpn.spaces.by_steps import layers_back
from mcpn.spaces.projections import ImageStore

Found = TypeVar("Found")


class TwoOutcomes(Exception):
    """An event after a run has several outcomes: the run would follow one, another leads on."""

    def __init__(self, run: list[Edge]) -> None:
        super().__init__("an event has several outcomes")
        self.run = run


class CompositeSpace(Glued):
    """The alternatives graph of a mission by composition: see :class:`mcpn.spaces.algebra.Space`."""

    def marking(self, state: Member) -> Marking:
        """The marking of a member in the whole net, as tokens by place."""
        stage, tokens = self.stages[state[0]], self.layout.idle.copy()
        for place in {*self.layout.status, *stage.places} - {NOWHERE}:
            tokens[place] = int(stage.marks(state[1], place))
        return tuple(tokens)

    def marked(self, places: Collection[int]) -> CompositeSet:
        """States that mark at least one of some places."""
        sets, parts = SectionSets(), self.everything.parts
        for place in places:
            if self.layout.idle[place] or place in self.layout.status:
                marking = partial(Stage.marking, place=place)
                for name, part in self._alike(parts, [place], marking):
                    sets.add(name, part)
                continue
            for name in self.holders("places", place):
                if name in parts:
                    sets.add(name, self.stages[name].marking(parts[name], place))
        return CompositeSet(self, sets)

    def restricted(
        self, states: CompositeSet, marked: Collection[int], unmarked: Collection[int]
    ) -> CompositeSet:
        """Those of some states that mark all of some places, and none of others."""
        places = [*marked, *unmarked]
        found = self._alike(states.parts, places, lambda s, part: s.restricted(part, marked, unmarked))
        return CompositeSet(self, dict(found))

    def _alike(
        self, parts: Mapping[str, Zdd], places: Collection[int], of: Callable[[Stage, Zdd], Found]
    ) -> Iterator[tuple[str, Found]]:
        """By section what is asked of its states and some places: once for copies with these states.

        Copies of one lie alike to places that are none of their own.
        """
        least, most = min(places, default=0), max(places, default=-1)
        found = dict[tuple[int, int, Zdd], Found]()
        for name, part in parts.items():
            stage = self.stages[name]
            if not isinstance(row := stage.places, Moved) or (row.own[0] <= most and least < row.own[1]):
                yield name, of(stage, part)
                continue
            key = id(row.other), id(stage.carried), part
            if key not in found:
                found[key] = of(stage, part)
            yield name, found[key]

    def varying(self, states: CompositeSet) -> Collection[int]:
        """Places of the sections that these states are of, but for those of hardware and of the mission."""
        sections = (self.sections[name].places for name in states.parts if name in self.sections)
        return set[int]().union(*sections) - {NOWHERE, *self.layout.status}

    def at_most(self, weights: Mapping[int, int], bound: int) -> CompositeSet:
        """States whose weighted sum of tokens is at most a bound."""
        parts = self.everything.parts
        return CompositeSet(
            self, dict(self._alike(parts, weights, lambda s, part: s.at_most(part, weights, bound)))
        )

    def image(self, states: CompositeSet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.spaces.algebra.Space.image`."""

        def of(stage: Stage, part: Zdd) -> Zdd:
            return images.of_diagram(part, self.layout.store, [stage.bit(place) for place in places])

        each = dict.fromkeys(image for _, image in self._alike(states.parts, places, of))
        return reduce(or_, each, images.nothing)

    def pieces(self, states: CompositeSet) -> Iterator[Piece[CompositeSet]]:
        """The states, section by section."""
        for name, part in states.parts.items():
            stage = self.stages[name]
            yield Piece(CompositeSet(self, {name: part}), (stage.alike, part), stage.objectives)

    def enabling(self, transitions: Collection[int]) -> CompositeSet:
        """States with an edge of some of these transitions."""
        allowed, enabling, parts = self.filtered(transitions), dict[str, Zdd](), self.everything.parts
        having = self.having(transitions)
        for name in parts if having is None else having:
            if name in parts:
                stage = self.stages[name]
                enabling[name] = stage.type.enabling(parts[name], allowed(name), stage.carried)
        return CompositeSet(self, enabling)

    def crossing(self, among: CompositeSet, into: CompositeSet) -> Iterator[tuple[int, CompositeSet]]:
        """Transitions with edges from some states into others, each with the states before it."""
        by_transition: dict[int, dict[str, Zdd]] = {}
        for name, part in (self.before(into) & among).parts.items():
            stage = self.stages[name]
            goal = into.of(name) | self.ends_into(stage, into.parts)
            for t, before in stage.named(*stage.type.crossing(part, goal, stage.carried)):
                by_transition.setdefault(t, {})[name] = before
        return ((t, CompositeSet(self, by_transition[t])) for t in sorted(by_transition))

    def firings(self, states: CompositeSet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts: dict[int, int] = {}
        for name, part in states.parts.items():
            stage = self.stages[name]
            for t, number in stage.named(*stage.type.firings(stage.closed(part), stage.carried)):
                counts[t] = counts.get(t, 0) + number
        return counts

    def edges(self, state: Member, into: Collection[str] | None = None) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions: into any section, or some."""
        stage, into, store = self.stages[state[0]], self.stages if into is None else into, self.layout.store
        here, edges = store.singleton(state[1]), list[Edge]()
        for toggle in stage.toggling() if stage.name in into else ():
            if (levels := here.images([toggle.event]).pick()) is not None:
                edges.append(Edge(toggle.transition, (stage.name, tuple(levels))))
        local = tuple(level for level in state[1] if level < self.layout.first_slot)
        for edge, exit_ in stage.type.fired(local):
            route, there = stage.routes.get(exit_ or "", stage.name), (*edge.target, *state[1][len(local) :])
            if exit_ is not None and route in into:
                hardware = stage.type.to_slots(store.singleton(there), stage.slots, exit_)
                entered = self.stages[route]
                there = tuple(entered.closed(entered.entered(hardware)).pick() or ())
            if route in into:
                edges.append(Edge(stage.transitions[edge.transition], (route, there)))
        return iter(sorted(edges, key=lambda edge: edge.transition))

    def reaches_without(self, goal: CompositeSet, left_out: Sequence[frozenset[int]]) -> Sequence[bool]:
        """Whether the initial state reaches a goal without some transitions, for each of several sets."""
        from mcpn.composite.leaving_out import LeavingOut

        asked = LeavingOut(self, goal)
        return [asked.reaches(each) for each in left_out]

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        part, slots = self.layout.store.singleton(state[1]), self.stages[state[0]].slots
        return CompositeSet(self, {state[0]: self.layout.opened(part, slots)})

    def _has(self, parts: Mapping[str, Zdd], state: Member) -> bool:
        # Parts leave the section's own slots unconstrained; in a member they are unmarked. So a member is in
        # a set where it is in the diagram.
        return state[0] in parts and bool(self.layout.store.singleton(state[1]) & parts[state[0]])

    def run(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> list[Edge] | None:
        """A run from a member into a goal through as few sections as can be.

        Within each section it is a shortest one; see :meth:`mcpn.spaces.algebra.Space.run`.

        Raises:
            TwoOutcomes: The mission is not confluent, and the run would pass such an event.
        """
        allowed, wanted = self.filtered(transitions, guards), frozenset(transitions or ())
        within = self.everything if along is None else along

        def taken(edge: Edge) -> bool:
            t = edge.transition
            chosen = transitions is None or t in wanted
            return chosen and (not guards or t not in guards or self._has(guards[t].parts, state))

        hops = self._hops(begin, goal, within, allowed)
        run, state = list[Edge](), begin
        while hops:  # each edge out of a section leads one section nearer
            _, targets = hops.pop()
            name, stage = state[0], self.stages[state[0]]
            back = partial(stage.back, allowed=allowed(name), within=within.of(name))
            layers = layers_back(self.layout.store.singleton(state[1]), targets[name], back)
            assert layers is not None, "there is a run"
            onward: list[Mapping[str, Zdd]] = [{name: layer} for layer in reversed(layers[:-1])]
            for target in (*onward, *(closed for closed, _ in hops[-1:])):
                edges = self.edges(state, target)
                edge = next((e for e in edges if taken(e) and self._has(target, e.target)), None)
                if edge is None:
                    raise TwoOutcomes(run)
                run.append(edge)
                state = edge.target
        return None if hops is None else run

    def _hops(
        self, begin: Member, goal: CompositeSet, within: CompositeSet, allowed: Filter
    ) -> list[tuple[SectionSets, SectionSets]] | None:
        """By number of sections still to leave: states first reached so, and the targets in each section."""
        hops: list[tuple[SectionSets, SectionSets]] = []
        seen, targets = SectionSets(), SectionSets(goal.parts)
        while targets:
            closed = SectionSets()
            for name, target in targets.items():
                sources = self.stages[name].type.reaching(target, within.of(name), allowed(name))
                closed.add(name, sources - seen.get(name, self.empty))
                seen.add(name, sources)
            hops.append((closed, targets))
            if self._has(closed, begin):
                return hops
            targets = self.leaving(closed, within, allowed)
        return None
