"""The alternatives graph: stable markings, and an edge for each event (paper, 5.2 and 7.1; Fig. 11).

It needs internal evolution to be *confluent*, one stable end whatever the interleaving, and not *divergent*.
Two ways lead to it and must give the same graph: by reduction of the whole markings graph, as the paper does,
and directly, running to completion along one interleaving. The direct way is sound only with a proof; here
enough orders of internal transitions are explored behind each event to prove that all have one end, in the
kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import replace
from typing import TypeVar

import numpy as np

from mcpn._kernel import Exploration, stable_ends
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.events import Event
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.markings.graph import Ints, Mask, StateGraph
from mcpn.spaces.stable.nearest_nonconfluence import proved
from mcpn.spaces.stable.run_to_completion import (
    MAX_STABLE_STATES,
    PROOF_BY_MARKINGS,
    confluence_error,
    divergence_error,
    judged,
    settled,
)
from mcpn.steps import tell

State = TypeVar("State", bound=Hashable)


@record(frozen=True, eq=False, repr=False)
class AlternativesGraph(StateGraph):
    """Stable markings and the event transitions between them, in breadth-first order.

    Args:
        method: ``reduction`` or ``direct``.
        proof: How confluence and termination were established, in words; ``None`` where they were not.
    """

    method: str
    proof: str | None

    def event(self, edge: int) -> Event:
        """The event of an edge."""
        event = self.net.transitions[int(self.labels[edge])].event
        assert event is not None, "only event transitions label the alternatives graph"
        return event

    def events(self, run: list[int]) -> list[Event]:
        """The events of a run given as edges."""
        return [self.event(edge) for edge in run]


def by_reduction(graph: StateGraph) -> AlternativesGraph:
    """Reduces a markings graph to its stable markings, as the paper does.

    Args:
        graph: The whole markings graph of a net with priorities.

    Returns:
        The alternatives graph.

    Raises:
        ConfluenceError: A transient marking has two stable ends; the two runs are given.
        DivergenceError: An internal run need not end; a run into the cycle is given.

    See Also:
        :func:`direct`: the same graph without the markings between stable ones.
        :func:`mcpn.spaces.stable.confluence_by_sets.prove_confluent`: the proof without a list.
    """
    ends = _stable_ends(graph)
    is_event = np.array([not t.internal for t in graph.net.transitions], np.bool_)

    def edges(state: int) -> Iterator[tuple[int, int]]:
        return ((t, int(ends[after])) for t, after in graph.successors(state) if is_event[t])

    proof = "every transient marking of the markings graph has one stable end"
    states, arrays = numbered(int(ends[0]), edges)
    return AlternativesGraph(graph.net, graph.markings[states], *arrays, "reduction", proof)


def _stable_ends(graph: StateGraph) -> Ints:
    """The one stable end of each state."""
    internal = np.array([t.internal for t in graph.net.transitions], np.bool_)[graph.labels]
    transient = np.zeros(graph.states, np.bool_)
    transient[graph.sources[internal]] = True
    # Priorities leave a transient state internal edges only, so each of its edges counts.
    ends, clash = stable_ends(graph.offsets, graph.targets.astype(np.int64), transient)
    if clash >= 0:
        raise _two_ends(graph, clash, ends)
    endless = np.flatnonzero(ends < 0)
    if len(endless):
        raise _endless(graph, int(endless[0]), ends < 0)
    return ends


def _two_ends(graph: StateGraph, state: int, ends: Ints) -> ConfluenceError:
    prefix = graph.run_to(np.arange(graph.states) == state) or []
    runs, seen = [], set[int]()
    for edge in range(int(graph.offsets[state]), int(graph.offsets[state + 1])):
        after = int(graph.targets[edge])
        end = int(ends[after])
        if end >= 0 and end not in seen:
            seen.add(end)
            tail = graph.run_to(np.arange(graph.states) == end, after) or []
            runs.append([_name(graph, e) for e in (*prefix, edge, *tail)])
    return confluence_error(graph.net, runs[:2])


def _endless(graph: StateGraph, state: int, endless: Mask) -> DivergenceError:
    prefix = graph.run_to(np.arange(graph.states) == state) or []
    along = endless[graph.targets] & endless[graph.sources]
    walked, at, run = {state: 0}, state, list(prefix)
    while True:
        # Every open state has an open successor: following them must come back somewhere.
        edge = next(e for e in range(int(graph.offsets[at]), int(graph.offsets[at + 1])) if along[e])
        run.append(edge)
        at = int(graph.targets[edge])
        if at in walked:
            return divergence_error([_name(graph, e) for e in run])
        walked[at] = len(run)


def _name(graph: StateGraph, edge: int) -> str:
    return graph.net.transitions[int(graph.labels[edge])].name


def direct(
    net: PetriNet,
    *,
    proof: bool = True,
    max_states: int = MAX_STABLE_STATES,
    max_firings: int | None = None,
) -> AlternativesGraph:
    """Builds the alternatives graph without the markings graph.

    Args:
        net: A net with priorities.
        proof: Whether to explore enough orders of internal transitions behind each event to prove that
            internal evolution is confluent and ends. Without it the graph rests on that premise.
        max_states: How many stable states it may have; the proof may keep a hundred times as many markings
            between them, and 100,000 at least.
        max_firings: How many firings the proof may take; by default any number.

    Returns:
        The alternatives graph, numbered as :func:`by_reduction` numbers it.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings (only with the proof).
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place.
        LimitError: More stable states, or more markings to explore, than allowed, or too little memory.

    See Also:
        :func:`by_reduction`: the same graph from all markings, as the paper makes it.
        :func:`direct_with_proof`: with the proof that no other order of firing ends elsewhere.
    """
    prepared = KernelNet(net)
    if proof:
        return of_listing(prepared, judged(prepared, max_states, max_firings))
    exploration = settled(prepared, orders="one", max_states=max_states)
    if exploration.trouble is None:
        return AlternativesGraph(net, *prepared.arrays(exploration), "direct", None)
    # Unsafe, endless, or a very long run: exploring the other interleavings decides which.
    return replace(direct(net, max_states=max_states), proof=None)


def direct_with_proof(
    net: PetriNet, *, max_states: int = MAX_STABLE_STATES, max_firings: int | None = None
) -> AlternativesGraph:
    """Builds the alternatives graph directly, with the proof; where it fails, looks for the nearest fault.

    Args:
        net: A net with priorities.
        max_states: As of :func:`direct`.
        max_firings: As there.

    Returns:
        The graph, which says the proof used.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings.
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place. Of several faults any may be reported.
        LimitError: More stable states, or more markings to explore, than allowed, or too little memory.
    """
    prepared = KernelNet(net)
    return of_listing(prepared, proved(prepared, max_states, max_firings))


def of_listing(prepared: KernelNet, exploration: Exploration) -> AlternativesGraph:
    """The alternatives graph of a net whose stable markings have been listed, and proved."""
    return AlternativesGraph(prepared.net, *prepared.arrays(exploration), "direct", PROOF_BY_MARKINGS)


def numbered(
    start: State,
    edges: Callable[[State], Iterable[tuple[int, State]]],
    max_states: int | None = None,
) -> tuple[list[State], tuple[Ints, Ints, Ints]]:
    """States in breadth-first order, and edges in compressed sparse rows: offsets, targets, labels.

    Raises:
        LimitError: There are more states than allowed.
    """
    numbers, queue = {start: 0}, [start]
    offsets, targets, labels = [0], list[int](), list[int]()
    for number, state in enumerate(queue):  # grows while it is walked
        for label, target in edges(state):
            if numbers.setdefault(target, len(queue)) == len(queue):
                queue.append(target)
            targets.append(numbers[target])
            labels.append(label)
        offsets.append(len(targets))
        if max_states is not None and len(queue) > max_states:
            raise LimitError(f"more than {max_states} stable states: the limit on states was hit")
        if number % 1000 == 999:
            tell(len(queue), len(targets))
    rows, ends, events = (np.array(values, np.int64) for values in (offsets, targets, labels))
    return queue, (rows, ends, events)
