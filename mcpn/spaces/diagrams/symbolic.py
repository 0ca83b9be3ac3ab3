"""The markings of a 1-safe net as a decision diagram, reached by saturation in the native kernel.

Source: Ciardo, Lüttgen, Siminiscalchi, *Saturation* (TACAS 2001), on zero-suppressed diagrams (Minato, DAC
1993): a marking is the set of its marked places. Priorities are respected as the paper's section 7.1 asks:
markings are closed under internal transitions, events are fired from the stable ones, and so on until nothing
is new.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, Any, TypeAlias

from mcpn._kernel import MemoryLimit, Zdd
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import PetriNet, Provenance
from mcpn.spaces.diagrams.encoding import Clock, Encoding, behind, distinct, leading, passing
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.diagrams.race import FIRST_BUDGET, Race, Work, cores, finished
from mcpn.spaces.markings.explicit import Counts, unsafe_at_start

if TYPE_CHECKING:
    from mcpn.spaces.markings.graph import StateGraph

DEFAULT_MEMORY = 4 << 30
FIRST_BUDGET_OF_MISSIONS = 8_000_000
"""About a second; with less, exploration one by one goes on instead, which takes ten times as long."""
MOST_WORKERS = 4
Encode: TypeAlias = Callable[[PetriNet, Order, int], Encoding]
"""Puts a net on the levels of a store, given an order of places and the bytes that the store may take."""


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


@dataclass(frozen=True)
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
        from mcpn.spaces.diagrams.spaces import DiagramMarkings

        return sum(DiagramMarkings(self).firings(self.reachable).values())

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


def reach(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
    edges: bool = False,
) -> SymbolicSpace:
    """Reaches every marking of a 1-safe net.

    Args:
        net: The net.
        order: Places from the top on; by default orders race, and exploration one by one beside
            them: see :mod:`mcpn.spaces.diagrams.race`.
        seed: Draws one more order for the race.
        memory_limit: Bytes that diagrams may take.
        edges: Whether firings are kept, if they fit, where markings are listed.

    Returns:
        The reachable markings.

    Raises:
        UnsafeError: The net is not 1-safe; the run to the unsafe firing is a shortest one.
        LimitError: The memory limit was hit.

    See Also:
        :func:`mcpn.spaces.markings.explicit.explore`: the same markings, listed.
        :func:`reaching`: the same work, which may rest.
        :mod:`mcpn.spaces.diagrams.order`: the orders of places that decide the size of diagrams.
    """
    return finished(reaching(net, order=order, seed=seed, memory_limit=memory_limit, edges=edges))


def reaching(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
    edges: bool = False,
) -> Work[SymbolicSpace]:
    """As :func:`reach`, as work that may rest between the rounds of the race."""
    if error := unsafe_at_start(net):
        raise error
    from mcpn.spaces.diagrams.unsafe import refuse_unsafe

    space = yield from closing(net, Encoding, order=order, seed=seed, memory_limit=memory_limit, edges=edges)
    if space.explored is None:  # exploration looks at each firing
        refuse_unsafe(space)
    return space


def closing(
    net: PetriNet,
    encode: Encode,
    *others: Encode,
    order: Order | None,
    seed: int | None,
    memory_limit: int,
    edges: bool = False,
) -> Work[SymbolicSpace]:
    """The markings that firings lead to as far as an encoding can say them.

    Args:
        net: The net.
        encode: Puts it on levels; a firing that has no event there is left out.
        others: Other ways to do so, which race with the most promising order.
        order: Places from the top on; by default orders race.
        seed: Draws one more order for the race.
        memory_limit: Bytes that diagrams may take.
        edges: Whether firings are kept, if they fit, where markings are listed.

    Raises:
        UnsafeError: Met where the encoding is of 1-safe nets; what it leaves out is not looked for.
        LimitError: The memory limit was hit.
    """
    try:
        if order:
            return close(encode(net, order, memory_limit), "given", order)
        return (yield from _race(net, (encode, *others), memory_limit, seed, edges))
    except MemoryLimit as error:
        raise LimitError(str(error)) from error


def _race(
    net: PetriNet, encodes: Sequence[Encode], memory_limit: int, seed: int | None, edges: bool
) -> Work[SymbolicSpace]:
    # Missions are larger than small nets and have orders that are seldom bad: fewer rounds do.
    first = FIRST_BUDGET_OF_MISSIONS if net.priorities else FIRST_BUDGET
    from mcpn.spaces.diagrams.runners import runners

    limit: MemoryLimit | None = None
    for workers in sorted({min(cores(), MOST_WORKERS), 1}, reverse=True):  # one alone may have all the memory
        race = Race(runners(net, encodes, seed, memory_limit // workers, edges), memory_limit, workers, first)
        winner = yield from race.rounds()
        if isinstance(winner, UnsafeError):
            raise winner
        if winner is not None:
            return winner
        limit = race.limit
    raise LimitError(f"no order of places stays within memory: {limit}")


def close(encoding: Encoding, name: str, order: Order, budget: int = 0) -> SymbolicSpace:
    """Reaches every marking in so many steps, or any number for 0."""
    net, store = encoding.net, encoding.store
    if not net.priorities:
        everything = encoding.initial().saturate(distinct(encoding.events.values()), max_steps=budget)
        return SymbolicSpace(encoding, everything, None, name, order, store.peak_nodes)
    clock, peak = Clock(budget), 0

    def step(settled: Zdd, events: list[int]) -> Zdd:
        nonlocal peak
        fired = settled.images(events)
        clock.spent += store.steps
        ends = behind(encoding, fired, clock)[1]
        peak = max(peak, store.peak_nodes)
        return ends

    # Transient markings stay out of the sets that grow; those behind all events are put together at the end.
    by_element = [distinct(encoding.events[t] for t in own) for own in elements(encoding)]
    begun, first = behind(encoding, encoding.initial(), clock)
    stable = chained(first, [partial(step, events=events) for events in by_element])
    every = stable.images(distinct(chain.from_iterable(by_element)))
    reachable = begun | behind(encoding, every, clock)[0]
    return SymbolicSpace(encoding, reachable, stable, name, order, max(peak, store.peak_nodes))


def elements(encoding: Encoding) -> list[list[int]]:
    """The event transitions of a net with priorities, by the element of the mission that they are of.

    Hardware comes last: sets in which it fails already are larger on the way than those without.
    """
    groups: dict[Provenance | None, list[int]] = {}
    for t in encoding.events:
        transition = encoding.net.transitions[t]
        if not transition.internal:
            groups.setdefault(transition.provenance, []).append(t)
    hardware_last = sorted(groups, key=lambda element: element is not None and element.kind == "hardware")
    return [groups[element] for element in hardware_last]


def chained(begin: Zdd, steps: Sequence[Callable[[Zdd], Zdd]]) -> Zdd:
    """The least fixpoint of a union of steps above a set; each step is closed before the next is taken.

    This is *chaining* (Roig, Cortadella, Pastor, ICATPN 1995). Breadth-first layers, all states so many steps
    away, have large diagrams on the way to a small one; closing under the events of one element at a time
    avoids them.

    Args:
        begin: The set that the fixpoint contains.
        steps: Each maps a set to its image, and distributes over unions.
    """
    reached = begin
    taken = [begin - begin] * len(steps)  # by step, the states that it has been applied to
    changed = True
    while changed:
        changed = False
        for number, step in enumerate(steps):
            while new := reached - taken[number]:
                taken[number] = reached
                after = step(new)
                if (reached | after) == reached:
                    break
                reached |= after
                changed = True
    return reached
