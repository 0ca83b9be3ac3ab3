"""Bit widths of the counters of tokens: from invariants, and widened where a counter overflows.

No bound is believed. Whoever explores says which places a firing has put too many tokens in, and explores
again with wider ones. Once they have grown, P-semiflows, the coverability tree and linear programs are
asked whether there is an end to it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import floor, inf

from mcpn.errors import LimitError, UnboundedError
from mcpn.nets.petri import PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.semiflows import p_semiflows
from mcpn.nets.structure import changes, incidence, place_bounds
from mcpn.spaces.markings.boundedness import boundedness

UNASKED_BITS = 3
"""Bounds are asked for once a place has grown beyond this width."""
TREE_NODES, MOST_TREE_NODES = 500, 2_000
"""Nodes of the coverability tree, the first time and the last."""
MOST_FLOWS = 300
"""Vectors that the search for P-semiflows may hold."""
MOST_PROGRAMS = 500
"""Places whose bounds linear programs are asked for."""


class Widths:
    """Widths of the places of a net.

    Args:
        net: The net.
        first: Bits of a place of which no bound is known.
        most: Bits of a place at most.
        asking: Whether to ask for bounds before anything has grown, where invariants do not say them.

    Raises:
        UnboundedError: The net is unbounded.
        LimitError: A place needs more bits.
    """

    def __init__(self, net: PetriNet, *, first: int, most: int, asking: bool = False) -> None:
        self.net, self.most = net, most
        bounds = place_bounds(net)
        self.bits = [
            max(place.initial.bit_length(), first if bound == inf else int(bound).bit_length(), 1)
            for place, bound in zip(net.places, bounds, strict=True)
        ]
        """By place."""
        self._patience = 0 if net.priorities else TREE_NODES
        """Nodes of the next coverability tree; 0 once bounds are no longer asked for."""
        self._check()
        if asking and self._patience:
            self._ask([place for place, bound in enumerate(bounds) if bound == inf])

    def widen(self, narrow: Collection[int]) -> None:
        """Makes some places wider.

        Args:
            narrow: Places in which some reachable firing puts more tokens than fit.

        Raises:
            UnboundedError: The net is unbounded.
            LimitError: A place needs too many bits.
        """
        for place in narrow:
            self.bits[place] += 1 + self.bits[place] // 4
        if self._patience and max(self.bits[place] for place in narrow) > UNASKED_BITS:
            self._ask(narrow)
        self._check()

    def _ask(self, narrow: Collection[int]) -> None:
        """Asks for bounds, cheap methods first: P-semiflows, a coverability tree, linear programs."""
        if not narrow:
            return
        bounds: Mapping[int, float] | None = None
        if self._patience == TREE_NODES:
            bounds = _by_semiflows(self.net)
        if bounds is None or not bounds.keys() >= set(narrow):
            bounds = _by_tree(self.net, self._patience)
        if bounds is None and self._patience == MOST_TREE_NODES and len(narrow) <= MOST_PROGRAMS:
            bounds = by_programs(self.net, narrow)
        for place, bound in (bounds or {}).items():
            self.bits[place] = max(self.bits[place], int(bound).bit_length())
        self._patience = self._patience * 4 if self._patience < MOST_TREE_NODES else 0

    def _check(self) -> None:
        for place, bits in zip(self.net.places, self.bits, strict=True):
            if bits > self.most:
                raise LimitError(
                    f"{place.name} may hold more than {2**self.most - 1} tokens: the limit on tokens was hit"
                )


def _by_semiflows(net: PetriNet) -> dict[int, float] | None:
    """Bounds by P-semiflows, unless there are many."""
    try:
        flows = p_semiflows(net, max_rows=MOST_FLOWS)
    except LimitError:
        return None
    bounds: dict[int, float] = {}
    for flow in flows:
        total = sum(weight * net.initial[place] for place, weight in flow.items())
        for place, weight in flow.items():
            bounds[place] = min(bounds.get(place, total), total // weight)
    return bounds


def _by_tree(net: PetriNet, nodes: int) -> dict[int, float] | None:
    """The bounds of a net by place, if a small coverability tree knows them.

    Raises:
        UnboundedError: It knows that there are none.
    """
    try:
        verdict = boundedness(net, max_states=nodes)
    except LimitError:
        return None
    if verdict.bounded is False:
        grown = dict.fromkeys(range(len(net.places)), 0)
        for name in verdict.pump:
            for place, by in changes(net, net.transition_index[name]).items():
                grown[place] += by
        places = [net.places[place].name for place, by in grown.items() if by > 0]
        raise UnboundedError(places, verdict.run, verdict.pump, verdict.bounds)
    assert verdict.bounds is not None, "known of a bounded net without priorities"
    return dict(enumerate(verdict.bounds))


def by_programs(net: PetriNet, asked: Collection[int]) -> dict[int, float]:
    """Bounds of some places by weights whose weighted sum of tokens no firing raises; rounding may blur them.

    Linear programming: of all weights ``y >= 0`` with ``y[p] >= 1`` and ``y C <= 0``, those with the least
    ``y m0``, the bound of ``p`` (Murata 1989, section V-C; the dual of the state equation).
    """
    places = len(net.places)
    weights: list[dict[int, float]] = [{} for _ in net.transitions]
    for place, row in enumerate(incidence(net)):
        for t, change in row.items():
            weights[t][place] = change
    rows = [(row, -inf, 0.0) for row in weights]
    bounds = {}
    for place in asked:
        least = [float(p == place) for p in range(places)]
        solved = minimise(net.initial, rows, least, [inf] * places)
        if solved.kind == "solved":
            bounds[place] = float(floor(solved.cost + 1e-6))
    return bounds
