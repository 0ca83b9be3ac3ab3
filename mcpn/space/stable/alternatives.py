"""The alternatives graph: stable markings, and an edge for each event (paper, 5.2 and 7.1; Fig. 11).

It needs internal evolution to be *confluent*, one stable end whatever the interleaving, and not *divergent*.
Two ways lead to it and must give the same graph: by reduction of the whole markings graph, as the paper does,
and directly, running to completion along one interleaving. The direct way is sound only with a proof; here
every transient marking behind an event is explored once, and its one stable end is remembered.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from mcpn._kernel import MemoryLimit, StateLimit, stable_ends
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.net.events import Event
from mcpn.net.petri import PetriNet
from mcpn.space.markings.explicit import DEFAULT_MAX_MEMORY, KernelNet
from mcpn.space.markings.firing import MaskedNet
from mcpn.space.markings.graph import Ints, Mask, StateGraph, pack
from mcpn.space.stable.parting import parting_runs

State = TypeVar("State", bound=Hashable)

DEFAULT_MAX_STATES = 5_000_000
DEFAULT_MAX_TRANSIENT = 20_000_000
"""Transient markings that are explored one by one; each takes some 300 bytes."""


@dataclass(frozen=True, eq=False, repr=False)
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


def confluence_error(net: PetriNet, runs: list[list[str]]) -> ConfluenceError:
    """The error for two runs that differ in their stable end, told by where they part."""
    first, second = runs
    parted = next(i for i, (a, b) in enumerate(zip(first, second, strict=False)) if a != b)
    of = {transition.name: transition for transition in net.transitions}
    origins = [of[run[parted]].provenance for run in runs]
    where = " and ".join(dict.fromkeys(str(o) for o in origins if o))
    events = [str(e) for name in first[:parted] if (e := of[name].event)]
    after = f"after {events[-1]}" if events else "at the start"
    return ConfluenceError(
        f"not confluent: {after} the outcome depends on the interleaving of "
        f"{where or f'{first[parted]} and {second[parted]}'}",
        runs,
        events,
    )


def divergence_error(run: list[str]) -> DivergenceError:
    """The error for an internal run that comes back to a marking it has passed."""
    return DivergenceError(
        f"divergent: an internal run comes back to a marking it has passed, after {len(run)} firings", [run]
    )


class _Proving:
    """Runs events to completion along every interleaving, and proves that they end alike."""

    def __init__(self, net: PetriNet, max_transient: int = DEFAULT_MAX_TRANSIENT) -> None:
        self.net = net
        self.max_transient = max_transient
        self.masked = MaskedNet(net)
        self.ends: dict[int, int] = {}
        self.parents: dict[int, tuple[int, int] | None] = {}

    def stabilise(self, marking: int, covered: int, origin: tuple[int, int] | None) -> int:
        self.parents.setdefault(marking, origin)
        return self.every_end(marking, covered)

    def step(self, marking: int, transition: int) -> int:
        after, doubled = self.masked.fire(marking, transition)
        if doubled:
            place = self.net.places[(doubled & -doubled).bit_length() - 1].name
            name = self.net.transitions[transition].name
            raise UnsafeError(place, name, self.masked.marked(marking), self.run(marking))
        return after

    def every_end(self, start: int, covered: int) -> int:
        """Explores every transient marking behind one, each once, and proves that their ends agree."""
        masked, ends = self.masked, self.ends
        if start in ends:
            return ends[start]
        if not covered & masked.internal:
            ends[start] = start
            return start
        path, on_path = [(start, covered, masked.allowed(covered & masked.internal))], {start}
        while path:  # depth first
            marking, covered, left = path[-1]
            t = next(left, None)
            if t is None:
                path.pop()
                on_path.discard(marking)
                if path:
                    self.agree(path[-1][0], marking)
                continue
            after = self.step(marking, t)
            self.parents.setdefault(after, (marking, t))
            if len(self.parents) > self.max_transient:
                raise LimitError(
                    f"more than {self.max_transient} markings behind events were explored one by one: "
                    "the limit on transient markings was hit"
                )
            if after in on_path:
                raise divergence_error([*self.run(marking), self.net.transitions[t].name])
            if after not in ends:
                next_covered = masked.covered_after(covered, after, t)
                if next_covered & masked.internal:
                    on_path.add(after)
                    path.append((after, next_covered, masked.allowed(next_covered & masked.internal)))
                    continue
                ends[after] = after
            self.agree(marking, after)
        return ends[start]

    def agree(self, marking: int, after: int) -> None:
        end = self.ends[after]
        if self.ends.setdefault(marking, end) != end:
            raise self.two_ends(marking)

    def two_ends(self, marking: int) -> ConfluenceError:
        """Shows two runs that part at two transitions each of which decides the end."""
        while (origin := self.parents[marking]) is not None and self.net.transitions[origin[1]].internal:
            marking = origin[0]
        after: dict[int, dict[int, int]] = {}
        queue = [marking]
        for at in queue:
            if at not in after:
                covered = self.masked.covered(at) & self.masked.internal
                after[at] = {t: self.step(at, t) for t in self.masked.allowed(covered)}
                queue.extend(after[at].values())
        names = ([self.net.transitions[t].name for t in run] for run in parting_runs(after, marking))
        return confluence_error(self.net, [[*self.run(marking), *tail] for tail in names])

    def run(self, marking: int) -> list[str]:
        run = []
        while (origin := self.parents[marking]) is not None:
            marking, t = origin
            run.append(self.net.transitions[t].name)
        return run[::-1]


def fault_after(net: PetriNet, events: Iterable[Event]) -> SemanticsError | None:
    """The error of a run of events whose last has not one stable end, every interleaving after each explored.

    Args:
        net: A net with priorities.
        events: The run from the initial marking; in each marking one transition carries the next event.

    Returns:
        The error with whole runs from the initial marking, ``None`` where each event has one stable end.
    """
    walk = _Proving(net)
    masked = walk.masked
    at = masked.initial()
    covered = masked.covered(at)
    try:
        at = walk.stabilise(at, covered, None)
        for event in events:
            covered = masked.covered(at)
            (t,) = [t for t in masked.allowed(covered) if net.transitions[t].event == event]
            after = walk.step(at, t)
            at = walk.stabilise(after, masked.covered_after(covered, after, t), (at, t))
    except SemanticsError as error:
        return error
    return None


def direct(
    net: PetriNet,
    *,
    proof: bool = True,
    max_states: int = DEFAULT_MAX_STATES,
    progress: Callable[[int, int], None] | None = None,
) -> AlternativesGraph:
    """Builds the alternatives graph without the markings graph.

    Args:
        net: A net with priorities.
        proof: Whether to explore every transient marking behind each event, which proves that internal
            evolution is confluent and ends. Without it the graph rests on that premise.
        max_states: How many stable states it may have; the proof may explore a hundred times as many markings
            between them (100,000 at least, 20 million at most).
        progress: Called for each thousand stable states with their number and that of the edges.

    Returns:
        The alternatives graph, numbered as :func:`by_reduction` numbers it.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings (only with the proof).
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place.
        LimitError: More stable states, or more markings to explore, than allowed.
    """
    if not proof:
        return _settled(net, max_states, progress)
    walk = _Proving(net, min(max(100 * max_states, 100_000), DEFAULT_MAX_TRANSIENT))
    masked = walk.masked
    begin = masked.initial()

    def edges(marking: int) -> Iterator[tuple[int, int]]:
        covered = masked.covered(marking)
        for t in masked.allowed(covered):
            after = walk.step(marking, t)
            yield t, walk.stabilise(after, masked.covered_after(covered, after, t), (marking, t))

    start = walk.stabilise(begin, masked.covered(begin), None)
    states, arrays = numbered(start, edges, max_states, progress)
    words = pack(states, len(net.places))
    how = "every transient marking behind each event explored once, its stable end unique"
    return AlternativesGraph(net, words, *arrays, "direct", how)


def _settled(
    net: PetriNet, max_states: int, progress: Callable[[int, int], None] | None
) -> AlternativesGraph:
    """The graph by one interleaving of each run, in the kernel; the walk here finds the run of an error."""
    prepared = KernelNet(net)
    try:
        found = prepared.kernel.settle(prepared.initial, max_states, DEFAULT_MAX_MEMORY, progress)
    except (StateLimit, MemoryLimit) as error:
        raise LimitError(str(error).replace("states", "stable states", 1)) from error
    if found.trouble is not None:
        # Unsafe, endless, or a very long run: the walk through every interleaving tells which.
        return replace(direct(net, max_states=max_states, progress=progress), proof=None)
    return AlternativesGraph(net, *prepared.arrays(found), "direct", None)


def numbered(
    start: State,
    edges: Callable[[State], Iterable[tuple[int, State]]],
    max_states: int | None = None,
    progress: Callable[[int, int], None] | None = None,
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
        if progress and number % 1000 == 999:
            progress(len(queue), len(targets))
    rows, ends, events = (np.array(values, np.int64) for values in (offsets, targets, labels))
    return queue, (rows, ends, events)
