"""The markings of any net without priorities as a decision diagram, with as many tokens as there are.

A 1-safe net is reached as such (:func:`mcpn.space.diagrams.symbolic.reach`). Any other has counters for
places (:mod:`mcpn.space.diagrams.counters`), as wide as invariants say that they need be. No bound is
believed: where some firing would not fit into a counter, it is made wider and the markings are reached again.
Once counters have grown, the coverability tree and linear programs are asked whether there is an end to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf

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
UNASKED_BITS = 3
"""Counters that have grown wider ask the coverability tree and linear programs for a bound."""
TREE_NODES, MOST_TREE_NODES = 500, 32_000
"""Nodes of the tree, the first time and the last."""
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
    hints = place_bounds(net)
    widths = [_width(hint, place.initial) for hint, place in zip(hints, net.places, strict=True)]
    patience = TREE_NODES
    while True:
        _check(net, widths)

        def encode(net: PetriNet, order: Order, memory: int) -> TokenEncoding:
            return TokenEncoding(net, order, memory, widths)

        space = closure(net, encode, order=order, seed=seed, memory_limit=memory_limit)
        narrow = _overflowing(space)
        if not narrow:
            return space
        for place in narrow:
            widths[place] += 1 + widths[place] // 4
        if max(widths[place] for place in narrow) > UNASKED_BITS and patience:
            # By now it pays to know whether there is an end to it.
            bounds = _by_tree(net, patience)
            asked = [place for place in narrow if isinf(hints[place])]
            if bounds is None and patience == TREE_NODES and len(asked) <= MOST_PROGRAMS:
                bounds = _by_programs(net, asked)
            for place, bound in bounds.items() if bounds is not None else ():
                widths[place] = max(widths[place], _width(bound, 0))
            patience = patience * 4 if patience < MOST_TREE_NODES else 0


def _width(bound: float, initial: int) -> int:
    return max(initial.bit_length(), FIRST_BITS if isinf(bound) else int(bound).bit_length())


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


def _by_tree(net: PetriNet, nodes: int) -> dict[int, float] | None:
    """The bounds of a net by place, if a small coverability tree knows them.

    Raises:
        UnboundedError: It knows that there are none.
    """
    try:
        found = boundedness(net, max_states=nodes)
    except LimitError:
        return None
    assert found.bounds is not None, "known without priorities"
    if found.bounded is False:
        places = [place.name for place, bound in zip(net.places, found.bounds, strict=True) if bound == OMEGA]
        raise UnboundedError(places, found.run, found.pump, found.bounds)
    return dict(enumerate(map(float, found.bounds)))


def _by_programs(net: PetriNet, asked: Sequence[int]) -> dict[int, float]:
    """Bounds of some places by weights whose weighted sum of tokens no firing raises; rounding may blur them.

    Linear programming: of all weights ``y >= 0`` with ``y[p] >= 1`` and ``y C <= 0``, those with the least
    ``y m0``, the bound of ``p`` (Murata 1989, section V-C; the dual of the state equation).
    """
    import numpy as np
    from scipy.optimize import Bounds, LinearConstraint, milp
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
    found = {}
    for place in asked:
        least = np.zeros(len(rows))
        least[place] = 1.0
        solved = milp(cost, bounds=Bounds(least, np.inf), constraints=LinearConstraint(matrix, -np.inf, 0))
        if solved.status == 0:
            found[place] = float(np.floor(solved.fun + 1e-6))
    return found
