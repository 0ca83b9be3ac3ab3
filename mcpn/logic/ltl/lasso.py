"""A run that shows that some path satisfies a formula: to a cycle that repeats for ever, or to an end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Generic

from mcpn.logic.ltl.product import Product, ProductEdge, Sets
from mcpn.spaces.algebra import Edge, S


class Lasso(Generic[S]):
    """A run beside an accepted run of an automaton, as short as closures by layers make it.

    Args:
        product: The space and the automaton.
        start: A member of the space from which some path is accepted.

    Attributes:
        steps: The edges of the run.
        cycle: Index of the step with which the part begins that is repeated for ever; ``None`` where nothing
            is repeated.
        decided: Whether every continuation of the run is accepted. A run that is not decided and repeats
            nothing ends in a state without successors.
    """

    def __init__(self, product: Product[S], start: Any) -> None:
        self.product, self.space = product, product.space
        self.steps: list[Edge] = []
        self.cycle: int | None = None
        self._state, self._at = 0, start
        self._passed: list[tuple[int, Any]] = []  # where each step begins
        within = product.reached(self.space.single(start))
        fair: Sets[S] = {}
        for sets, _ in product.fair(within):
            fair.update({q: states for q, states in sets.items() if states})
        decided = product.decided(fair, within)
        arrived = self._follow(_union(fair, decided), within, product.edges)
        assert arrived, "some path is accepted"
        self.decided = self._in(decided)
        if self.decided:
            while self._passed and self._decides(*self._passed[-1]):
                self._state, self._at = self._passed.pop()
                self.steps.pop()
            return
        component = next(set(c) for c in product.components if self._state in c)
        inside = {q: states for q, states in fair.items() if q in component}
        self._go_round(inside, [e for e in product.edges if {e.source, e.target} <= component])

    @property
    def _ended(self) -> bool:
        return bool(self.space.single(self._at) & self.space.dead)

    def _in(self, sets: Mapping[int, S]) -> bool:
        return self._state in sets and bool(self.space.single(self._at) & sets[self._state])

    def _decides(self, state: int, at: Any) -> bool:
        """Whether a run that has come here need not show the next step, whichever it is.

        All that follows is accepted, whatever it is, and the automaton asks of the step at most what it is
        not: it rests. A step that a formula asks for is shown.
        """
        here, everything = self.space.single(at), self.product.automaton.accepting_all
        leaving = (e for e in self.product.edges if (e.source, e.rests) == (state, True) and e.states & here)
        ways = [e.transitions for e in leaving if e.target in everything]
        return bool(ways) and all(
            any(fired is None or edge.transition in fired for fired in ways) for edge in self.space.edges(at)
        )

    def _go_round(self, fair: Sets[S], inside: Collection[ProductEdge[S]]) -> None:
        """Appends a cycle that meets every mark and constraint, further on where none leads back."""
        while not self._ended:
            begin, first = {self._state: self.space.single(self._at)}, len(self.steps)
            for meeting in self.product.meetings(inside):
                self._meet(fair, inside, *meeting)
            if len(self.steps) == first:
                self._step(fair, inside)
            if not self._ended and self._follow(begin, fair, inside):
                self.cycle = first
                return

    def _meet(
        self,
        fair: Sets[S],
        inside: Collection[ProductEdge[S]],
        met: Callable[[Sets[S]], Sets[S]],
        bearing: Collection[ProductEdge[S]],
        fired: Collection[int] | None,
    ) -> None:
        """Appends a path to where a mark or constraint is met, and the step that meets it, if a step does."""
        arrived = self._ended or self._follow(met(fair), fair, inside)
        assert arrived, "it is met from everywhere in the fair sets"
        if not self._ended and (bearing or fired):
            self._step(fair, bearing or inside, fired)

    def _follow(self, goal: Sets[S], within: Mapping[int, S], edges: Collection[ProductEdge[S]]) -> bool:
        """Appends a shortest run through some sets to a goal; nothing, and false, where there is none."""
        layers, seen = [goal], dict(goal)
        while not self._in(layers[-1]):
            layer: Sets[S] = {}
            for edge in edges:
                if edge.target not in layers[-1] or edge.source not in within:
                    continue
                before = self.product.back(edge, layers[-1][edge.target], within[edge.source])
                new = before - seen[edge.source] if edge.source in seen else before
                if new:
                    layer[edge.source] = layer[edge.source] | new if edge.source in layer else new
            if not layer:
                return False
            for q, states in layer.items():
                seen[q] = seen[q] | states if q in seen else states
            layers.append(layer)
        for layer in reversed(layers[:-1]):
            if self._ended:  # what is left repeats this state
                break
            self._step(layer, edges)
        return True

    def _step(
        self, into: Mapping[int, S], edges: Collection[ProductEdge[S]], fired: Collection[int] | None = None
    ) -> None:
        """Appends the first edge into some sets, of some transitions where they are given."""
        here = self.space.single(self._at)
        ways = [e for e in edges if e.source == self._state and e.target in into and e.states & here]
        for edge in self.space.edges(self._at):
            for way in ways:
                allowed = way.transitions is None or edge.transition in way.transitions
                wanted = not fired or edge.transition in fired
                if allowed and wanted and self.space.single(edge.target) & into[way.target]:
                    self.steps.append(edge)
                    self._passed.append((self._state, self._at))
                    self._state, self._at = way.target, edge.target
                    return
        # A constraint that a firing may meet has then been met by the state.
        assert fired, "closures said that there is such a step"


def _union(one: Sets[S], other: Sets[S]) -> Sets[S]:
    return {q: one[q] | other[q] if q in one and q in other else (one | other)[q] for q in one | other}
