"""The states from which some path is accepted: sets of a space, one for each state of an automaton.

Neither the space nor the product of both is taken apart into states: an edge of the automaton is one step
back in the space from a set of states, so that every engine's own steps and closures do the work. A component
of the automaton whose cycles are all accepted takes one closure; others are narrowed down to where each mark
is met again and again (Emerson, Lei, *Efficient model checking in fragments of the propositional
mu-calculus*, LICS 1986; by component: Bloem, Ravi, Somenzi, *Efficient decision procedures for model checking
of linear time logic properties*, CAV 1999).

A state without successors repeats for ever, and no step is a firing there.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial, reduce
from operator import and_, or_
from typing import Generic, NamedTuple

from mcpn.logic.ltl.automaton import Automaton, AutomatonEdge
from mcpn.spaces.algebra import S, Space, by_region
from mcpn.spaces.search.goal import Formula


class Constraint(NamedTuple, Generic[S]):
    """A justice constraint: only paths that meet it infinitely often count, in a state or by a firing."""

    states: S
    transitions: tuple[int, ...] = ()


class ProductEdge(NamedTuple, Generic[S]):
    """An edge of the automaton over a space.

    Args:
        source: The state of the automaton that it leaves.
        target: The one that it leads to.
        marks: Marks that it bears.
        states: States that it reads.
        transitions: What may fire along it; ``None`` for anything.
        rests: Whether it may be taken in a state without successors, which repeats.
    """

    source: int
    target: int
    marks: frozenset[int]
    states: S
    transitions: frozenset[int] | None
    rests: bool


Sets = dict[int, S]
"""By state of the automaton some states of the space; none where it has no entry."""
Meeting = tuple[Callable[["Sets[S]"], "Sets[S]"], Collection["ProductEdge[S]"], Collection[int] | None]
"""See :meth:`Product.meetings`."""


class Product(Generic[S]):
    """An automaton beside a space.

    Args:
        space: The space.
        automaton: The automaton.
        states: The states that satisfy a formula on states.
        constraints: What paths must meet to count.
        resting: States with successors in which nothing need happen any more: a path may repeat them.
    """

    def __init__(
        self,
        space: Space[S],
        automaton: Automaton,
        states: Callable[[Formula], S],
        constraints: Sequence[Constraint[S]] = (),
        resting: S | None = None,
    ) -> None:
        self.resting = space.dead if resting is None else space.dead | resting
        self.space, self.automaton, self.constraints = space, automaton, tuple(constraints)
        self.edges = [
            edge
            for q, edges in enumerate(automaton.edges)
            for edge in _joined(map(self._edge(q, states), edges))
        ]
        self.components = automaton.components()

    def _edge(self, source: int, states: Callable[[Formula], S]) -> Callable[[AutomatonEdge], ProductEdge[S]]:
        def made(edge: AutomatonEdge) -> ProductEdge[S]:
            fired, rests = edge.fires(len(self.space.net.transitions))
            here = reduce(and_, map(states, edge.reads), self.space.everything)
            return ProductEdge(source, edge.target, edge.marks, here, fired, rests)

        return made

    def back(self, edge: ProductEdge[S], after: S, among: S) -> S:
        """Those of some states that an edge leads from into others."""
        among = edge.states & among
        if not among:
            return among
        before = self.space.before(after, edge.transitions, among=among)
        return before | (among & self.resting & after) if edge.rests else before

    def on(self, edge: ProductEdge[S], before: S) -> S:
        """States that an edge leads to from some states."""
        begun = edge.states & before
        after = self.space.after(begun, edge.transitions)
        return after | (begun & self.resting) if edge.rests else after

    def reached(self, begin: S) -> Sets[S]:
        """The product states that some states, with the initial state of the automaton, lead to."""
        reached: Sets[S] = {0: begin}
        fresh: Sets[S] = {0: begin}
        leaving = _by(self.edges, lambda edge: edge.source)
        while fresh:
            q, states = fresh.popitem()
            stays = [e for e in leaving.get(q, ()) if e.target == q and e.transitions is None]
            if stays:  # a closure in the space stands for all steps along these loops
                along = reduce(or_, (e.states for e in stays))
                inside = self.space.reached(states & along, along)
                wider = states | inside | self.space.after(inside)
                states = states | (wider - reached[q])
                reached[q] = reached[q] | states
            for edge in leaving.get(q, ()):
                new = self.on(edge, states) - reached.get(edge.target, self.space.nothing)
                if new:
                    reached[edge.target] = reached.get(edge.target, self.space.nothing) | new
                    fresh[edge.target] = fresh.get(edge.target, self.space.nothing) | new
        return reached

    def reaching(
        self, goal: Mapping[int, S], within: Mapping[int, S], edges: Collection[ProductEdge[S]]
    ) -> Sets[S]:
        """The product states that reach a goal along some edges and inside some sets, the goal included."""
        nothing = self.space.nothing
        leading: Sets[S] = dict(goal)
        fresh: Sets[S] = {q: states for q, states in goal.items() if states}
        entering = _by(edges, lambda edge: edge.target)
        while fresh:
            q, states = fresh.popitem()
            stays = [e for e in entering.get(q, ()) if e.source == q and e.transitions is None]
            if stays and q in within:
                along = reduce(or_, (e.states for e in stays)) & within[q]
                wider = self.space.reaching(states, along)
                states = states | (wider - leading[q])
                leading[q] = leading[q] | states
            for edge in entering.get(q, ()):
                p = edge.source
                if p not in within:
                    continue
                new = self.back(edge, states, within[p]) - leading.get(p, nothing)
                if new:
                    leading[p] = leading.get(p, nothing) | new
                    fresh[p] = fresh.get(p, nothing) | new
        return leading

    def decided(self, fair: Mapping[int, S], within: Mapping[int, S]) -> Sets[S]:
        """The product states from which every path that counts is accepted, and some path counts.

        Args:
            fair: Where accepted paths may stay for ever.
            within: What is asked of.
        """
        everything = self.automaton.accepting_all
        inside = [e for e in self.edges if e.source == e.target and e.source in everything]
        goal = {e.source: fair[e.source] for e in inside if e.source in fair}
        decided = self.reaching(goal, within, inside)
        for edge in self.edges:
            into_one = edge.target in everything and edge.source not in everything
            if into_one and edge.target in decided and edge.transitions is None:  # so that it rests, too
                before = self.back(edge, decided[edge.target], within.get(edge.source, self.space.nothing))
                decided[edge.source] = decided.get(edge.source, self.space.nothing) | before
        return decided

    def accepted(self, within: Mapping[int, S] | None = None) -> Sets[S]:
        """By state of the automaton, the states from which it accepts some path.

        Args:
            within: What is asked of: closed under steps; everything by default.
        """
        everything = dict.fromkeys(range(len(self.automaton.edges)), self.space.everything)
        within = everything if within is None else within
        accepted: Sets[S] = {}
        for fair, states in self.fair(within):
            goal = {q: fair.get(q, self.space.nothing) for q in states}
            out = [
                e
                for e in self.edges
                if e.source in states and e.target not in states and e.target in accepted
            ]
            for edge in out:
                before = self.back(edge, accepted[edge.target], within.get(edge.source, self.space.nothing))
                goal[edge.source] = goal[edge.source] | before
            inside = [e for e in self.edges if e.source in states and e.target in states]
            accepted.update(self.reaching(goal, within, inside))
        return accepted

    def fair(self, within: Mapping[int, S]) -> Iterator[tuple[Sets[S], frozenset[int]]]:
        """By component of the automaton: where an accepted path may stay for ever, and the component."""
        for component in self.components:
            states = frozenset(component)
            begin = {q: within[q] for q in component if within.get(q)}
            inside = [e for e in self.edges if e.source in begin and e.target in begin]
            yield (self._fair(begin, inside) if begin else {}), states

    def _fair(self, within: Sets[S], inside: Sequence[ProductEdge[S]]) -> Sets[S]:
        """Product states from which a run may meet all marks and constraints for ever, region by region.

        A cycle of the product stays in a region of the space as its shadow there does, so that each region
        has a fixpoint of its own and is asked only for the constraints that some of its states do not meet.
        """
        marks = frozenset[int]().union(*(edge.marks for edge in inside))
        if not inside or len(marks) < self.automaton.marks:
            return {}
        (first, *more) = inside
        loop = first.source == first.target and first.transitions is None
        if loop and not more and not self.meetings(inside):
            along = first.states & within[first.source]
            resting = along & (self.resting - self.space.dead)
            staying = self.space.staying(along)
            return {first.source: staying | self.space.reaching(resting, along) if resting else staying}
        asked = reduce(or_, within.values())
        unmet = [(c, (asked - c.states) - self.resting) for c in self.constraints]
        fair: Sets[S] = {}
        for region, constraints in by_region(self.space, unmet):
            here = {q: states & region for q, states in within.items()}
            meetings = self.meetings(inside, constraints)
            for q, states in self._hull(
                {q: states for q, states in here.items() if states}, inside, meetings
            ).items():
                fair[q] = fair.get(q, self.space.nothing) | states
        return fair

    def _hull(
        self, fair: Sets[S], inside: Sequence[ProductEdge[S]], meetings: Sequence[Meeting[S]]
    ) -> Sets[S]:
        """Greatest fixpoint: product states from which a run meets everything again and again inside some."""
        while fair:
            narrower = self._with_successor(fair, inside)
            for met, _, _ in meetings:
                if narrower:
                    narrower = self.reaching(met(narrower), narrower, inside)
            narrower = {q: states for q, states in narrower.items() if states}
            if all(not states - narrower.get(q, self.space.nothing) for q, states in fair.items()):
                break
            fair = narrower
        return fair

    def _with_successor(self, sets: Sets[S], inside: Collection[ProductEdge[S]]) -> Sets[S]:
        """The product states of some sets from which some edge leads into these sets."""
        continued: Sets[S] = {}
        for edge in inside:
            if edge.source in sets and edge.target in sets:
                before = self.back(edge, sets[edge.target], sets[edge.source])
                continued[edge.source] = continued.get(edge.source, self.space.nothing) | before
        return continued

    def meetings(
        self, inside: Collection[ProductEdge[S]], constraints: Sequence[Constraint[S]] | None = None
    ) -> list[Meeting[S]]:
        """The marks and constraints that a path along some edges must meet infinitely often.

        A mark that every edge bears is left out.

        Args:
            inside: The edges.
            constraints: Those that count; all by default.

        Returns:
            For each: a function from sets to their product states at which it is met, there or by a step
            inside the sets; the edges that bear the mark; the transitions whose firing meets the constraint.
        """
        meetings: list[Meeting[S]] = []
        for mark in sorted(frozenset[int]().union(*(edge.marks for edge in inside))):
            bearing = [edge for edge in inside if mark in edge.marks]
            if len(bearing) < len(inside):
                meetings.append((partial(self._with_successor, inside=bearing), bearing, None))
        for constraint in self.constraints if constraints is None else constraints:
            met = partial(self._met, constraint, inside=inside)
            meetings.append((met, (), constraint.transitions or None))
        return meetings

    def _met(self, constraint: Constraint[S], sets: Sets[S], inside: Collection[ProductEdge[S]]) -> Sets[S]:
        """Product states of some sets that meet a constraint; a state without successors meets all."""
        here = constraint.states | self.resting
        met = {q: states & here for q, states in sets.items()}
        asked = frozenset(constraint.transitions)
        for edge in inside if asked else ():
            if edge.source in sets and edge.target in sets:
                fired = asked if edge.transitions is None else asked & edge.transitions
                among = edge.states & sets[edge.source]
                before = self.space.before(sets[edge.target], fired, among=among)
                met[edge.source] = met[edge.source] | before
        return met


def _joined(edges: Iterator[ProductEdge[S]]) -> list[ProductEdge[S]]:
    """Merges edges that differ only in the states that they read; drops those that read no state."""
    joined: dict[object, ProductEdge[S]] = {}
    for e in edges:
        key = e.source, e.target, e.marks, e.transitions, e.rests
        if not e.states:
            continue
        states = e.states | joined[key].states if key in joined else e.states
        joined[key] = ProductEdge(e.source, e.target, e.marks, states, e.transitions, e.rests)
    return list(joined.values())


def _by(
    edges: Collection[ProductEdge[S]], key: Callable[[ProductEdge[S]], int]
) -> dict[int, list[ProductEdge[S]]]:
    groups: dict[int, list[ProductEdge[S]]] = {}
    for edge in edges:
        groups.setdefault(key(edge), []).append(edge)
    return groups
