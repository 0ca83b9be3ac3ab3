"""The markings of any net without priorities as a decision diagram, with as many tokens as there are.

A 1-safe net is reached as such (:func:`mcpn.space.diagrams.symbolic.reach`). Any other has counters for places
(:mod:`mcpn.space.diagrams.counters`), as wide as the invariants, the state equation or the coverability tree
say that they need be. No bound is believed: where some firing would not fit into a counter, it is made wider
and the markings are reached again.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isinf

from mcpn.errors import LimitError, UnboundedError, UnsafeError
from mcpn.net.petri import PetriNet
from mcpn.net.structure import Sparse, incidence
from mcpn.space.diagrams.counters import MOST_BITS, TokenEncoding
from mcpn.space.diagrams.order import Order
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY, SymbolicSpace, closure, reach
from mcpn.space.markings.tokens import OMEGA, boundedness
from mcpn.space.search.equation import place_bounds
from mcpn.space.search.searches import Searches

WALK_STEPS = 20_000
"""Firings of the walk that looks for a second token in a place before a net is taken for 1-safe."""
FIRST_BITS = 2
"""Width of a counter of which no bound is known."""
TREE_NODES = 2_000
"""Nodes of the coverability tree that is asked once counters have grown."""
MOST_PROGRAMS = 500
"""Places whose bounds the linear program is asked for."""


def reach_markings(
    net: PetriNet,
    *,
    order: Order | None = None,
    seed: int | None = None,
    memory_limit: int = DEFAULT_MEMORY,
) -> SymbolicSpace:
    """Reaches every marking of a net, 1-safe or not.

    Args:
        net: The net; with priorities it must be 1-safe.
        order: Places from the top on; by default orders race.
        seed: Draws one more order for the race.
        memory_limit: Bytes that diagrams may take.

    Returns:
        The reachable markings.

    Raises:
        UnsafeError: The net has priorities and is not 1-safe.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit.
    """
    if not net.priorities and surely_unsafe(net):
        return reach_tokens(net, order=order, seed=seed, memory_limit=memory_limit)
    try:
        return reach(net, order=order, seed=seed, memory_limit=memory_limit)
    except UnsafeError:
        if net.priorities:
            raise
        return reach_tokens(net, order=order, seed=seed, memory_limit=memory_limit)


def surely_unsafe(net: PetriNet) -> bool:
    """Whether the initial marking or a short walk puts several tokens in a place; it takes milliseconds."""
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
    widths = [_width(bound, place.initial) for bound, place in zip(bounds(net), net.places, strict=True)]
    grown = False
    while True:
        _check(net, widths)

        def encode(net: PetriNet, order: Order, memory: int) -> TokenEncoding:
            return TokenEncoding(net, order, memory, widths)  # noqa: B023

        space = closure(net, encode, order=order, seed=seed, memory_limit=memory_limit)
        narrow = _overflowing(space)
        if not narrow:
            return space
        if not grown and max(widths[p] for p in narrow) > FIRST_BITS:
            grown = True
            known = _by_tree(net)
            if known is not None:
                widths = [max(w, bound.bit_length()) for w, bound in zip(widths, known, strict=True)]
                continue
        for place in narrow:
            widths[place] += 1 + widths[place] // 4


def _width(bound: float, initial: int) -> int:
    known = 0 if isinf(bound) else int(bound).bit_length()
    return max(initial.bit_length(), known or 1) if known or not isinf(bound) else _open(initial)


def _open(initial: int) -> int:
    return max(initial.bit_length() + 1, FIRST_BITS)


def _check(net: PetriNet, widths: Sequence[int]) -> None:
    for place, width in zip(net.places, widths, strict=True):
        if width > MOST_BITS:
            raise LimitError(
                f"{place.name} may hold more than {2**MOST_BITS - 1} tokens: the limit on tokens was hit"
            )


def _overflowing(space: SymbolicSpace) -> list[int]:
    """Places in which some reachable firing would put more tokens than their counters can say."""
    encoding = space.encoding
    assert isinstance(encoding, TokenEncoding), "asked of counters"
    left, found = list(encoding.overflows), list[int]()
    while left and (first := space.reachable.first([condition for _, condition in left])) >= 0:
        found.append(left[first][0])
        left = [pair for pair in left[first + 1 :] if pair[0] not in found]
    return found


def _by_tree(net: PetriNet) -> tuple[int, ...] | None:
    """The bounds of a net, if a small coverability tree knows them.

    Raises:
        UnboundedError: It knows that there are none.
    """
    try:
        found = boundedness(net, max_states=TREE_NODES)
    except LimitError:
        return None
    if found.bounded is False:
        assert found.bounds is not None, "known without priorities"
        places = [place.name for place, bound in zip(net.places, found.bounds, strict=True) if bound == OMEGA]
        raise UnboundedError(places, found.run, found.pump)
    return found.bounds


def bounds(net: PetriNet) -> list[float]:
    """Most tokens that each place can hold, as far as arcs tell; else infinity. Hints, which rounding may blur."""
    found = place_bounds(net)
    unknown = [place for place, bound in enumerate(found) if isinf(bound)]
    if unknown and len(unknown) <= MOST_PROGRAMS:
        for place, bound in zip(unknown, _by_programs(net, unknown), strict=True):
            found[place] = bound
    return found


def _by_programs(net: PetriNet, asked: Sequence[int]) -> list[float]:
    """Bounds by weights of places whose weighted sum no firing raises, the best for each place.

    Linear programming: of all weights ``y >= 0`` with ``y[p] >= 1`` and ``y C <= 0``, those with the least
    ``y m0``, the bound of ``p`` (Murata 1989, section V-C; the dual of the state equation).
    """
    import numpy as np
    from scipy.optimize import linprog
    from scipy.sparse import csr_array

    rows: tuple[Sparse, ...] = incidence(net)
    cells = [(t, p, change) for p, row in enumerate(rows) for t, change in row.items()]
    matrix = csr_array(
        (
            np.array([change for _, _, change in cells], np.float64),
            (np.array([t for t, _, _ in cells], np.int32), np.array([p for _, p, _ in cells], np.int32)),
        ),
        shape=(len(net.transitions), len(rows)),
    )
    cost = np.array(net.initial, np.float64)
    found = []
    for place in asked:
        least = np.zeros(len(rows))
        least[place] = 1.0
        solved = linprog(
            cost,
            A_ub=matrix,
            b_ub=np.zeros(len(net.transitions)),
            bounds=np.stack((least, np.full(len(rows), np.inf)), axis=1),
            method="highs",
        )
        found.append(float(np.floor(solved.fun + 1e-6)) if solved.status == 0 else inf)
    return found
