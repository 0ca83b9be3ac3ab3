"""A run that shows that some path satisfies a formula: to a cycle that repeats for ever, or to an end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, Generic, Literal, NamedTuple, TypeAlias, cast

from mcpn.logic.ltl.automaton import Automaton, AutomatonEdge
from mcpn.logic.ltl.product import Product, ProductEdge, Sets
from mcpn.nets.petri import PetriNet
from mcpn.spaces.algebra import Edge, S
from mcpn.spaces.search.goal import Formula, Goal, as_goal, encode
from mcpn.spaces.search.searches import MAX_BYTES, Searches


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


# --- Some path that an automaton accepts, found marking by marking: no space is built ---------------------
#
# The native kernel searches the product of the net and the automaton depth first, in an order that a seed
# draws. It ends with a lasso; or it has seen the whole product without one, and no path is accepted.

MOST_MARKS = 64
Outcome: TypeAlias = Literal["found", "none", "steps", "bytes", "tokens"]


class FoundPath(NamedTuple):
    """How a search for an accepted path ended.

    Args:
        outcome: A path was found, or there is none, or a limit was hit: on steps, on memory, or on tokens in
            one place.
        run: Transitions of the path, up to where it repeats, or ends, or where all that goes on is accepted.
        cycle: Index of the transition with which the part begins that repeats, if one does.
    """

    outcome: Outcome
    run: tuple[int, ...] = ()
    cycle: int | None = None


class PathSearch:
    """Looks for a path of a net from its initial marking that an automaton accepts.

    Args:
        net: The net.
        automaton: Its literals are conditions on markings, or steps.
        searches: Walks on the net, where there are some already.

    Attributes:
        fits: Whether the kernel can follow both.
    """

    def __init__(self, net: PetriNet, automaton: Automaton, searches: Searches | None = None) -> None:
        self._net, self._searches = net, searches or Searches(net)
        self._goals: dict[Formula, Goal] = {}
        self.fits = self._searches.fits and automaton.marks <= MOST_MARKS
        for literal in dict.fromkeys(f for edges in automaton.edges for edge in edges for f in edge.reads):
            goal = as_goal(literal, net)
            if goal is None:
                self.fits = False
                return
            self._goals[literal] = goal
        self._encoded, self._roots = encode(list(self._goals.values()), len(net.places))
        self._numbers = {literal: number for number, literal in enumerate(self._goals)}
        self._edges = [list(map(self._edge, edges)) for edges in automaton.edges]
        self._marks = (1 << automaton.marks) - 1
        self._all = [q in automaton.accepting_all for q in range(len(automaton.edges))]

    def search(self, max_steps: int, seed: int, max_bytes: int = MAX_BYTES) -> FoundPath:
        """Searches, with a limit on steps of the product and on memory."""
        outcome, _, run, cycle = self._searches.kernel.lasso(
            self._net.initial,
            self._encoded,
            self._roots,
            self._edges,
            self._marks,
            self._all,
            max_steps,
            max_bytes,
            seed,
        )
        return FoundPath(cast(Outcome, outcome), tuple(run), cycle)

    def _edge(self, edge: AutomatonEdge) -> tuple[Sequence[int], int, int, Sequence[int] | None, bool]:
        fired, rests = edge.fires(len(self._net.transitions))
        return (
            [self._numbers[literal] for literal in edge.reads],
            sum(1 << mark for mark in edge.marks),
            edge.target,
            None if fired is None else sorted(fired),
            rests,
        )
