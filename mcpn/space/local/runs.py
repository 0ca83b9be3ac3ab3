"""Runs of a composite, through as few sections as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import chain

from mcpn._kernel import Zdd
from mcpn.space.algebra import Edge, Guards
from mcpn.space.local.glued import Glued
from mcpn.space.local.local_states import ALL, Allowed
from mcpn.space.local.sets import CompositeSet, Member


class Runs(Glued):
    """Edges of single states, and runs."""

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        part, slots = self.layout.store.singleton(list(state[1])), self.stages[state[0]].slots
        return CompositeSet(self, {state[0]: self.layout.opened(part, slots)})

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        edges = chain(self._toggled(state), self._fired(state))
        return iter(sorted(edges, key=lambda edge: edge.transition))

    def _toggled(self, state: Member) -> Iterator[Edge]:
        name, marked = state[0], set(state[1])
        for hardware, toggles in self.layout.toggles.items():
            for kind, toggle in toggles.items() if hardware not in self.stages[name].faulty else ():
                if marked.issuperset(toggle.marked) and marked.isdisjoint(toggle.unmarked):
                    after = tuple(sorted(marked ^ toggle.changed))
                    yield Edge(self.toggles[hardware][kind], (name, after))

    def _fired(self, state: Member) -> Iterator[Edge]:
        stage, first = self.stages[state[0]], self.layout.first_slot
        local = tuple(level for level in state[1] if level < first)
        beside_it = {level for level in state[1] if level >= first}
        for t, after, exit_ in stage.type.remembered(("fired", local), lambda: stage.type.fired(local)):
            if exit_ is None:
                target = (stage.name, tuple(sorted({*stage.type.encoding.marked_levels(after), *beside_it})))
            else:
                own = {slot for slot, place in stage.own_bits.items() if after[place]}
                target = self._entered(stage.routes[exit_], beside_it | own)
            yield Edge(stage.transitions.whole[t], target)

    def _entered(self, name: str, slots: set[int]) -> Member:
        """The first state of a section entered with all hardware in one state."""
        entered = self.stages[name].entered(self.layout.store.singleton(sorted(slots)))
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
        leaves = self.stages[state[0]].transitions.local(edge.transition) is not None
        if not leaves or not self._carried(edge, state, allowed(state[0])):
            return False
        return after[0] in hop and self._in(after, hop[after[0]][0])

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
                entries = self.stages[name].entries(closed)
                for before, exit_ in self.into[name]:
                    room, at = within.get(before.name), before.name
                    if room and (leaving := before.leaving(exit_, entries, allowed(at)) & room):
                        targets[at] = targets[at] | leaving if at in targets else leaving
        return None

    def _run_inside(self, begin: Member, goal: Zdd, along: Zdd | None, allowed: Allowed) -> list[Edge]:
        """A shortest run within one section; there is one."""
        name = begin[0]
        stage = self.stages[name]
        within = self.everything.parts[name] if along is None else along
        layers, seen = [goal], goal
        while not self._in(begin, layers[-1]):
            earlier = layers[-1].images(stage.beside(allowed, undone=True))
            earlier |= stage.type.before_step(layers[-1], allowed)
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
        local = self.stages[state[0]].transitions.local(edge.transition)
        if local is not None:
            guard = dict(allowed.guards).get(local)
            return (allowed.local is None or local in allowed.local) and (
                guard is None or self._in(state, guard)
            )
        return allowed.beside is None or any(
            self.toggles[hardware][kind] == edge.transition for hardware, kind in allowed.beside
        )
