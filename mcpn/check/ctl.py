"""CTL on decision diagrams: the states of a graph that satisfy a formula, as a set.

Everything is evaluated inside the reachable markings. ``E[f U g]`` is backward saturation inside ``f | g``
where the net has no priorities (constrained saturation: Zhao, Ciardo, *Symbolic CTL model checking of
asynchronous systems using constrained saturation*, ATVA 2009); with priorities it alternates with single
steps back over events, which leave stable markings only. Fair states are found as Emerson and Lei do
(*Efficient model checking in fragments of the propositional mu-calculus*, LICS 1986).

Paths are maximal: infinite, or ending in a state without successors, as in the Model Checking Contest.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property, partial
from typing import Protocol

from mcpn._kernel import Zdd
from mcpn.check.logic.formulas import (
    EG,
    EU,
    EX,
    And,
    Const,
    Core,
    Deadlock,
    Fires,
    Justice,
    Not,
    Or,
    Stable,
    TokenBound,
    walk,
)
from mcpn.net.petri import Marking, PetriNet
from mcpn.space.encoding import distinct
from mcpn.space.symbolic import SymbolicSpace, chained, elements

LEAST = -(2**62)


class SymbolicGraph(Protocol):
    """A graph whose states are markings, as far as evaluation needs to know it."""

    space: SymbolicSpace
    states: Zdd
    initial: Zdd

    def before(self, after: Zdd, transitions: Iterable[int] | None = None) -> Zdd:
        """States with an edge into a set, of some transitions if so asked."""

    def without_way(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set."""

    def until(self, along: Zdd, goal: Zdd) -> Zdd:
        """States from which some path through ``along`` leads into ``goal``, the goal's own included."""

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""

    def successors(self, marking: Marking) -> list[tuple[tuple[int, ...], Marking]]:
        """Edges of a state: the transitions fired, and the state after them."""


class SymbolicMarkings:
    """The markings graph of a net.

    Args:
        space: Its reachable markings.

    Attributes:
        anywhere: Transitions that fire wherever they have their tokens.
        stable_only: Transitions that priorities let fire in stable markings only.
        back: By transition, the event that undoes it.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        self.space = space
        self.net: PetriNet = space.encoding.net
        self.states = space.reachable
        self.initial = space.encoding.initial()
        self.back = space.encoding.undoing
        first = {t for t in self.back if self.net.transitions[t].internal or not self.net.priorities}
        self.anywhere = [t for t in self.back if t in first]
        self.stable_only = [t for t in self.back if t not in first]

    def before(self, after: Zdd, transitions: Iterable[int] | None = None) -> Zdd:
        """States with an edge into a set, of some transitions if so asked."""
        wanted = None if transitions is None else set(transitions)
        anywhere, stable_only = (
            [self.back[t] for t in part if wanted is None or t in wanted]
            for part in (self.anywhere, self.stable_only)
        )
        found = after.images(anywhere, within=self.states)
        if stable_only and self.space.stable is not None:
            found |= after.images(stable_only, within=self.space.stable)
        return found

    def without_way(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set."""
        left = states.beyond(into, [self.back[t] for t in self.anywhere])
        if not self.stable_only or self.space.stable is None:
            return left
        settled = left & self.space.stable
        return (left - settled) | settled.beyond(into, [self.back[t] for t in self.stable_only])

    def until(self, along: Zdd, goal: Zdd) -> Zdd:
        """States from which some path through ``along`` leads into ``goal``, the goal's own included."""
        within = along | goal
        free = [self.back[t] for t in self.anywhere]
        found = goal.saturate(free, within=within)
        if self.space.stable is None:
            return found
        settled = within & self.space.stable

        def back(states: Zdd, events: list[int]) -> Zdd:
            return states.images(events, within=settled).saturate(free, within=within)

        return chained(found, [partial(back, events=events) for events in self._by_element(self.back)])

    def reached(self, begin: Zdd) -> Zdd:
        """States that some path from a set leads to, the set's own included."""
        forth, stable = self.space.encoding.events, self.space.stable
        free = [forth[t] for t in self.anywhere]
        found = begin.saturate(free)
        if stable is None:
            return found

        def ahead(states: Zdd, events: list[int]) -> Zdd:
            return (states & stable).images(events).saturate(free)

        return chained(found, [partial(ahead, events=events) for events in self._by_element(forth)])

    def _by_element(self, events: Mapping[int, int]) -> list[list[int]]:
        """Events of transitions that wait for stable markings, by the element that they are of."""
        wanted = set(self.stable_only)
        return [
            distinct(events[t] for t in of if t in wanted)
            for of in elements(self.space.encoding)
            if not wanted.isdisjoint(of)
        ]

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""
        encoding, space = self.space.encoding, self.space
        found = encoding.store.empty()
        for markings, only in ((self.states, self.anywhere), (space.stable, self.stable_only)):
            wanted = set(only).intersection(transitions)
            conditions = [c for t in sorted(wanted) if (c := encoding.enabling[t]) is not None]
            if markings is not None and conditions:
                found |= markings - markings.without(conditions)
        return found

    def successors(self, marking: Marking) -> list[tuple[tuple[int, ...], Marking]]:
        """Edges of a state: the transitions fired, and the state after them."""
        return [((t,), self.net.fire(marking, t)) for t in self.net.enabled(marking)]


