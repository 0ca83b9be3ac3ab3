"""Runs of a composite, through as few sections as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking
from mcpn.space.algebra import Edge, Guards
from mcpn.space.local.glued import Glued
from mcpn.space.local.local_states import ALL, Allowed
from mcpn.space.local.sections import BEGIN, ENDS, PlacedSection
from mcpn.space.local.sets import CompositeSet, Member


class Runs(Glued):
    """Edges of single states, and runs."""

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        name, levels = state
        part, placed = self.layout.store.singleton(list(levels)), self.sections.get(name)
        return CompositeSet(self, {name: part if placed is None else self.layout.opened(part, placed.slots)})

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        return self._edges(state, ALL, (*self.sections, *ENDS, BEGIN))

    def _edges(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        """Those of them that are allowed and lead into some sections."""
        found = list(self._toggled(state, allowed)) if state[0] in into else []
        if state[0] in self.sections:
            found += self._fired(state, allowed, into)
        elif state[0] == BEGIN and (allowed.local is None or allowed.local):
            graph = self.mission_net.graph
            found.append(Edge(self.mission_net.start, self._entered(graph.entry, set(state[1]))))
        return iter(sorted(found, key=lambda edge: edge.transition))

    def _toggled(self, state: Member, allowed: Allowed) -> Iterator[Edge]:
        name, levels = state
        placed, marked = self.sections.get(name), set(levels)
        own = () if placed is None else placed.faulty
        for hardware, kind in self._kinds if allowed.beside is None else allowed.beside:
            needed, unmarked = self.layout.needs(hardware)[kind]
            if hardware not in own and marked.issuperset(needed) and marked.isdisjoint(unmarked):
                after = marked ^ self.layout.changes(kind, hardware)
                yield Edge(self.toggles[hardware][kind], (name, tuple(sorted(after))))

    @cached_property
    def _kinds(self) -> list[tuple[str, str]]:
        """The events of idle hardware, each as its resource and its kind."""
        return [(hardware, kind) for hardware, kinds in self.toggles.items() for kind in kinds]

    def _fired(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        placed, first, guards = self.sections[state[0]], self.layout.first_slot, dict(allowed.guards)
        type_, routes = placed.type, placed.routes
        local = tuple(level for level in state[1] if level < first)
        beside_it = {level for level in state[1] if level >= first}
        for t, after, inside, exit_ in type_.fired(local):
            name = placed.name if exit_ is None else routes[exit_]
            barred = allowed.local is not None and t not in allowed.local
            if barred or name not in into or (t in guards and not self._in(state, guards[t])):
                continue
            if exit_ is None:
                target = (name, tuple(sorted({*inside, *beside_it})))
            else:
                target = self._entered(name, beside_it | self.own_bits(placed, after))
            yield Edge(placed.transitions[t], target)

    def own_bits(self, placed: PlacedSection, marking: Marking) -> set[int]:
        """The slots that say of a section's own hardware what a marking of its local net says."""
        roles = placed.type.net.by_role
        return {
            slot
            for theirs, mine in zip(placed.type.faulty, placed.faulty, strict=True)
            for slot, role in zip(self.layout.slots[mine], self.layout.bits, strict=True)
            if marking[roles[role, theirs][0]]
        }

    def _entered(self, name: str, slots: set[int]) -> Member:
        """The first state of a section entered with all hardware in one state."""
        entered = self.enter(name, self.layout.store.singleton(sorted(slots)))
        levels = self.closed(name, entered).pick()
        assert levels is not None, "every state of the hardware has an entry"
        return name, tuple(levels)

    def run(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[CompositeSet] = None,
    ) -> list[Edge] | None:
        """A run from a member into a goal through as few sections as can be.

        Within each section it is a shortest one; see :meth:`mcpn.space.algebra.Space.run`.
        """
        allowed = self.filtered(transitions, guards)
        hops = self._hops(begin, goal, along, allowed)
        if hops is None:
            return None
        run, state = list[Edge](), begin
        for hop in reversed(range(len(hops))):  # each edge out of a section leads one section nearer
            target = hops[hop][state[0]][1]
            inside = None if along is None else along.parts.get(state[0])
            legs = self._run_inside(state, target, inside, allowed(state[0]))
            run += legs
            state = legs[-1].target if legs else state
            if hop:
                onward = {name: closed for name, (closed, _) in hops[hop - 1].items()}
                run.append(next(self._edges_to(state, onward, allowed(state[0]))))
                state = run[-1].target
        return run

    def _in(self, state: Member, part: Zdd) -> bool:
        # A part is open in the section's own slots, so the member stands for all that it is open to.
        return bool(self.layout.store.singleton(list(state[1])) & part)

    def _edges_to(self, state: Member, goal: Mapping[str, Zdd], allowed: Allowed) -> Iterator[Edge]:
        """The edges of one member that are allowed and lead into a set."""
        edges = self._edges(state, allowed, goal)
        return (edge for edge in edges if self._in(edge.target, goal[edge.target[0]]))

    def _hops(
        self,
        begin: Member,
        goal: CompositeSet,
        along: CompositeSet | None,
        allowed: Callable[[str], Allowed],
    ) -> list[dict[str, tuple[Zdd, Zdd]]] | None:
        """By number of sections to leave before the goal: from which states, and to where in a section."""
        within = (self.everything if along is None else along).parts
        seen: dict[str, Zdd] = {}
        targets = dict(goal.parts)
        hops: list[dict[str, tuple[Zdd, Zdd]]] = []
        while targets:
            hop: dict[str, tuple[Zdd, Zdd]] = {}
            for name, target in targets.items():
                closed = self.reaching_inside(name, target, within.get(name), allowed(name))
                if name in seen:
                    closed = closed - seen[name]
                if closed:
                    hop[name] = closed, target
                    seen[name] = seen[name] | closed if name in seen else closed
            if not hop:
                return None
            hops.append(hop)
            if begin[0] in hop and self._in(begin, hop[begin[0]][0]):
                return hops
            targets = {}
            for name, (closed, _) in hop.items():
                entries = self.entries(name, closed)
                for before, exit_ in self.into.get(name, ()):
                    if before in within:
                        leaving = self.leaving(before, exit_, entries, allowed(before)) & within[before]
                        if leaving:
                            targets[before] = targets[before] | leaving if before in targets else leaving
        return None

    def _run_inside(self, begin: Member, goal: Zdd, along: Zdd | None, allowed: Allowed) -> list[Edge]:
        """A shortest run within one section; there is one."""
        name = begin[0]
        placed = self.sections.get(name)
        within = self.everything.parts[name] if along is None else along
        layers, seen = [goal], goal
        while not self._in(begin, layers[-1]):
            earlier = layers[-1].images(self.beside_it(name, allowed, undone=True))
            if placed is not None:
                earlier |= placed.type.before_step(layers[-1], allowed)
            layers.append((earlier & within) - seen)
            assert layers[-1], "the caller knows that there is a run"
            seen |= layers[-1]
        run, state = list[Edge](), begin
        for layer in reversed(layers[:-1]):
            run.append(next(self._edges_to(state, {name: layer}, allowed)))
            state = run[-1].target
        return run
