"""The markings of a 1-safe net as a decision diagram, reached by saturation in the native kernel.

Source: Ciardo, Lüttgen, Siminiscalchi, *Saturation* (TACAS 2001), on zero-suppressed diagrams (Minato, DAC
1993): a marking is the set of its marked places. Priorities are respected as the paper's section 7.1 asks:
markings are closed under internal transitions, events are fired from the stable ones, and so on until nothing
is new.
"""

from __future__ import annotations

from collections.abc import Sequence

from mcpn._kernel import MemoryLimit
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.closing import Encode, close
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.diagrams.race import FIRST_BUDGET, Race, Work, cores
from mcpn.spaces.diagrams.race_entrants import runners
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.unsafe import refuse_unsafe
from mcpn.spaces.markings.masked import unsafe_at_start
from mcpn.turns import finished

DEFAULT_MEMORY = 4 << 30
FIRST_BUDGET_OF_COMPOSED = 8_000_000
"""About a second; with less, exploration one by one goes on instead, which takes ten times as long."""
MOST_WORKERS = 4


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
    """As :func:`reach`, as work that may rest between the slices of the race."""
    if error := unsafe_at_start(net):
        raise error
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
    # Composed nets are larger than small ones and have orders that are seldom bad: fewer rounds do.
    first = FIRST_BUDGET_OF_COMPOSED if net.priorities else FIRST_BUDGET
    limit: MemoryLimit | None = None
    for workers in sorted({min(cores(), MOST_WORKERS), 1}, reverse=True):  # one alone may have all the memory
        entrants = runners(net, encodes, seed, memory_limit // workers, edges)
        # With priorities each of many closures begins anew.
        race = Race(entrants, memory_limit, workers, first, resumable=not net.priorities)
        winner = yield from race.rounds()
        if isinstance(winner, UnsafeError):
            raise winner
        if winner is not None:
            return winner
        limit = race.limit
    raise LimitError(f"no order of places stays within memory: {limit}")
