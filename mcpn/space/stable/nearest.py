"""The nearest event without one outcome: what a designer is shown of a mission that is not confluent.

Stable markings are visited by as few events as can be, failures and repairs counting twice; behind each event
some interleavings are followed, those in which rivals come to want the same, and conflicts are tried both
ways. What is found so is a fact with two runs that show it. That nothing is found proves nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from heapq import heappop, heappush

from mcpn.errors import SemanticsError
from mcpn.net.events import What
from mcpn.net.petri import PetriNet
from mcpn.space.stable.joining import EndlessRun, Joining, Parting
from mcpn.space.stable.settling import confluence_error, divergence_error

FIRINGS = 50_000
"""Firings after which the search gives up; about a second."""

WAYS = 30
"""Markings behind one event from which every order is tried."""

HARDWARE = {What.OUT_OF_SERVICE, What.REPAIRED, What.LOST}


def nearest_fault(net: PetriNet, firings: int = FIRINGS) -> SemanticsError | None:
    """The error of an event after which internal evolution has two ends, or none, near the initial marking.

    Args:
        net: A 1-safe net with priorities.
        firings: How many firings may be looked at.

    Returns:
        The error with whole runs; ``None`` where the search has found nothing, which proves nothing.
    """
    return _Search(net, firings).nearest()


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
        self.joining = Joining(net)
        self.masked = self.joining.masked
        self.firings = firings
        self.end = 0
        self.prefix: list[int] = []

    def settle(self, marking: int, prefix: list[int]) -> SemanticsError | None:
        """Follows a run to its end, which :attr:`end` and :attr:`prefix` then say, or to an error."""
        try:
            run, self.end, found = self.joining.parting_behind(marking, WAYS)
        except EndlessRun as endless:
            return divergence_error(self.names([*prefix, *endless.run]))
        self.prefix = [*prefix, *run]
        return None if found is None else self.parted(self.prefix, found)

    def parted(self, prefix: list[int], found: Parting) -> SemanticsError:
        return confluence_error(
            self.net, [self.names([*prefix, *run]) for run in (found.first, found.second)]
        )

    def names(self, run: Iterable[int]) -> list[str]:
        return [self.net.transitions[t].name for t in run]

    def nearest(self) -> SemanticsError | None:
        error = self.settle(self.masked.initial(), [])
        if error is not None:
            return error
        queue: list[tuple[int, int]] = []
        visited: list[tuple[int, list[int]]] = [(self.end, self.prefix)]
        known = {self.end}
        heappush(queue, (0, 0))
        while queue and self.joining.firings < self.firings:
            cost, number = heappop(queue)
            marking, prefix = visited[number]
            for t in self._events(marking):
                error = self.settle(self.masked.fire(marking, t)[0], [*prefix, t])
                if error is not None:
                    return error
                if self.end not in known:
                    known.add(self.end)
                    event = self.net.transitions[t].event
                    of_hardware = event is not None and event.what in HARDWARE
                    heappush(queue, (cost + 1 + of_hardware, len(visited)))
                    visited.append((self.end, self.prefix))
        return None

    def _events(self, marking: int) -> Iterator[int]:
        return self.masked.allowed(self.masked.covered(marking))
