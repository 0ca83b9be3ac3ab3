"""The reachable markings of a net as a diagram, or as a list that becomes one, and their sizes."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from mcpn._kernel import MemoryLimit, Zdd
from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.internal_evolution import leading, passing
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.markings.explicit import Counts

if TYPE_CHECKING:
    from mcpn.spaces.markings.graph import StateGraph


class ListedMarkings:
    """Markings that were listed one by one: rows of bits, put on a diagram when it is asked for.

    Args:
        rows: As :meth:`mcpn._kernel.Exploration.take_markings` gives them.
        graph: Their graph, where it is wanted and fits.
    """

    def __init__(self, rows: Any, graph: StateGraph | None = None) -> None:
        self._rows = rows
        self.graph = graph

    def put_on(self, encoding: Encoding) -> Zdd:
        """The diagram of these markings; the rows are given up where it fits."""
        diagram = encoding.store.from_markings(self._rows, encoding.places)
        self._rows = None
        return diagram


@record(frozen=True)
class SymbolicSpace:
    """The reachable markings of a net.

    Args:
        encoding: The net on the levels of the store.
        reached: The reachable markings, as a diagram or as a list that becomes one when it is asked for.
        stable: Those that enable no internal transition, where the net has priorities.
        order: The order's name.
        places: The order itself.
        peak_nodes: Most nodes at once while they were reached.
        explored: The sizes, where the markings were explored one by one.
    """

    encoding: Encoding
    reached: Zdd | ListedMarkings
    stable: Zdd | None
    order: str
    places: Order
    peak_nodes: int
    explored: Counts | None = None

    @property
    def listed(self) -> StateGraph | None:
        """The graph of the markings, where they were listed with their firings."""
        return self.reached.graph if isinstance(self.reached, ListedMarkings) else None

    def __reduce__(self) -> tuple[Any, ...]:
        """A space goes from process to process as tables of its diagrams."""
        stable = None if self.stable is None else self.stable.to_bytes()
        described = (
            *(self.order, self.places, self.peak_nodes, self.explored),
            *(self.encoding.memory_limit, self.encoding.counters),
        )
        return _revived, (self.encoding.net, self.reachable.to_bytes(), stable, *described)

    @cached_property
    def reachable(self) -> Zdd:
        """The reachable markings.

        Raises:
            LimitError: They were listed, and their diagram does not fit into memory.
        """
        if isinstance(self.reached, Zdd):
            return self.reached
        try:
            return self.reached.put_on(self.encoding)
        except MemoryLimit as error:
            raise LimitError(str(error)) from error

    @property
    def nodes(self) -> int | None:
        """Nodes of the diagram, where there is one."""
        drawn = isinstance(self.reached, Zdd) or "reachable" in vars(self)
        return self.reachable.nodes() if drawn else None

    @cached_property
    def states(self) -> int:
        """Number of reachable markings."""
        return self.reachable.count() if self.explored is None else self.explored.states

    @property
    def edges(self) -> int:
        """Number of firings, priorities respected."""
        if self.explored is not None:
            return self.explored.edges
        counts = (
            where.counts([c for t in group if (c := self.encoding.enabling[t]) is not None])
            for group, where in self.groups
        )
        return sum(map(sum, counts))

    @cached_property
    def free(self) -> list[int]:
        """Transitions that fire wherever they have their tokens."""
        net, events = self.encoding.net, self.encoding.events
        if not net.priorities:
            return list(events)
        first = set(net.internal_ranks[0] if net.internal_ranks else ())
        return [t for t in events if t in first]

    @cached_property
    def waiting(self) -> list[int]:
        """Transitions that priorities let fire in stable markings only."""
        early = {*self.free, *(t for t, made in enumerate(self.encoding.net.transitions) if made.internal)}
        return [t for t in self.encoding.events if t not in early]

    @cached_property
    def groups(self) -> list[tuple[list[int], Zdd]]:
        """Transitions, each group with the markings in which priorities let it fire."""
        net, later = self.encoding.net, list[tuple[list[int], Zdd]]()
        if net.priorities and len(net.internal_ranks) > 1:
            both = zip(net.internal_ranks[1:], self.allowed[1:], strict=True)
            later = [([t for t in ranked if t in self.encoding.events], where) for ranked, where in both]
        stable = self.reachable if self.stable is None else self.stable
        return [(self.free, self.reachable), *later, (self.waiting, stable)]

    @cached_property
    def dead(self) -> Zdd:
        """Markings that enable no transition."""
        return self.reachable.without([c for c in self.encoding.enabling.values() if c is not None])

    @cached_property
    def endless(self) -> Zdd:
        """Markings from which no internal run reaches a stable one, of a net with priorities."""
        assert self.stable is not None, "asked of nets with priorities"
        return self.reachable - leading(self.encoding, self.stable, self.allowed)

    @cached_property
    def allowed(self) -> list[Zdd]:
        """By rank, the markings in which internal transitions may fire, of a net with priorities."""
        return passing(self.encoding, self.reachable)

    @property
    def dead_states(self) -> int:
        """Number of markings that enable no transition."""
        return self.dead.count() if self.explored is None else self.explored.dead

    @cached_property
    def max_tokens(self) -> int:
        """Most tokens in a marking."""
        if self.explored is not None:
            return self.explored.max_tokens
        weights, always = self.encoding.weigh(dict.fromkeys(range(len(self.encoding.net.places)), 1))
        return self.reachable.largest(weights) + always

    @cached_property
    def max_tokens_in_place(self) -> int:
        """Most tokens in a place."""
        if self.encoding.counters is None:  # 1-safe
            return min(self.max_tokens, 1)
        return max(self.encoding.most(self.reachable), default=0)


def _revived(
    net: PetriNet,
    reachable: bytes,
    stable: bytes | None,
    order: str,
    places: Order,
    peak: int,
    explored: Counts | None,
    memory: int,
    counters: tuple[tuple[int, ...], bool] | None,
) -> SymbolicSpace:
    if counters is None:
        encoding = Encoding(net, places, memory)
    else:
        from mcpn.spaces.diagrams.counters import TokenEncoding

        encoding = TokenEncoding(net, places, memory, *counters)
    sets = [None if table is None else encoding.store.from_bytes(table) for table in (reachable, stable)]
    assert sets[0] is not None, "what is reachable is always there"
    return SymbolicSpace(encoding, sets[0], sets[1], order, places, peak, explored)
