"""Runs of a composite, through as few sections as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

from mcpn._kernel import Zdd
from mcpn.net.petri import Marking
from mcpn.space.algebra import Edge, Guards
from mcpn.space.local.glued import Glued
from mcpn.space.local.local_states import ALL, Allowed
from mcpn.space.local.sections import BEGIN, PlacedSection
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
        found = list(self._toggled(state))
        name, levels = state
        if name == BEGIN:
            found.append(
                Edge(self.mission_net.start, self._entered(self.mission_net.graph.entry, set(levels)))
            )
        elif name in self.sections:
            found += self._fired(self.sections[name], levels)
        return iter(sorted(found, key=lambda edge: edge.transition))

    def _toggled(self, state: Member) -> Iterator[Edge]:
        name, levels = state
        placed, marked = self.sections.get(name), set(levels)
        own = set() if placed is None else set(placed.faulty)
        for hardware in self.layout.hardware:
            if hardware in own:
                continue
            for kind, (needed, unmarked) in self.layout.needs(hardware).items():
                if marked.issuperset(needed) and marked.isdisjoint(unmarked):
                    after = marked ^ self.layout.changes(kind, hardware)
                    yield Edge(self.toggles[hardware][kind], (name, tuple(sorted(after))))

    def _fired(self, placed: PlacedSection, levels: tuple[int, ...]) -> Iterator[Edge]:
        type_, first = placed.type, self.layout.first_slot
        local = tuple(level for level in levels if level < first)
        beside_it = {level for level in levels if level >= first}
        for t, after, exit_ in type_.remembered(("fired", local), lambda: type_.fired(local)):
            if exit_ is None:
                target = (placed.name, tuple(sorted({*type_.encoding.marked_levels(after), *beside_it})))
            else:
                target = self._entered(placed.routes[exit_], beside_it | self.own_bits(placed, after))
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
                onward = hops[hop - 1]
                run.append(next(e for e in self.edges(state) if self._leads_on(e, state, onward, allowed)))
                state = run[-1].target
        return run

    def _in(self, state: Member, part: Zdd) -> bool:
        return bool(self.single(state).parts[state[0]] & part)

    def _leads_on(
        self,
        edge: Edge,
        state: Member,
        hop: dict[str, tuple[Zdd, Zdd]],
        allowed: Callable[[str], Allowed],
    ) -> bool:
        """Whether an edge leaves a section for states from which the goal is one section nearer."""
        after = edge.target
        leaves = edge.transition == self.mission_net.start or self._ends_section(state, edge.transition)
        if not leaves or not self._carried(edge, state, allowed(state[0])):
            return False
        return after[0] in hop and self._in(after, hop[after[0]][0])

    def _ends_section(self, state: Member, transition: int) -> bool:
        placed = self.sections.get(state[0])
        return placed is not None and placed.local_transition(transition) is not None

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
            edge = next(
                e
                for e in self.edges(state)
                if e.target[0] == name and self._carried(e, state, allowed) and self._in(e.target, layer)
            )
            run.append(edge)
            state = edge.target
        return run

    def _carried(self, edge: Edge, state: Member, allowed: Allowed) -> bool:
        """Whether an edge out of a state is allowed."""
        if allowed is ALL:
            return True
        placed = self.sections.get(state[0])
        local = None if placed is None else placed.local_transition(edge.transition)
        if local is not None:
            guard = dict(allowed.guards).get(local)
            return (allowed.local is None or local in allowed.local) and (
                guard is None or self._in(state, guard)
            )
        if edge.transition == self.mission_net.start:
            return allowed.local is None or bool(allowed.local)
        return allowed.beside is None or any(
            self.toggles[hardware][kind] == edge.transition for hardware, kind in allowed.beside
        )
