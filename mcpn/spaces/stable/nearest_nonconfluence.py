"""The nearest event without one outcome: what a designer is shown of a mission that is not confluent.

Stable markings are visited by as few events as can be, failures and repairs counting twice; behind each event
enough interleavings are explored to judge all. What is found so is a fact with two runs that show it. That
nothing is found proves nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from heapq import heappop, heappush

from mcpn._kernel import Exploration
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError, UnsafeError
from mcpn.events import What
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.markings.masked import MaskedNet, mask_of, unsafe_after
from mcpn.spaces.stable.run_to_completion import LEAST_TRANSIENT, Walk, judged, settled

FIRINGS = 50_000
"""Firings, and markings behind events, after which the search gives up; about a second."""

FIRST_FIRINGS = 3_000
"""The same for a first look, before anything is proved: it costs little where there is nothing to find."""

PREPARING = 40
"""Firings that are as much work as the kernel's preparation for one exploration behind an event."""

MOST_NEAR = 100
"""Stable ends behind one event that are looked for, with ``completion.LEAST_TRANSIENT`` markings."""

FAULTS = {What.OUT_OF_SERVICE, What.REPAIRED, What.LOST}


def nearest_fault(net: PetriNet, firings: int = FIRINGS) -> SemanticsError | None:
    """The error of an event after which internal evolution has two ends, or none, near the initial marking.

    Args:
        net: A net with priorities. Where a run that is found passes an unsafe firing, that is the error.
        firings: How many firings may be looked at.

    Returns:
        The error with whole runs; ``None`` where the search has found nothing, which proves nothing.
    """
    error = _Search(net, firings).nearest()
    for run in () if error is None else error.runs:
        if (unsafe := _unsafe_in(net, [net.transition_index[name] for name in run])) is not None:
            return unsafe
    return error


def proved(prepared: KernelNet, max_states: int, max_firings: int | None = None) -> Exploration:
    """Runs events to completion, and proves that each has one end; else the nearest fault is told.

    Args:
        prepared: A net with priorities.
        max_states: How many stable markings there may be.
        max_firings: How many firings the proof may take; by default any number.

    Returns:
        Stable markings and events.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings.
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place. Of several faults any may be reported.
        LimitError: More stable states, or more markings to explore, than allowed, or too little memory.
    """
    try:
        return judged(prepared, max_states, max_firings)
    except (ConfluenceError, DivergenceError) as error:
        raise nearest_fault(prepared.net) or error from error


def _unsafe_in(net: PetriNet, run: Sequence[int]) -> UnsafeError | None:
    """The error of the first firing of a run that puts a second token in a place."""
    marking = net.initial
    for number, t in enumerate(run, 1):
        marking = net.fire(marking, t)
        if max(marking) > 1:
            return unsafe_after(net, run[:number])
    return None


def fault_by(net: PetriNet, events: Iterable[int]) -> SemanticsError | None:
    """The error of the last of some events, where one run behind it shows that it has two ends, or none.

    Args:
        net: A 1-safe net with priorities.
        events: The transitions of the events from the initial marking on.

    Returns:
        The error with whole runs; ``None`` where nothing was found, which proves nothing.
    """
    search = _Search(net, FIRINGS)
    marking = search.masked.initial()
    error = search.settle(marking, [])
    for t in events:
        if error is not None:
            return error
        error = search.settle(search.masked.fire(search.end, t)[0], [*search.prefix, t])
    return error


class _Search:
    def __init__(self, net: PetriNet, firings: int) -> None:
        self.net = net
        self.masked, self.internal = MaskedNet(net), KernelNet(net, events=False)
        self.firings = firings
        """How many more may be looked at."""
        self.end = 0
        self.prefix: list[int] = []

    def settle(self, marking: int, prefix: list[int]) -> SemanticsError | None:
        """Runs to completion: sets :attr:`end` and :attr:`prefix`, or returns the error that is come upon."""
        self.firings -= PREPARING
        walk = Walk(self.net)
        walk.marking[:] = [marking >> p & 1 for p in range(len(self.net.places))]
        walk.run[:] = prefix
        try:
            exploration = settled(self.internal, walk.marking, orders="enough", max_states=MOST_NEAR)
        except LimitError:  # too much behind this event to be near
            self.firings -= LEAST_TRANSIENT
        else:
            self.firings -= exploration.transient
            if exploration.trouble is not None:
                return walk.fault(self.internal, exploration)
        walk.settle()
        self.firings -= len(walk.run) - len(prefix)
        self.prefix, self.end = walk.run, mask_of(walk.marking)
        return None

    def nearest(self) -> SemanticsError | None:
        error = self.settle(self.masked.initial(), [])
        if error is not None:
            return error
        queue: list[tuple[int, int]] = []
        visited: list[tuple[int, list[int]]] = [(self.end, self.prefix)]
        known = {self.end}
        heappush(queue, (0, 0))
        while queue and self.firings > 0:
            cost, number = heappop(queue)
            marking, prefix = visited[number]
            for t in self._events(marking):
                error = self.settle(self.masked.fire(marking, t)[0], [*prefix, t])
                if error is not None:
                    return error
                if self.end not in known:
                    known.add(self.end)
                    event = self.net.transitions[t].event
                    of_fault = event is not None and event.what in FAULTS
                    heappush(queue, (cost + 1 + of_fault, len(visited)))
                    visited.append((self.end, self.prefix))
        return None

    def _events(self, marking: int) -> Iterator[int]:
        return self.masked.allowed(self.masked.covered(marking))
