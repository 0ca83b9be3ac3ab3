"""Runs of a composite, through as few sections as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping

from mcpn._kernel import Zdd
from mcpn.space.algebra import Edge, Guards
from mcpn.space.local.glued import Glued
from mcpn.space.local.section_type import ALL, Allowed
from mcpn.space.local.sets import CompositeSet, Member, Parts


class TwoOutcomes(Exception):
    """An event on the way has several outcomes, of which a run follows one, and not the one that leads on.

    Args:
        run: The edges before that event.
    """

    def __init__(self, run: list[Edge]) -> None:
        super().__init__("an event has several outcomes")
        self.run = run


class Runs(Glued):
    """Edges of single states, and runs."""

    def single(self, state: Member) -> CompositeSet:
        """The set that holds one member."""
        part, slots = self.layout.store.singleton(state[1]), self.stages[state[0]].slots
        return CompositeSet(self, {state[0]: self.layout.opened(part, slots)})

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        return self._edges(state, ALL, self.everything.parts)

    def _edges(self, state: Member, allowed: Allowed, goal: Mapping[str, Zdd]) -> Iterator[Edge]:
        """Those of them that are allowed and lead into a set."""
        edges = [*self._toggled(state, allowed)] if state[0] in goal else []
        edges += self._fired(state, allowed, goal)
        for edge in sorted(edges, key=lambda edge: edge.transition):
            if self._in(edge.target, goal[edge.target[0]]):
                yield edge

    def _toggled(self, state: Member, allowed: Allowed) -> Iterator[Edge]:
        name, marked = state[0], frozenset(state[1])
        for toggle in self.stages[name].beside(allowed):
            if toggle.marked <= marked and toggle.unmarked.isdisjoint(marked):
                yield Edge(toggle.transition, (name, tuple(sorted(marked ^ toggle.changed))))

    def _fired(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        stage, first, guards = self.stages[state[0]], self.layout.first_slot, dict(allowed.guards)
        local = tuple(level for level in state[1] if level < first)
        beside_it = state[1][len(local) :]
        for t, after, exit_ in stage.type.fired(local):
            name = stage.name if exit_ is None else stage.routes[exit_]
            barred = allowed.local is not None and t not in allowed.local
            if barred or name not in into or (t in guards and not self._in(state, guards[t])):
                continue
            if exit_ is None:
                target = name, (*sorted(after), *beside_it)
            else:
                marks, own = stage.type.encoding.marks, stage.own_places.items()
                slots = {*beside_it, *(slot for slot, place in own if marks(after, place))}
                target = self._entered(name, slots)
            yield Edge(stage.transitions[t], target)

    def _entered(self, name: str, slots: Collection[int]) -> Member:
        """The first state of a section entered with all hardware in one state."""
        entered = self.stages[name].entered(self.layout.store.singleton([*slots]))
        levels = self.closed(name, entered).pick()
        assert levels is not None, "every state of the hardware has an entry"
        return name, tuple(levels)

    def _in(self, state: Member, part: Zdd) -> bool:
        # A part is open in the section's own slots, so the member stands for all that it is open to.
        return bool(self.layout.store.singleton(state[1]) & part)

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

        Raises:
            TwoOutcomes: The mission is not confluent, and the run would pass such an event.
        """
        allowed = self.filtered(transitions, guards)
        within = (self.everything if along is None else along).parts
        hops = self._hops(begin, goal, within, allowed)
        if hops is None:
            return None
        run, state = list[Edge](), begin
        for hop in reversed(range(len(hops))):  # each edge out of a section leads one section nearer
            layers = self._layers(state, hops[hop][state[0]][1], within, allowed(state[0]))
            steps: list[Mapping[str, Zdd]] = [{state[0]: layer} for layer in reversed(layers[:-1])]
            if hop:
                steps.append({name: closed for name, (closed, _) in hops[hop - 1].items()})
            for target in steps:
                edge = next(self._edges(state, allowed(state[0]), target), None)
                if edge is None:
                    raise TwoOutcomes(run)
                run.append(edge)
                state = edge.target
        return run

    def _hops(
        self,
        begin: Member,
        goal: CompositeSet,
        within: Mapping[str, Zdd],
        allowed: Callable[[str], Allowed],
    ) -> list[dict[str, tuple[Zdd, Zdd]]] | None:
        """By number of sections to leave before the goal: from which states, and to where in a section."""
        hops: list[dict[str, tuple[Zdd, Zdd]]] = []
        seen, targets = Parts(), Parts(goal.parts)
        while targets:
            hop: dict[str, tuple[Zdd, Zdd]] = {}
            onward = Parts()
            for name, target in targets.items():
                closed = self.reaching_inside(name, target, within, allowed(name))
                closed -= seen.get(name, self.empty)
                if seen.add(name, closed):
                    hop[name] = closed, target
            hops.append(hop)
            if begin[0] in hop and self._in(begin, hop[begin[0]][0]):
                return hops
            for name, (closed, _) in hop.items():
                entries = self.stages[name].entries(closed)
                for before, leaving in self.leaving_for(name, entries, within, allowed):
                    onward.add(before, leaving)
            targets = onward
        return None

    def _layers(self, state: Member, goal: Zdd, within: Mapping[str, Zdd], allowed: Allowed) -> list[Zdd]:
        """Layers back from a goal in a section to one that holds a state: by the length of shortest runs."""
        stage, layers, seen = self.stages[state[0]], [goal], goal
        while not self._in(state, layers[-1]):
            layers.append((stage.back(layers[-1], allowed) & within[state[0]]) - seen)
            assert layers[-1], "the caller knows that there is a run"
            seen |= layers[-1]
        return layers
