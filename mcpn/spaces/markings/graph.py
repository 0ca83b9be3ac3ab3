"""A finite graph of markings in arrays: the shape that every explicit result shares.

Markings are rows of 64-bit words, a bit or a field of bits for each place; edges are in compressed sparse
rows (CSR), those of state ``s`` at ``offsets[s]:offsets[s + 1]``, in the order of the net's transitions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from mcpn._kernel import (
    before,
    incoming,
    satisfying,
    spread,
    staying,
    stays,
    sweep_reaching,
    sweep_staying,
    weigh,
)
from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.notebook import Drawn
from mcpn.records import record

if TYPE_CHECKING:
    import networkx as nx

Words = npt.NDArray[np.uint64]
Ints = npt.NDArray[np.int64]
Targets = npt.NDArray[np.uint32]
Mask = npt.NDArray[np.bool_]
Field: TypeAlias = tuple[int, int, int]


@record(frozen=True, eq=False)
class StateGraph(Drawn):
    """Reachable markings and the firings between them; state 0 is the initial one.

    Args:
        net: The net.
        markings: Shape (states, words), bit ``p % 64`` of word ``p // 64`` for place ``p``.
        offsets: Shape (states + 1,).
        targets: Shape (edges,), the state after each firing.
        labelled: Shape (edges,), the transition fired; or what finds those of some markings.
        fields: By place the word, the lowest bit and the number of bits that count its tokens, where places
            hold several.
        told: What a marking says beside its tokens, by name, where more is known of the net: of a mission
            what runs.
    """

    net: PetriNet
    markings: Words
    offsets: Ints
    targets: Ints | Targets
    labelled: Ints | Callable[[Words], Ints]
    fields: tuple[Field, ...] | None = field(default=None, kw_only=True)
    told: Callable[[tuple[int, ...]], Mapping[str, object]] | None = field(default=None, kw_only=True)

    def __repr__(self) -> str:
        sizes = f"{len(self.markings):,} states, {self.edges:,} edges"
        return f"<{type(self).__name__} of {self.net.name}: {sizes}>"

    @property
    def states(self) -> int:
        """Number of states."""
        return len(self.offsets) - 1

    @property
    def edges(self) -> int:
        """Number of edges: firings, so two transitions between the same states count twice."""
        return len(self.targets)

    @cached_property
    def labels(self) -> Ints:
        """The transition of each firing, shape (edges,)."""
        return self.labelled(self.markings) if callable(self.labelled) else self.labelled

    def labels_of(self, states: Ints) -> Ints:
        """The transitions of the firings of some states."""
        if callable(self.labelled):
            return self.labelled(self.markings[states])
        return self.labelled[rows(self.offsets, states)]

    @cached_property
    def sources(self) -> Ints:
        """The state before each firing, shape (edges,)."""
        return np.repeat(np.arange(self.states, dtype=np.int64), np.diff(self.offsets))

    def marked(self, place: int) -> Mask:
        """Which states mark a place, shape (states,)."""
        return self.tokens({place: 1}) > 0

    def tokens(self, weights: Mapping[int, int]) -> Ints:
        """A weighted sum of the tokens of places, shape (states,).

        Raises:
            LimitError: A weight or a sum is beyond 64 bits.
        """
        try:
            return weigh(self.markings, self._sum(weights))
        except OverflowError:
            raise LimitError("a sum of tokens is beyond 64 bits: the limit of arrays was hit") from None

    def satisfying(self, alternatives: Iterable[Iterable[tuple[Mapping[int, int], int]]]) -> Mask:
        """States in which, for one of some alternatives, each weighted sum of tokens is within its bound.

        Raises:
            LimitError: A weight is beyond 64 bits, or a bound beyond 2^126. Sums may be.
        """
        conditions = [[(self._sum(weights), bound) for weights, bound in all_] for all_ in alternatives]
        if any(abs(bound) > 1 << 126 for all_ in conditions for _, bound in all_):
            raise LimitError("a bound of tokens is beyond 2^126: the limit of arrays was hit")
        return satisfying(self.markings, conditions)

    def _sum(self, weights: Mapping[int, int]) -> list[tuple[int, int, int, int]]:
        """A weighted sum of tokens as fields of words with their weights."""
        fields = self.fields
        if any(abs(weight) >= 1 << 63 for weight in weights.values()):
            raise LimitError("a weight of tokens is beyond 64 bits: the limit of arrays was hit")
        return [(*(fields[p] if fields else (*divmod(p, 64), 1)), weight) for p, weight in weights.items()]

    def marking(self, state: int) -> tuple[int, ...]:
        """The marking of a state as tokens by place."""
        row = self.markings[state]
        if self.fields is not None:
            return tuple(int(row[word]) >> shift & (2**width - 1) for word, shift, width in self.fields)
        return tuple(int(row[p // 64]) >> (p % 64) & 1 for p in range(len(self.net.places)))

    def successors(self, state: int) -> Iterator[tuple[int, int]]:
        """Pairs (transition, next state)."""
        targets = self.targets[self.offsets[state] : self.offsets[state + 1]]
        yield from zip(self.labels_of(np.array([state])).tolist(), targets.tolist(), strict=True)

    def __len__(self) -> int:
        """How many states."""
        return self.states

    def __iter__(self) -> Iterator[Mapping[str, int]]:
        """The states in the order of their numbers, each as tokens by the name of a marked place."""
        names = [place.name for place in self.net.places]
        for state in range(self.states):
            tokens = zip(names, self.marking(state), strict=True)
            yield {name: count for name, count in tokens if count}

    def to_networkx(self) -> nx.MultiDiGraph[int]:
        """The graph in networkx, whose algorithms say what mcpn does not ask.

        Returns:
            States as numbers, each with its ``marking`` (tokens by the name of a marked place), of a mission
            also with ``objectives``, ``mode``, ``waiting``, ``refused``, ``out_of_service``, ``facts`` and
            ``outcome``; an edge for each firing, its key and ``transition`` the transition's name, with its
            ``event`` (``None`` for an internal one).
        """
        import networkx

        graph: nx.MultiDiGraph[int] = networkx.MultiDiGraph(name=self.net.name)
        for state, marking in enumerate(self):
            graph.add_node(state, marking=marking, **(self.told(self.marking(state)) if self.told else {}))
        fired = [(t.name, None if t.event is None else str(t.event)) for t in self.net.transitions]
        edges = zip(self.sources.tolist(), self.targets.tolist(), self.labels.tolist(), strict=True)
        for source, target, label in edges:
            name, event = fired[label]
            graph.add_edge(source, target, name, transition=name, event=event)
        return graph

    @cached_property
    def dead(self) -> Mask:
        """Which states have no edge, shape (states,)."""
        return np.asarray(np.diff(self.offsets) == 0, np.bool_)

    @cached_property
    def _onward(self) -> tuple[Ints, Targets]:
        return self.offsets, self.targets.astype(np.uint32, copy=False)

    @cached_property
    def _back(self) -> tuple[Ints, Targets]:
        """Edges in compressed sparse rows by target: offsets, and the source of each edge."""
        return incoming(*self._onward)

    def before(self, states: Mask, edges: Mask | None = None) -> Mask:
        """States with an edge, of some where they are given, into some states."""
        return before(*self._onward, states, edges)

    def reaching(self, goal: Mask, edges: Mask | None = None, along: Mask | None = None) -> Mask:
        """States from which some run leads into the goal (the goal's own states included).

        Args:
            goal: Shape (states,).
            edges: Shape (edges,): edges that the run may take; all by default.
            along: Shape (states,): states that it may pass before the goal; all by default.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        mask, all_ = sweep_reaching(*self._onward, goal, along, edges)
        if all_:
            return mask
        return spread(*(self._back if edges is None else incoming(*self._onward, edges)), mask, along)

    def reached(self, edges: Mask | None, start: int | Ints | Mask = 0, along: Mask | None = None) -> Mask:
        """States that runs lead to.

        Args:
            edges: Shape (edges,): edges that the run may take; all for ``None``.
            start: The state or the states to run from; they are reached themselves.
            along: Shape (states,): states that it may come to; all by default.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        begin = np.zeros(self.states, np.bool_)
        begin[start] = True
        return spread(*self._onward, begin, along, edges)

    def stays(self, begin: Mask, along: Mask) -> bool:
        """Whether a maximal run from one of some states stays in a set; both of shape (states,)."""
        return stays(*self._onward, begin, along)

    def staying(self, along: Mask, edges: Mask | None = None) -> Mask:
        """States from which some maximal run stays in a set: it is endless, or ends in a state without edges.

        States without a next one in the set are dropped, and those that led to these alone after them.

        Args:
            along: The set, shape (states,).
            edges: Shape (edges,): those of the graph that is asked; all by default.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        onward = self._onward
        if edges is not None:
            kept = np.concatenate((np.zeros(1, np.int64), np.cumsum(edges, dtype=np.int64)))
            onward = kept[self.offsets], onward[1][edges]
        left, all_ = sweep_staying(*onward, along)
        return left if all_ else staying(*onward, *(self._back if edges is None else incoming(*onward)), left)

    def run_to(
        self, goal: Mask, start: int = 0, edges: Mask | None = None, along: Mask | None = None
    ) -> list[int] | None:
        """A shortest run into the goal.

        Args:
            goal: Shape (states,).
            start: The state to run from.
            edges: Shape (edges,): edges that the run may take; all by default.
            along: Shape (states,): states that it may pass before the goal; all by default.

        Returns:
            Indices of edges; empty where the start is in the goal, ``None`` where no run leads there.
            The run is repeatable: among shortest runs it follows the lowest numbers.
        """
        if goal[start]:
            return []
        via = np.full(self.states, -1, np.int64)
        frontier = np.array([start], np.int64)
        seen = np.zeros(self.states, np.bool_)
        seen[start] = True
        while len(frontier):
            taken = rows(self.offsets, frontier if along is None else frontier[along[frontier]])
            if edges is not None:
                taken = taken[edges[taken]]
            taken = taken[~seen[self.targets[taken]]]
            reached, first = np.unique(self.targets[taken], return_index=True)
            frontier = reached.astype(np.int64)
            via[frontier] = taken[first]
            seen[frontier] = True
            hits = frontier[goal[frontier]]
            if len(hits):
                return self._run_back(via, int(hits[0]), start)
        return None

    def _run_back(self, via: Ints, state: int, start: int) -> list[int]:
        run: list[int] = []
        while state != start:
            edge = int(via[state])
            run.append(edge)
            state = int(np.searchsorted(self.offsets, edge, "right")) - 1
        return run[::-1]


def rows(offsets: Ints, states: Ints) -> Ints:
    """The edges of some states, or what else rows hold, concatenated in the order of the states.

    Args:
        offsets: Where each row begins, shape (rows + 1,).
        states: The rows wanted.
    """
    lengths = offsets[states + 1] - offsets[states]
    total = int(lengths.sum())
    starts = np.repeat(offsets[states] - np.concatenate(([0], np.cumsum(lengths)[:-1])), lengths)
    return starts + np.arange(total, dtype=np.int64)


def pack(markings: Iterable[int], places: int) -> Words:
    """Rows of words from markings given as integers with a bit per place.

    Args:
        markings: Integers, bit ``p`` for place ``p``.
        places: Number of places.

    Returns:
        Shape (markings, words).
    """
    size = 8 * max(1, -(-places // 64))
    data = b"".join(marking.to_bytes(size, "little") for marking in markings)
    return np.frombuffer(data, dtype="<u8").reshape(-1, size // 8)
