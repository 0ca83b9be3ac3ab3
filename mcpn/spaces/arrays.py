"""The space of a graph in arrays: sets are masks over the states that the explicit engine has listed.

Every operation is linear in the size of the graph.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mcpn._kernel import Zdd
from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.structure import needs
from mcpn.spaces.algebra import Edge, Guards
from mcpn.spaces.by_steps import BySteps
from mcpn.spaces.markings.graph import Mask, StateGraph, rows
from mcpn.spaces.projections import ImageStore
from mcpn.spaces.stable.alternatives import AlternativesGraph

AT_ONCE = 1 << 20
"""States whose edges are counted at a time, so that not all labels are held."""


@dataclass(frozen=True, eq=False, slots=True)
class ArraySet:
    """A set of states of one graph.

    Args:
        mask: Shape (states,).
    """

    mask: Mask

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ArraySet) and np.array_equal(self.mask, other.mask)

    def __hash__(self) -> int:
        return hash(self.mask.tobytes())

    def __and__(self, other: ArraySet) -> ArraySet:
        return ArraySet(self.mask & other.mask)

    def __or__(self, other: ArraySet) -> ArraySet:
        return ArraySet(self.mask | other.mask)

    def __sub__(self, other: ArraySet) -> ArraySet:
        return ArraySet(self.mask & ~other.mask)

    def __bool__(self) -> bool:
        return bool(self.mask.any())

    def count(self) -> int:
        """How many states the set has."""
        return int(np.count_nonzero(self.mask))

    def pick(self) -> int | None:
        """The state with the lowest number."""
        return int(self.mask.argmax()) if self else None


class ArraySpace(BySteps[ArraySet]):
    """A markings graph or an alternatives graph in arrays.

    Args:
        graph: The graph.
    """

    def __init__(self, graph: StateGraph) -> None:
        self.graph = graph
        self.net: PetriNet = graph.net
        self.nothing = ArraySet(np.zeros(graph.states, np.bool_))
        self.everything = ArraySet(np.ones(graph.states, np.bool_))
        self.initial = self.single(0)

    @cached_property
    def dead(self) -> ArraySet:
        """States without an edge."""
        return ArraySet(self.graph.dead)

    @cached_property
    def stable(self) -> ArraySet:
        """States that enable no internal transition; all where the net has no priorities."""
        if isinstance(self.graph, AlternativesGraph) or not self.net.priorities:
            return self.everything
        return self.everything - self.enabling(self.net.events.internal)

    def single(self, state: int) -> ArraySet:
        """The set that holds one state, given by its number."""
        mask = np.zeros(self.graph.states, np.bool_)
        mask[state] = True
        return ArraySet(mask)

    def marking(self, state: int) -> Marking:
        """The marking of a state, as tokens by place."""
        return self.graph.marking(state)

    def marked(self, places: Collection[int]) -> ArraySet:
        """States that mark at least one of some places."""
        mask = np.zeros(self.graph.states, np.bool_)
        for place in places:
            mask |= self.graph.marked(place)
        return ArraySet(mask)

    def restricted(self, states: ArraySet, marked: Collection[int], unmarked: Collection[int]) -> ArraySet:
        """Those of some states that mark all of some places, and none of others."""
        mask = states.mask.copy()
        for place in marked:
            mask &= self.graph.marked(place)
        for place in unmarked:
            mask &= ~self.graph.marked(place)
        return ArraySet(mask)

    def at_most(self, weights: Mapping[int, int], bound: int) -> ArraySet:
        """States whose weighted sum of tokens is at most a bound."""
        return ArraySet(self.graph.satisfying([[(weights, bound)]]))

    def enabling(self, transitions: Collection[int]) -> ArraySet:
        """States with an edge of some of these transitions."""
        if self.net.priorities:
            mask = np.zeros(self.graph.states, np.bool_)
            mask[self.graph.sources[self._carrying(transitions)]] = True
            return ArraySet(mask)
        wanted = ([({p: -1}, -n) for p, n in needs(self.net, t).items()] for t in transitions)
        return ArraySet(self.graph.satisfying(wanted))

    def firings(self, states: ArraySet) -> Mapping[int, int]:
        """In how many of some states each transition has an edge."""
        counts = np.zeros(len(self.net.transitions), np.int64)
        listed = np.flatnonzero(states.mask)
        for first in range(0, len(listed), AT_ONCE):
            labels = self.graph.labels_of(listed[first : first + AT_ONCE])
            counts += np.bincount(labels, minlength=len(counts))
        return {t: count for t, count in enumerate(counts.tolist()) if count}

    def image(self, states: ArraySet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some states mark some places; see :meth:`mcpn.spaces.algebra.Space.image`."""
        if not places:
            return images.of_rows([()] if states else [])
        columns = np.stack([self.graph.marked(p) for p in places], axis=1)[states.mask]
        # Rows as words of 64 bits: equal ones are found by sorting numbers.
        packed = np.packbits(columns, axis=1)
        words = np.pad(packed, ((0, 0), (0, -packed.shape[1] % 8))).view(np.uint64)
        # Not asked for indices, np.unique would load numpy.ma.
        _, chosen = np.unique(words[:, 0] if words.shape[1] == 1 else words, axis=0, return_index=True)
        return images.of_rows(np.flatnonzero(row).tolist() for row in columns[chosen])

    def before(
        self,
        states: ArraySet,
        transitions: Collection[int] | None = None,
        guards: Guards[ArraySet] = None,
        among: ArraySet | None = None,
    ) -> ArraySet:
        """States with an edge into some states."""
        before = ArraySet(self.graph.before(states.mask, self._edges(transitions, guards)))
        return before if among is None else before & among

    def after(
        self,
        states: ArraySet,
        transitions: Collection[int] | None = None,
        guards: Guards[ArraySet] = None,
    ) -> ArraySet:
        """States that an edge leads to from some states."""
        edges = rows(self.graph.offsets, np.flatnonzero(states.mask))
        if (wanted := self._edges(transitions, guards)) is not None:
            edges = edges[wanted[edges]]
        mask = np.zeros(self.graph.states, np.bool_)
        mask[self.graph.targets[edges]] = True
        return ArraySet(mask)

    def crossing(self, among: ArraySet, into: ArraySet) -> Iterator[tuple[int, ArraySet]]:
        """Transitions with edges from some states into others, each with the states before it."""
        graph = self.graph
        edges = np.flatnonzero(among.mask[graph.sources] & into.mask[graph.targets])
        for t in np.flatnonzero(np.bincount(graph.labels[edges])).tolist():
            mask = np.zeros(graph.states, np.bool_)
            mask[graph.sources[edges[graph.labels[edges] == t]]] = True
            yield t, ArraySet(mask)

    def reaching(
        self,
        goal: ArraySet,
        along: ArraySet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[ArraySet] = None,
    ) -> ArraySet:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        edges = self._edges(transitions, guards)
        return ArraySet(self.graph.reaching(goal.mask, edges, None if along is None else along.mask))

    def reached(
        self,
        begin: ArraySet,
        along: ArraySet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[ArraySet] = None,
    ) -> ArraySet:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        edges = self._edges(transitions, guards)
        if along is None:
            return ArraySet(self.graph.reached(edges, begin.mask))
        return ArraySet(self.graph.reached(edges, (begin & along).mask, along.mask))

    def staying(
        self, along: ArraySet, asked: ArraySet | None = None, transitions: Collection[int] | None = None
    ) -> ArraySet:
        """States from which a maximal run stays in a set; see :meth:`mcpn.spaces.algebra.Space.staying`."""
        if transitions is not None:
            return ArraySet(self.graph.staying(along.mask, self._carrying(transitions)))
        if asked is not None:
            return asked if self.graph.stays(asked.mask, along.mask) else self.nothing
        return ArraySet(self.graph.staying(along.mask))

    def _carrying(self, transitions: Collection[int]) -> Mask:
        wanted = np.zeros(len(self.net.transitions), np.bool_)
        wanted[list(transitions)] = True
        return np.asarray(wanted[self.graph.labels], np.bool_)

    def _edges(self, transitions: Collection[int] | None, guards: Guards[ArraySet]) -> Mask | None:
        """Edges of some transitions, shape (edges,); ``None``, which is quicker, for all."""
        if transitions is None and not guards:
            return None
        edges = np.ones(self.graph.edges, np.bool_) if transitions is None else self._carrying(transitions)
        for transition, states in (guards or {}).items():
            edges &= (self.graph.labels != transition) | states.mask[self.graph.sources]
        return edges

    def edges(self, state: int) -> Iterator[Edge]:
        """The edges of one state."""
        return (Edge(t, after) for t, after in self.graph.successors(state))

    def run(
        self,
        begin: int,
        goal: ArraySet,
        along: ArraySet | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[ArraySet] = None,
    ) -> list[Edge] | None:
        """A shortest run from a state into a goal; see :meth:`mcpn.spaces.algebra.Space.run`."""
        passing = None if along is None else along.mask
        edges = self.graph.run_to(goal.mask, begin, self._edges(transitions, guards), passing)
        labels, targets = self.graph.labels, self.graph.targets
        return None if edges is None else [Edge(int(labels[e]), int(targets[e])) for e in edges]
