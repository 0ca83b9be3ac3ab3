"""The markings of any net without priorities as a decision diagram, with as many tokens as there are.

A 1-safe net is reached as such (:func:`mcpn.spaces.diagrams.symbolic.reach`). Any other has counters for
places (:mod:`mcpn.spaces.diagrams.counters`), of the widths that :mod:`mcpn.spaces.markings.widths` says.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from mcpn.errors import UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.order import Order
from mcpn.spaces.diagrams.race import Work
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY, closing, reaching
from mcpn.turns import finished

# Counters are loaded where a place may hold several tokens, as in missions none does.

WALK_STEPS = 20_000
"""Firings of the walk that looks for a second token in a place before a net is taken for 1-safe."""
FIRST_BITS = 2
"""Width of a counter of which no bound is known."""


def reach_markings(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
    edges: bool = False,
) -> SymbolicSpace:
    """Reaches every marking of a net, 1-safe or not.

    Args:
        net: The net; with priorities it must be 1-safe.
        order: Places from the top on; by default orders race.
        seed: Draws one more order for the race.
        memory_limit: Bytes that diagrams may take.
        edges: Whether firings are kept, if they fit, where markings are listed.

    Returns:
        The reachable markings.

    Raises:
        UnsafeError: The net has priorities and is not 1-safe.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit.
    """
    return finished(reaching_markings(net, order=order, seed=seed, memory_limit=memory_limit, edges=edges))


def reaching_markings(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
    edges: bool = False,
) -> Work[SymbolicSpace]:
    """As :func:`reach_markings`, as work that may rest between the rounds of the race."""
    if net.priorities or not surely_unsafe(net):
        try:
            return (yield from reaching(net, order=order, seed=seed, memory_limit=memory_limit, edges=edges))
        except UnsafeError:
            if net.priorities:
                raise
    return (yield from _reaching_tokens(net, order, seed, memory_limit))


def surely_unsafe(net: PetriNet) -> bool:
    """Whether the initial marking or a short walk puts several tokens in a place; it takes milliseconds."""
    from mcpn.spaces.search.searches import Searches

    searches = Searches(net)
    return not searches.fits or searches.walk_unsafe(steps=WALK_STEPS) is not None


def reach_tokens(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
) -> SymbolicSpace:
    """Reaches every marking of a bounded net, its places as counters; see :func:`reach_markings`.

    Raises:
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit.
    """
    return finished(_reaching_tokens(net, order, seed, memory_limit))


def _reaching_tokens(
    net: PetriNet, order: Order | None, seed: int | None, memory_limit: int
) -> Work[SymbolicSpace]:
    from mcpn.spaces.diagrams.counters import MOST_BITS, TokenEncoding
    from mcpn.spaces.markings.widths import Widths

    widths = Widths(net, first=FIRST_BITS, most=MOST_BITS)
    while True:
        encodes = [partial(TokenEncoding, widths=tuple(widths.bits), low_first=low) for low in (True, False)]
        space = yield from closing(net, *encodes, order=order, seed=seed, memory_limit=memory_limit)
        assert isinstance(space.encoding, TokenEncoding), "asked for counters"
        narrow = _overflowing(space, space.encoding.overflows)
        if not narrow:
            return space
        widths.widen(narrow)


def _overflowing(space: SymbolicSpace, overflows: Iterable[tuple[int, int]]) -> list[int]:
    """Places in which some reachable firing would put more tokens than their counters can say.

    Args:
        space: The reachable markings.
        overflows: Places with the conditions of such firings.
    """
    left, places = list(overflows), list[int]()
    while left and (first := space.reachable.first([condition for _, condition in left])) >= 0:
        places.append(left[first][0])
        left = [pair for pair in left[first + 1 :] if pair[0] not in places]
    return places
