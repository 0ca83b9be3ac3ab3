"""What races for the markings of a net: orders of places, and exploration of one marking after the other.

Each says after how many more doublings of its work it may end. A closure has progress to show: the levels
that it has closed from below. An exploration has its queue: where fewer new markings come than are explored,
the queue runs dry. And it ends at the latest when its memory is full.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import islice
from math import inf, log2
from typing import TYPE_CHECKING

from mcpn._kernel import BudgetExceeded, Cancelled
from mcpn.errors import UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.records import record
from mcpn.spaces.diagrams.closing import Encode, close
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.order import Order, candidates
from mcpn.spaces.diagrams.reached_markings import ListedMarkings, SymbolicSpace
from mcpn.spaces.markings.explicit import Counts, KernelNet

if TYPE_CHECKING:
    from mcpn._kernel import Explorer

EXPLORER_RANK = 2
FIRINGS_OF_A_STEP = 8
"""About how many firings of an exploration take the time of one step of a closure."""

LEAST_STEPS = 50_000
"""Exploration waits until it is given so many: most nets have an order that ends before."""

WITHIN_REACH = 6.0
"""Doublings until memory is full from which on an exploration counts as one that ends, one way or another."""

FARTHEST = 7.0
"""Doublings beyond which the progress of a closure says nothing."""

FIRST_LOOK = 1_000_000
"""Steps of a closure before which its progress says nothing."""

LEAST_PROGRESS = 1 / 50
"""What share of all levels a doubling must close for the progress of a closure to say something."""


def runners(
    net: PetriNet, encodes: Sequence[Encode], seed: int | None, memory_limit: int, edges: bool
) -> Iterator[ByOrder | OneByOne]:
    """Orders of places, the most often good first, and exploration one by one among them.

    Args:
        net: The net.
        encodes: Ways to put it on levels; the first is for all orders, the others for the first order alone.
        seed: Draws one more order.
        memory_limit: Bytes that each may take.
        edges: Whether exploration keeps firings, if they fit.
    """
    orders = candidates(net, seed)
    encode, *others = encodes
    leading = [
        ByOrder(net, encode, name, order, memory_limit) for name, order in islice(orders, EXPLORER_RANK)
    ]
    yield leading[0]
    for other in others:
        yield ByOrder(net, other, leading[0].name, leading[0].order, memory_limit)
    yield from leading[1:]
    if encode is Encoding:  # markings of 1-safe nets
        yield OneByOne(net, leading[0].name, leading[0].order, memory_limit, LEAST_STEPS, edges)
    for name, order in orders:
        yield ByOrder(net, encode, name, order, memory_limit)


@record()
class ByOrder:
    """The closure on a diagram of one order, for the race."""

    net: PetriNet
    encode: Encode
    name: str
    order: Order
    memory_limit: int
    outlook: float = inf
    _encoding: Encoding | None = None
    _cancelled: bool = False
    _spent: int = 0
    """Steps of all rounds."""
    _seen_at: int = 0
    """Steps spent when progress was last looked at."""
    _left: int = 0
    """Levels that were not closed then."""

    @property
    def bytes(self) -> int:
        """What the store holds."""
        return 0 if self._encoding is None else self._encoding.store.bytes

    def run(self, steps: int) -> SymbolicSpace:
        """Closes the initial marking under all firings, in so many steps at most."""
        if self._encoding is None:
            self._encoding = self.encode(self.net, self.order, self.memory_limit)
        if self._cancelled:
            raise Cancelled
        try:
            return close(self._encoding, self.name, self.order, steps)
        except BudgetExceeded:
            if not self.net.priorities:  # there, each of many closures begins anew
                self._look_out(steps, len(self._encoding.places), self._encoding.store.closed)
            raise

    def _look_out(self, steps: int, levels: int, left: int) -> None:
        self._spent += steps
        if self._spent < max(FIRST_LOOK, 2 * self._seen_at):
            return
        self.outlook = inf
        if self._seen_at:
            closed = (self._left - left) / log2(self._spent / self._seen_at)
            if closed >= levels * LEAST_PROGRESS and left <= FARTHEST * closed:
                self.outlook = 1 + left / closed  # the last level may be as much work as all below
        self._seen_at, self._left = self._spent, left

    def forget(self) -> None:
        """Frees the store."""
        self._encoding = None
        self._spent, self._seen_at, self.outlook = 0, 0, inf

    def cancel(self) -> None:
        """Ends the closure under way."""
        self._cancelled = True
        if self._encoding is not None:
            self._encoding.store.cancel()


@record()
class OneByOne:
    """Exploration of one marking after the other, whose end is put on a diagram, for the race."""

    net: PetriNet
    name: str
    order: Order
    memory_limit: int
    least_steps: int = 1
    edges: bool = False
    outlook: float = inf
    _explorer: Explorer | None = None
    _encoding: Encoding | None = None
    _cancelled: bool = False

    @cached_property
    def _prepared(self) -> KernelNet:
        return KernelNet(self.net)

    @property
    def bytes(self) -> int:
        """What the explorer holds."""
        return 0 if self._explorer is None else self._explorer.bytes

    def run(self, steps: int) -> SymbolicSpace | UnsafeError:
        """Explores as long as so many steps of a closure take."""
        prepared = self._prepared
        if self._explorer is None:
            if steps < self.least_steps:
                raise BudgetExceeded(f"{steps} steps are too few to begin")
            self._explorer = prepared.kernel.explorer(prepared.initial, self.memory_limit, self.edges)
        if self._cancelled:
            raise Cancelled
        explorer = self._explorer
        firings = max(steps * FIRINGS_OF_A_STEP, 2)
        ended = explorer.run(firings - firings // 4)
        explored, states = explorer.explored, explorer.states
        if not ended and not explorer.run(firings // 4 or 1):
            self._look_out(explorer.explored - explored, explorer.states - states)
            raise BudgetExceeded(f"the budget of {steps} steps was exceeded")
        exploration = explorer.take()
        self._explorer = None
        if exploration.trouble is not None:
            return prepared.unsafe(exploration)
        encoding = self._encoding = Encoding(self.net, self.order, self.memory_limit)
        if self._cancelled:
            raise Cancelled
        name = f"{self.name}, after exploring one by one"
        sizes = Counts(
            exploration.states,
            exploration.edges,
            exploration.dead,
            exploration.stable,
            exploration.most_tokens,
        )
        graph = prepared.graph(exploration)
        listed = ListedMarkings(graph.markings, graph if len(graph.offsets) else None)
        if not self.net.priorities:
            return SymbolicSpace(encoding, listed, None, name, self.order, 0, sizes)
        reachable = listed.put_on(encoding)
        stable = reachable.without(encoding.unstable)
        return SymbolicSpace(encoding, reachable, stable, name, self.order, encoding.store.peak_nodes, sizes)

    def _look_out(self, explored: int, fresh: int) -> None:
        assert self._explorer is not None, "asked of an exploration under way"
        so_far, states = self._explorer.explored, self._explorer.states
        most = self.memory_limit * states // self._explorer.bytes
        queued = states - so_far
        if fresh < explored and so_far + (still := queued * explored // (explored - fresh)) <= most:
            self.outlook = log2(1 + still / so_far)
        else:
            full = log2(max(most / so_far, 1))
            self.outlook = full / 2 if full <= WITHIN_REACH else inf  # it may end at any time before

    def forget(self) -> None:
        """Frees what was explored."""
        self._explorer = None
        self.outlook = inf

    def cancel(self) -> None:
        """Ends the exploration under way."""
        self._cancelled = True
        if self._explorer is not None:
            self._explorer.cancel()
        if self._encoding is not None:
            self._encoding.store.cancel()
