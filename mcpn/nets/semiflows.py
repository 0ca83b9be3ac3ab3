"""Semiflows of a net, those of minimal support, and the state machines among them.

A read arc takes its token and puts it back, so it changes nothing.

Reference: J. Martinez, M. Silva, *A simple and fast algorithm to obtain all invariants of a generalised Petri
net*, 1982.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("press", consume=["off"], produce=["on"])
>>> builder.transition("again", consume=["on"], produce=["off"])
>>> net = builder.build()
>>> p_semiflows(net), t_semiflows(net)
(({0: 1, 1: 1},), ({0: 1, 1: 1},))
"""

from __future__ import annotations

from math import gcd

from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import Sparse, incidence
from mcpn.nets.surroundings import Places, bits_of, surroundings

MAX_ROWS = 1_000
COMBINATIONS_OF_A_ROW = 100
COMPARISONS_OF_A_ROW = 20_000
"""What each row that a limit allows stands for in work: sums of vectors, and comparisons of sets."""


def p_semiflows(net: PetriNet, *, max_rows: int = MAX_ROWS) -> tuple[Sparse, ...]:
    """Every P-semiflow of minimal support: weights of places whose weighted sum of tokens never changes.

    Args:
        net: The net.
        max_rows: How many intermediate vectors there may be.

    Returns:
        Positive weights by place, without a common divisor.

    Raises:
        LimitError: The limit was hit.

    See Also:
        :func:`mcpn.nets.structure.invariants`: a basis, in polynomial time.
        :func:`state_machine_components`: those of weight one that carry one token.

    Examples:
        >>> from mcpn.testing.nets import kanban
        >>> net = kanban(3)
        >>> [{net.places[p].name: weight for p, weight in flow.items()} for flow in p_semiflows(net)][0]
        {'machine1': 1, 'rework1': 1, 'out1': 1, 'card1': 1}
    """
    return _semiflows([dict(row) for row in incidence(net)], max_rows, "P-semiflows")


def t_semiflows(net: PetriNet, *, max_rows: int = MAX_ROWS) -> tuple[Sparse, ...]:
    """Every T-semiflow of minimal support: numbers of firings that lead back to the same marking.

    Args:
        net: The net.
        max_rows: How many intermediate vectors there may be.

    Returns:
        Positive numbers by transition, without a common divisor.

    Raises:
        LimitError: The limit was hit.
    """
    effects: list[Sparse] = [{} for _ in net.transitions]
    for place, row in enumerate(incidence(net)):
        for t, change in row.items():
            effects[t][place] = change
    return _semiflows(effects, max_rows, "T-semiflows")


def _semiflows(effects: list[Sparse], max_rows: int, what: str) -> tuple[Sparse, ...]:
    """Non-negative combinations of effects that add up to nothing (Farkas; Martinez and Silva 1982)."""
    rows: list[tuple[Sparse, Sparse]] = [({i: 1}, dict(effect)) for i, effect in enumerate(effects)]
    left = {key for _, effect in rows for key in effect}
    made = 0
    while left:
        column = _cheapest(sorted(left), rows)
        left.discard(column)
        kept = [row for row in rows if not row[1].get(column)]
        ups = [row for row in rows if row[1].get(column, 0) > 0]
        downs = [row for row in rows if row[1].get(column, 0) < 0]
        made += len(ups) * len(downs)
        if made > max_rows * COMBINATIONS_OF_A_ROW:
            raise LimitError(
                f"more than {max_rows * COMBINATIONS_OF_A_ROW} combinations of vectors:"
                f" the limit on {what} was hit"
            )
        for up in ups:
            for down in downs:
                a, b = -down[1][column], up[1][column]
                flow = _sum(up[0], a, down[0], b)
                effect = _sum(up[1], a, down[1], b)
                divisor = gcd(*flow.values(), *effect.values())
                kept.append(
                    ({k: v // divisor for k, v in flow.items()}, {k: v // divisor for k, v in effect.items()})
                )
        rows = _minimal(kept, max_rows * COMPARISONS_OF_A_ROW, what)
        if len(rows) > max_rows:
            raise LimitError(f"more than {max_rows} vectors: the limit on {what} was hit")
    flows = [dict(sorted(flow.items())) for flow, _ in rows]
    return tuple(sorted(flows, key=lambda flow: sorted(flow.items())))


def _cheapest(columns: list[int], rows: list[tuple[Sparse, Sparse]]) -> int:
    """The column whose elimination makes the fewest new rows."""

    def growth(column: int) -> int:
        signs = [effect.get(column, 0) for _, effect in rows]
        ups, downs = sum(sign > 0 for sign in signs), sum(sign < 0 for sign in signs)
        return ups * downs - ups - downs

    return min(columns, key=growth)


def _sum(left: Sparse, a: int, right: Sparse, b: int) -> Sparse:
    total = {key: a * value for key, value in left.items()}
    for key, value in right.items():
        total[key] = total.get(key, 0) + b * value
    return {key: value for key, value in total.items() if value}


def _minimal(rows: list[tuple[Sparse, Sparse]], max_compared: int, what: str) -> list[tuple[Sparse, Sparse]]:
    """Rows whose support holds that of no other; one for each support."""
    solutions: list[tuple[int, tuple[Sparse, Sparse]]] = []
    compared = 0
    for row in sorted(rows, key=lambda row: len(row[0])):
        compared += len(solutions)
        if compared > max_compared:
            raise LimitError(f"more than {max_compared} comparisons of vectors: the limit on {what} was hit")
        support = bits_of(row[0])
        if not any(known & support == known for known, _ in solutions):
            solutions.append((support, row))
    return [row for _, row in solutions]


def state_machine_components(net: PetriNet, *, max_rows: int = MAX_ROWS) -> tuple[Places, ...]:
    """Sets of places that each transition leaves and enters by at most one of them, tokens conserved.

    Args:
        net: The net.
        max_rows: As for :func:`p_semiflows`.

    Returns:
        The supports of P-semiflows that are state machines; those that hold one token initially always do.

    Raises:
        LimitError: The limit was hit.
    """
    around = surroundings(net)
    components = []
    for flow in p_semiflows(net, max_rows=max_rows):
        support = bits_of(flow)
        single = all((b & support).bit_count() < 2 and (a & support).bit_count() < 2 for b, a in around)
        if single and set(flow.values()) == {1}:
            components.append(tuple(sorted(flow)))
    return tuple(components)