class SymbolicAlternatives:
    """The alternatives graph of a net with priorities whose internal evolution is confluent and ends.

    Args:
        space: The reachable markings of the net.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        assert space.stable is not None, "the alternatives graph is of nets with priorities"
        self.space = space
        self.markings = SymbolicMarkings(space)
        self.net = self.markings.net
        self.states = space.stable
        encoding = space.encoding
        self.initial = encoding.initial().saturate(encoding.internal) & space.stable

    def before(self, after: Zdd, transitions: Iterable[int] | None = None) -> Zdd:
        """States with an edge into a set, of some transitions if so asked."""
        ending = after.saturate(self.space.encoding.internal_back, within=self.space.reachable)
        wanted = set(self.markings.stable_only)
        if transitions is not None:
            wanted.intersection_update(transitions)
        return ending.images([self.markings.back[t] for t in sorted(wanted)], within=self.states)

    def without_way(self, states: Zdd, into: Zdd) -> Zdd:
        """Those of some states that have no edge into a set."""
        return states - self.before(into)

    def until(self, along: Zdd, goal: Zdd) -> Zdd:
        """States from which some path through ``along`` leads into ``goal``, the goal's own included."""
        found = new = goal
        while new:
            new = (self.before(new) & along) - found
            found |= new
        return found

    def enabling(self, transitions: Collection[int]) -> Zdd:
        """States with an edge of some of these transitions."""
        return self.markings.enabling(set(self.markings.stable_only).intersection(transitions))

    def successors(self, marking: Marking) -> list[tuple[tuple[int, ...], Marking]]:
        """Edges of a state: the transitions fired, and the state after them."""
        found = []
        for t in self.net.enabled(marking):
            fired, at = [t], self.net.fire(marking, t)
            while (enabled := self.net.enabled(at)) and self.net.transitions[enabled[0]].internal:
                fired.append(enabled[0])
                at = self.net.fire(at, enabled[0])
            found.append((tuple(fired), at))
        return found


