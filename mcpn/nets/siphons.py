"""Siphons, traps, classes and semiflows of a net: what holds whatever the order of firing.

A read arc counts as consuming and producing a token at once: its place stands before and after the
transition, unless the transition consumes from it besides. Weights are looked at by semiflows only; siphons,
traps and classes see which places stand where, so that what is said of classes holds for *ordinary* nets.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, sections V
and VI; J. Martinez, M. Silva, *A simple and fast algorithm to obtain all invariants of a generalised Petri
net*, 1982.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> places = builder.place("off", initial=1), builder.place("on")
>>> builder.transition("press", consume=["off"], produce=["on"])
>>> builder.transition("again", consume=["on"], produce=["off"])
>>> net = builder.build()
>>> siphons(net), traps(net), sorted(classes(net))[:2]
(((0, 1),), ((0, 1),), ['asymmetric choice', 'extended free choice'])
>>> p_semiflows(net), t_semiflows(net)
(({0: 1, 1: 1},), ({0: 1, 1: 1},))
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import gcd
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import Sparse, incidence

MAX_STEPS = 20_000
MAX_ROWS = 1_000

COMPARISONS_OF_A_STEP = 2_000
COMBINATIONS_OF_A_ROW = 100
COMPARISONS_OF_A_ROW = 20_000
"""What each step or row that a limit allows stands for in work: comparisons of sets, and sums of vectors."""

Places: TypeAlias = tuple[int, ...]


def surroundings(net: PetriNet) -> list[tuple[int, int]]:
    """Places before and after each transition, as sets of bits.

    A place that is read as well as consumed from stands before only: its token does not stay.
    """
    pairs = []
    for t in net.transitions:
        taken, put, still = (_bits(p for p, _ in arcs) for arcs in (t.consume, t.produce, t.read))
        pairs.append((taken | still, put | still & ~taken))
    return pairs


def siphons(net: PetriNet, *, max_steps: int = MAX_STEPS) -> tuple[Places, ...]:
    """Every minimal siphon: places that, once without tokens, stay so.

    Args:
        net: The net.
        max_steps: How many sets the search may look at; there may be exponentially many siphons.

    Returns:
        The inclusion-minimal non-empty siphons, sorted.

    Raises:
        LimitError: The limit was hit.

    See Also:
        :func:`commoner`: whether each contains a marked trap.
        :func:`traps`: places that keep tokens.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> net = philosophers(2)
        >>> sorted(net.places[p].name for p in siphons(net)[3])
        ['eat0', 'eat1', 'fork0', 'fork1']
    """
    return _closed(surroundings(net), len(net.places), max_steps, "siphons")


def traps(net: PetriNet, *, max_steps: int = MAX_STEPS) -> tuple[Places, ...]:
    """Every minimal trap: places that, once they hold a token, always hold one.

    Args:
        net: The net.
        max_steps: How many sets the search may look at.

    Returns:
        The inclusion-minimal non-empty traps, sorted.

    Raises:
        LimitError: The limit was hit.
    """
    turned = [(after, before) for before, after in surroundings(net)]
    return _closed(turned, len(net.places), max_steps, "traps")


def _closed(around: Sequence[tuple[int, int]], places: int, max_steps: int, what: str) -> tuple[Places, ...]:
    """Minimal sets such that whatever puts into them also takes from them.

    Depth first: where some transition puts into the chosen set and takes nothing from it, one of the places
    that it takes from must be added; each of them is a branch of the search.
    """
    minimal: list[int] = []
    seen: set[int] = set()
    stack = [1 << p for p in range(places)]
    compared = 0
    while stack:
        chosen = stack.pop()
        if chosen in seen:
            continue
        compared += len(minimal)
        if compared > max_steps * COMPARISONS_OF_A_STEP:
            raise LimitError(
                f"more than {max_steps * COMPARISONS_OF_A_STEP} comparisons of sets:"
                f" the limit on the search for {what} was hit"
            )
        if any(known & chosen == known for known in minimal):
            continue
        seen.add(chosen)
        if len(seen) > max_steps:
            raise LimitError(
                f"more than {max_steps} sets looked at: the limit on the search for {what} was hit"
            )
        unfed = next((before for before, after in around if after & chosen and not before & chosen), None)
        if unfed is None:
            minimal = [known for known in minimal if known & chosen != chosen]
            minimal.append(chosen)
        else:
            stack.extend(chosen | 1 << p for p in _members(unfed))
    return tuple(sorted(tuple(_members(chosen)) for chosen in minimal))


def greatest_trap(net: PetriNet, places: Iterable[int]) -> Places:
    """The greatest trap inside a set of places."""
    inside = _bits(places)
    around = surroundings(net)
    while True:
        lost = 0
        for before, after in around:
            if not after & inside:
                lost |= before & inside
        if not lost:
            return tuple(_members(inside))
        inside &= ~lost


def commoner(net: PetriNet, *, max_steps: int = MAX_STEPS) -> Places | None:
    """A minimal siphon that contains no marked trap, or ``None`` where each contains one.

    An ordinary free choice net is live exactly where there is none (Commoner's theorem; Hack 1972); an
    asymmetric choice net is live if there is none.

    Raises:
        LimitError: The limit on the search for siphons was hit.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> net = philosophers(2)
        >>> [net.places[p].name for p in commoner(net) or ()]
        ['eat0', 'fork0', 'eat1', 'fork1']
    """
    touched = 0
    for before, after in surroundings(net):
        touched |= before | after
    for siphon in siphons(net, max_steps=max_steps):
        if not _bits(siphon) & touched:
            continue  # a place without arcs hinders nothing
        if not any(net.initial[p] for p in greatest_trap(net, siphon)):
            return siphon
    return None


def classes(net: PetriNet) -> frozenset[str]:
    """Structural classes that the net belongs to.

    Returns:
        Among ``ordinary`` (all weights 1), ``pure`` (no place both before and after a transition), ``state
        machine``, ``marked graph``, ``free choice``, ``extended free choice``, ``asymmetric choice``.

    Examples:
        >>> from mcpn.testing.nets import philosophers, token_ring
        >>> sorted(classes(philosophers(2)))
        ['ordinary', 'pure']
        >>> classes(token_ring(3)) - classes(philosophers(2)) >= {"free choice", "state machine"}
        True
    """
    around, places = surroundings(net), range(len(net.places))
    consumers = [frozenset(i for i, (before, _) in enumerate(around) if before >> p & 1) for p in places]
    producers = [frozenset(i for i, (_, after) in enumerate(around) if after >> p & 1) for p in places]
    pairs = [(consumers[p], consumers[q]) for p in places for q in range(p) if consumers[p] & consumers[q]]
    arcs = [w for t in net.transitions for side in (t.consume, t.produce, t.read) for _, w in side]
    held = {
        "ordinary": all(w == 1 for w in arcs),
        "pure": all(not before & after for before, after in around),
        "state machine": all(b.bit_count() == 1 and a.bit_count() == 1 for b, a in around),
        "marked graph": all(len(c) <= 1 and len(p) <= 1 for c, p in zip(consumers, producers, strict=True)),
        "free choice": all(
            len(consumers[p]) == 1 or before.bit_count() == 1
            for before, _ in around
            for p in _members(before)
        ),
        "extended free choice": all(c == d for c, d in pairs),
        "asymmetric choice": all(c <= d or d <= c for c, d in pairs),
    }
    return frozenset(name for name, holds in held.items() if holds)


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
        support = _bits(row[0])
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
        support = _bits(flow)
        single = all((b & support).bit_count() < 2 and (a & support).bit_count() < 2 for b, a in around)
        if single and set(flow.values()) == {1}:
            components.append(tuple(sorted(flow)))
    return tuple(components)


def _bits(members: Iterable[int]) -> int:
    return sum(1 << member for member in set(members))


def _members(bits: int) -> list[int]:
    return [i for i in range(bits.bit_length()) if bits >> i & 1]
