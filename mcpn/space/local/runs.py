"""Runs of a composite, through as few sections as can be."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cached_property
from itertools import chain

from mcpn._kernel import Zdd
from mcpn.space.algebra import Edge, Guards
from mcpn.space.local.glued import Glued
from mcpn.space.local.local_states import ALL, Allowed
from mcpn.space.local.sets import CompositeSet, Member


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
        part, slots = self.layout.store.singleton(list(state[1])), self.stages[state[0]].slots
        return CompositeSet(self, {state[0]: self.layout.opened(part, slots)})

    def edges(self, state: Member) -> Iterator[Edge]:
        """The edges of one member, in the order of the whole net's transitions."""
        return self._edges(state, ALL, self.stages)

    def _edges(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        """Those of them that are allowed and lead into some stages."""
        toggled = self._toggled(state, allowed) if state[0] in into else ()
        edges = chain(toggled, self._fired(state, allowed, into))
        return iter(sorted(edges, key=lambda edge: edge.transition))

    def _toggled(self, state: Member, allowed: Allowed) -> Iterator[Edge]:
        name, marked = state[0], set(state[1])
        for hardware, kind in self._kinds if allowed.beside is None else allowed.beside:
            toggle, own = self.layout.toggles[hardware][kind], self.stages[name].faulty
            if (
                hardware not in own
                and marked.issuperset(toggle.marked)
                and marked.isdisjoint(toggle.unmarked)
            ):
                yield Edge(self.toggles[hardware][kind], (name, tuple(sorted(marked ^ toggle.changed))))

    @cached_property
    def _kinds(self) -> list[tuple[str, str]]:
        """The events of idle hardware, each as its resource and its kind."""
        return [(hardware, kind) for hardware, kinds in self.toggles.items() for kind in kinds]

    def _fired(self, state: Member, allowed: Allowed, into: Collection[str]) -> Iterator[Edge]:
        stage, first, guards = self.stages[state[0]], self.layout.first_slot, dict(allowed.guards)
        local = tuple(level for level in state[1] if level < first)
        beside_it = {level for level in state[1] if level >= first}
        for t, after, exit_ in stage.type.fired(local):
            name = stage.name if exit_ is None else stage.routes[exit_]
            barred = allowed.local is not None and t not in allowed.local
            if barred or name not in into or (t in guards and not self._in(state, guards[t])):
                continue
            if exit_ is None:
                target = (name, tuple(sorted(after | beside_it)))
            else:
                marks, bits = stage.type.encoding.marks, stage.own_bits.items()
                own = {slot for slot, place in bits if marks(after, place)}
                target = self._entered(name, beside_it | own)
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

        Raises:
            TwoOutcomes: The mission is not confluent, and the run would pass such an event.
        """
        allowed = self.filtered(transitions, guards)
        hops = self._hops(begin, goal, along, allowed)
        if hops is None:
            return None
        run, state = list[Edge](), begin
        for hop in reversed(range(len(hops))):  # each edge out of a section leads one section nearer
            target = hops[hop][state[0]][1]
            inside = None if along is None else along.parts.get(state[0])
            state = self._run_inside(run, state, target, inside, allowed(state[0]))
            if hop:
                onward = {name: closed for name, (closed, _) in hops[hop - 1].items()}
                state = self._follow(run, state, onward, allowed(state[0]))
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
                entries = self.stages[name].entries(closed)
                for before, exit_ in self.into[name]:
                    room, at = within.get(before.name), before.name
                    if room and (leaving := before.leaving(exit_, entries, allowed(at)) & room):
                        targets[at] = targets[at] | leaving if at in targets else leaving
        return None

    def _follow(self, run: list[Edge], state: Member, goal: Mapping[str, Zdd], allowed: Allowed) -> Member:
        """Goes on by an edge of one member into a set from which it is one step back."""
        edge = next(self._edges_to(state, goal, allowed), None)
        if edge is None:
            raise TwoOutcomes(run)
        run.append(edge)
        target: Member = edge.target
        return target

    def _run_inside(
        self, run: list[Edge], state: Member, goal: Zdd, along: Zdd | None, allowed: Allowed
    ) -> Member:
        """Goes on by a shortest run within one section; there is one."""
        name = state[0]
        stage = self.stages[name]
        within = self.everything.parts[name] if along is None else along
        layers, seen = [goal], goal
        while not self._in(state, layers[-1]):
            earlier = layers[-1].images(stage.beside(allowed, undone=True))
            earlier |= stage.type.before_step(layers[-1], allowed)
            layers.append((earlier & within) - seen)
            assert layers[-1], "the caller knows that there is a run"
            seen |= layers[-1]
        for layer in reversed(layers[:-1]):
            state = self._follow(run, state, {name: layer}, allowed)
        return state