class Evaluation:
    """Evaluates formulas on one graph; sub-formulas that occur again are not evaluated again.

    Args:
        graph: The graph.
        fair: Justice constraints: infinite paths that satisfy one of them only finitely often do not count.
    """

    def __init__(self, graph: SymbolicGraph, fair: Sequence[Justice] = ()) -> None:
        self.graph = graph
        self.fair = tuple(fair)
        self._known: dict[Core, Zdd] = {}
        self.plain: Evaluation = Evaluation(graph) if fair else self  # constraints speak of all paths

    def holds(self, formula: Core) -> bool:
        """Whether the initial state satisfies a formula; no more is evaluated than that takes."""
        match formula:
            case Not(operand):
                return not self.holds(operand)
            case And(operands):
                return all(self.holds(operand) for operand in sorted(operands, key=_effort))
            case Or(operands):
                return any(self.holds(operand) for operand in sorted(operands, key=_effort))
            case EU(Const(True), right) if not self.fair:
                return bool(self.states(right))  # every state is reachable
            case EG(operand) if not self.fair:
                return bool(self.graph.initial & self._stays(self.states(operand), self.graph.initial))
        return bool(self.graph.initial & self.states(formula))

    def states(self, formula: Core) -> Zdd:
        """The states that satisfy a formula."""
        if formula not in self._known:
            self._known[formula] = self._evaluate(formula)
        return self._known[formula]

    def _evaluate(self, formula: Core) -> Zdd:
        graph, empty = self.graph, self.graph.space.encoding.store.empty()
        match formula:
            case Const(value):
                return graph.states if value else empty
            case Not(operand):
                return graph.states - self.states(operand)
            case And(operands):
                found = graph.states
                for operand in operands:
                    found &= self.states(operand)
                return found
            case Or(operands):
                found = empty
                for operand in operands:
                    found |= self.states(operand)
                return found
            case TokenBound(weights, bound):
                levels, constant = graph.space.encoding.weigh(dict(weights))
                # Sums of tokens are far from these bounds, which the kernel can say.
                most = max(LEAST, min(bound - constant, -LEAST))
                return graph.states.weighing(levels, LEAST, most)
            case Fires(transitions):
                return graph.enabling(transitions)
            case Deadlock():
                return self.dead
            case Stable():
                stable = graph.space.stable
                return graph.states if stable is None else graph.states & stable
            case EX(operand):
                return graph.before(self.states(operand) & self.fair_states)
            case EU(left, right):
                return graph.until(self.states(left), self.states(right) & self.fair_states)
            case EG(operand):
                return self._always(self.states(operand))
        raise TypeError(f"no formula: {formula!r}")

    @property
    def dead(self) -> Zdd:
        """States without successors, the same on both graphs: a dead marking is stable."""
        return self.graph.space.dead

    @cached_property
    def fair_states(self) -> Zdd:
        """States from which some fair path begins; all of them where nothing is asked of paths."""
        return self._always(self.graph.states) if self.fair else self.graph.states

    def _always(self, along: Zdd) -> Zdd:
        """States from which some fair path stays in a set."""
        if not self.fair:
            return self._stays(along)
        return self.graph.until(along, (along & self.dead) | self.hull(along))

    def hull(self, along: Zdd) -> Zdd:
        """States of a set from which each constraint can be met, and the hull be reached again, inside it."""
        found = along
        while (narrower := self.recurring(along, found)) != found:
            found = narrower
        return found

    def recurring(self, along: Zdd, found: Zdd) -> Zdd:
        """One round of Emerson and Lei: each constraint can be met, and then the set be reached again."""
        for constraint in self.fair:
            found = found & self.graph.before(self.graph.until(along, self.met(constraint, found)))
        return found

    def met(self, constraint: Justice, found: Zdd) -> Zdd:
        """States of a set at which a constraint is met, there or by the next step inside the set."""
        here = self.plain.states(constraint.states) & found
        if constraint.transitions:
            here |= self.graph.before(found, constraint.transitions) & found
        return here

    def _stays(self, along: Zdd, asked: Zdd | None = None) -> Zdd:
        """States from which some path stays in a set: those are taken out whose every way leaves it.

        Only what led into states just taken out need be looked at again. Where it is asked for some states
        only, it ends as soon as they are out.
        """
        graph, found, ends = self.graph, along, self.dead
        lost = graph.without_way(along - ends, along)
        while lost and (asked is None or asked & found):
            found -= lost
            lost = graph.without_way((graph.before(lost) & found) - ends, found)
        return found


def _effort(formula: Core) -> int:
    """How much a formula takes: operators that need a fixpoint count most."""
    costs = {EG: 100, EU: 10, EX: 10}
    return sum(costs.get(type(inside), 1) for inside, _ in walk(formula))
