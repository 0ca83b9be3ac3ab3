"""A finite graph of markings in arrays: the shape that every explicit result shares.

Markings are rows of 64-bit words, a bit or a field of bits for each place; edges are in compressed sparse
rows (CSR), those of state ``s`` at ``offsets[s]:offsets[s + 1]``, in the order of the net's transitions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from mcpn.net.petri import PetriNet
from mcpn.notebook import Drawn

Words = npt.NDArray[np.uint64]
Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Field: TypeAlias = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class StateGraph(Drawn):
    """Reachable markings and the firings between them; state 0 is the initial one.

    Args:
        net: The net.
        markings: Shape (states, words), bit ``p % 64`` of word ``p // 64`` for place ``p``.
        offsets: Shape (states + 1,).
        targets: Shape (edges,), the state after each firing.
        labels: Shape (edges,), the transition fired.
        fields: By place the word, the lowest bit and the number of bits that count its tokens, where places
            hold several.
    """

    net: PetriNet
    markings: Words
    offsets: Ints
    targets: Ints
    labels: Ints
    fields: tuple[Field, ...] | None = field(default=None, kw_only=True)

    def __repr__(self) -> str:
        sizes = f"{len(self.markings):,} states, {len(self.labels):,} edges"
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
    def sources(self) -> Ints:
        """The state before each firing, shape (edges,)."""
        return np.repeat(np.arange(self.states, dtype=np.int64), np.diff(self.offsets))

    def marked(self, place: int) -> Mask:
        """Which states mark a place, shape (states,)."""
        if self.fields is not None:
            return self.tokens(place) > 0
        word, bit = divmod(place, 64)
        column: Words = self.markings[:, word]
        return np.asarray((column >> np.uint64(bit)) & np.uint64(1), np.bool_)

    def tokens(self, place: int) -> Ints:
        """The tokens of a place, shape (states,)."""
        word, shift, width = (*divmod(place, 64), 1) if self.fields is None else self.fields[place]
        column: Words = self.markings[:, word]
        return ((column >> np.uint64(shift)) & np.uint64(2**width - 1)).astype(np.int64)

    def marking(self, state: int) -> tuple[int, ...]:
        """The marking of a state as tokens by place."""
        row = self.markings[state]
        if self.fields is not None:
            return tuple(int(row[word]) >> shift & (2**width - 1) for word, shift, width in self.fields)
        return tuple(int(row[p // 64]) >> (p % 64) & 1 for p in range(len(self.net.places)))

    def successors(self, state: int) -> Iterator[tuple[int, int]]:
        """Pairs (transition, next state)."""
        first, last = self.offsets[state], self.offsets[state + 1]
        yield from zip(self.labels[first:last].tolist(), self.targets[first:last].tolist(), strict=True)

    @cached_property
    def dead(self) -> Mask:
        """Which states have no edge, shape (states,)."""
        return np.asarray(np.diff(self.offsets) == 0, np.bool_)

    @cached_property
    def incoming(self) -> tuple[Ints, Ints]:
        """Edges by their target: row bounds of shape (states + 1,), and edges of shape (edges,)."""
        order = np.argsort(self.targets, kind="stable")
        offsets = np.zeros(self.states + 1, np.int64)
        np.cumsum(np.bincount(self.targets, minlength=self.states), out=offsets[1:])
        return offsets, order

    def reaching(self, goal: Mask, along: Mask | None = None) -> Mask:
        """States from which some run leads into the goal (the goal's own states included).

        Args:
            goal: Shape (states,).
            along: Shape (edges,): edges that the run may take; all by default.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        offsets, order = self.incoming
        found = goal.copy()
        frontier = np.flatnonzero(goal)
        while len(frontier):
            edges = order[rows(offsets, frontier)]
            if along is not None:
                edges = edges[along[edges]]
            frontier = _fresh(self.sources[edges], found)
            found[frontier] = True
        return found

    def reached(self, along: Mask, start: int | Ints = 0) -> Mask:
        """States that runs along some edges lead to.

        Args:
            along: Shape (edges,).
            start: The state or the states to run from; they are reached themselves.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        found = np.zeros(self.states, np.bool_)
        found[start] = True
        frontier = np.atleast_1d(np.asarray(start, np.int64))
        while len(frontier):
            edges = rows(self.offsets, frontier)
            frontier = _fresh(self.targets[edges[along[edges]]], found)
            found[frontier] = True
        return found

    def staying(self, along: Mask) -> Mask:
        """States from which some maximal run stays in a set: it is endless, or ends in a state without edges.

        States without a next one in the set are dropped, and those that led to these alone after them.

        Args:
            along: The set, shape (states,).

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        offsets, order = self.incoming
        inside = along[self.sources] & along[self.targets]
        onward = np.bincount(self.sources[inside], minlength=self.states)
        dropped = ~along
        frontier = np.flatnonzero(along & (onward == 0) & ~self.dead)
        while len(frontier):
            dropped[frontier] = True
            edges = order[rows(offsets, frontier)]
            before = self.sources[edges[inside[edges]]]
            np.subtract.at(onward, before, 1)
            frontier = _fresh(before[onward[before] == 0], dropped)
        return ~dropped

    def run_to(self, goal: Mask, start: int = 0, along: Mask | None = None) -> list[int] | None:
        """A shortest run into the goal.

        Args:
            goal: Shape (states,).
            start: The state to run from.
            along: Shape (edges,): edges that the run may take; all by default.

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
            edges = rows(self.offsets, frontier)
            if along is not None:
                edges = edges[along[edges]]
            edges = edges[~seen[self.targets[edges]]]
            frontier, first = np.unique(self.targets[edges], return_index=True)
            via[frontier] = edges[first]
            seen[frontier] = True
            hits = frontier[goal[frontier]]
            if len(hits):
                return self._back(via, int(hits[0]), start)
        return None

    def _back(self, via: Ints, state: int, start: int) -> list[int]:
        run: list[int] = []
        while state != start:
            edge = int(via[state])
            run.append(edge)
            state = int(self.sources[edge])
        return run[::-1]


def _fresh(states: Ints, found: Mask) -> Ints:
    """Those of some states that were not found yet, each once, in ascending order."""
    fresh = np.sort(states[~found[states]])  # np.unique would load numpy.ma
    return fresh[np.concatenate(([True], fresh[1:] != fresh[:-1]))[: len(fresh)]]


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
