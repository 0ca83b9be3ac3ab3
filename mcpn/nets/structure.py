"""Structural analysis of a net: invariants and bounds by them, one-token units, complements, conflicts.

Everything here is exact integer arithmetic on the incidence matrix, and holds for every marking reachable
under any rule that fires one transition at a time; priorities only make the reachable markings fewer.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section V.

>>> from mcpn.nets.petri import NetBuilder
>>> builder = NetBuilder("lamp")
>>> for place, tokens in (("off", 1), ("on", 0), ("broken", 0), ("presses", 0)):
...     _ = builder.place(place, initial=tokens)
>>> builder.transition("press", consume=["off"], produce=["on", "presses"])
>>> builder.transition("fuse", consume=["on"], produce=["broken"])
>>> builder.transition("repair", consume=["broken"], produce=["off"])
>>> net = builder.build()
>>> invariants(net)
({0: 1, 1: 1, 2: 1},)
>>> state_machine_units(net)
((0, 1, 2),)
"""

from __future__ import annotations

from collections.abc import Iterable
from heapq import heapify, heappop, heappush
from itertools import combinations, islice
from math import gcd, inf
from typing import TypeAlias

from mcpn.nets.petri import Marking, PetriNet
from mcpn.turns import Pausing, finished

Sparse: TypeAlias = dict[int, int]
"""A vector of integers by index, without its zeros."""

SEARCH_STEPS = 20_000
"""How many places the searches for units may try in vain: it bounds time, never exactness."""
SEARCH_ARCS = 5_000_000
"""How many arcs they may look at meanwhile, since places of many arcs take longer: about a second."""


def incidence(net: PetriNet) -> tuple[Sparse, ...]:
    """What each transition changes in each place.

    Args:
        net: The net.

    Returns:
        By place: the tokens that a firing of each transition adds (negative: takes). Read arcs and balanced
        self-loops change nothing and do not show. Takes time linear in the number of arcs.
    """
    rows: list[Sparse] = [{} for _ in net.places]
    for number, transition in enumerate(net.transitions):
        for arcs, sign in ((transition.consume, -1), (transition.produce, 1)):
            for place, weight in arcs:
                change = rows[place].get(number, 0) + sign * weight
                if change:
                    rows[place][number] = change
                else:
                    del rows[place][number]
    return tuple(rows)


def invariants(net: PetriNet) -> tuple[Sparse, ...]:
    """A basis of the P-invariants: weights of places whose weighted sum of tokens no firing changes.

    Fraction-free Gaussian elimination, a transition at a time, the one with the fewest changed places first
    and the sparsest of its places as pivot, which keeps the rows short. Each vector is divided by the gcd of
    its weights, and its first weight is positive. The vectors span all P-invariants over the rationals.

    Args:
        net: The net.

    Returns:
        As many independent vectors as there are places less the rank of the incidence matrix. At worst cubic
        in the size of the net (and weights may grow); near linear on nets of loosely coupled components.

    See Also:
        :func:`mcpn.nets.semiflows.p_semiflows`: all of minimal support, none negative.
        :func:`state_machine_units`: the places of which one is marked at a time.
    """
    return finished(_eliminated(net))


def _eliminated(net: PetriNet) -> Pausing[tuple[Sparse, ...]]:
    """The invariants, with a pause after each transition."""
    rows = [dict(row) for row in incidence(net)]
    sums: list[Sparse] = [{place: 1} for place in range(len(rows))]
    columns: dict[int, set[int]] = {}
    for place, row in enumerate(rows):
        for transition in row:
            columns.setdefault(transition, set()).add(place)
    queue = [(len(places), transition) for transition, places in columns.items()]
    heapify(queue)
    spent: set[int] = set()
    while queue:
        size, transition = heappop(queue)
        places = columns[transition]
        if size != len(places) or not places:  # the column has changed since, and is queued again
            continue
        pivot = min(places, key=lambda p: (abs(rows[p][transition]) != 1, len(rows[p]) + len(sums[p]), p))
        lead = rows[pivot][transition]
        for place in sorted(places - {pivot}):
            factor = rows[place][transition]
            common = gcd(lead, factor)
            mine, other = lead // common, -factor // common
            before = set(rows[place])
            rows[place] = _combine(rows[place], mine, rows[pivot], other)
            sums[place] = _combine(sums[place], mine, sums[pivot], other)
            _divide(rows[place], sums[place])
            for changed in before - rows[place].keys():
                columns[changed].discard(place)
            for changed in rows[place].keys() - before:
                columns[changed].add(place)
        for changed in rows[pivot]:
            columns[changed].discard(pivot)
            heappush(queue, (len(columns[changed]), changed))
        spent.add(pivot)
        yield
    return tuple(_positive_first(sums[place]) for place in range(len(rows)) if place not in spent)


def _combine(left: Sparse, a: int, right: Sparse, b: int) -> Sparse:
    result = {index: a * value for index, value in left.items()} if a != 1 else dict(left)
    for index, value in right.items():
        total = result.get(index, 0) + b * value
        if total:
            result[index] = total
        else:
            del result[index]
    return result


def _divide(*vectors: Sparse) -> None:
    common = gcd(*(value for vector in vectors for value in vector.values()))
    if common > 1:
        for vector in vectors:
            for index in vector:
                vector[index] //= common


def _positive_first(vector: Sparse) -> Sparse:
    sign = 1 if vector[min(vector)] > 0 else -1
    return {index: sign * vector[index] for index in sorted(vector)}


def complements(net: PetriNet) -> tuple[tuple[int, int], ...]:
    """Pairs of places of which exactly one is marked in every reachable marking, with one token.

    Args:
        net: The net.

    Returns:
        Pairs (p, q), p < q, whose incidence rows are exact negatives of each other and not zero, and whose
        initial tokens sum up to 1, in ascending order. Takes time linear in the arcs and in the result.
    """
    rows = incidence(net)
    by_row: dict[frozenset[tuple[int, int]], list[int]] = {}
    for place, row in enumerate(rows):
        if row:
            by_row.setdefault(frozenset(row.items()), []).append(place)
    return tuple(
        (p, q)
        for p, row in enumerate(rows)
        if row
        for q in by_row.get(frozenset((t, -change) for t, change in row.items()), ())
        if p < q and net.places[p].initial + net.places[q].initial == 1
    )


def _holds_one_token(rows: tuple[Sparse, ...], initial: Marking, group: set[int]) -> bool:
    """Whether the group is an invariant with one initial token: then one of its places is always marked."""
    balance: Sparse = {}
    for place in group:
        for transition, change in rows[place].items():
            balance[transition] = balance.get(transition, 0) + change
    return sum(initial[p] for p in group) == 1 and not any(balance.values())


def state_machine_units(net: PetriNet, *, steps: int = SEARCH_STEPS) -> tuple[tuple[int, ...], ...]:
    """Groups of places of which exactly one is marked in every reachable marking, with one token.

    Each group is a P-invariant with weights 0 and 1 and one initial token. The groups found cover places
    greedily: the units that the net itself declares come first where they are such invariants; then, from
    each place that no group has yet, a search adds a place that balances a transition, places without a
    group first, and takes the choice back where it leads nowhere. Groups may overlap, and each has a place
    that those before it do not have. Any one place of a group is determined by the others; a marked place
    that nothing changes is a group of its own.

    Args:
        net: The net.
        steps: How many places all searches together may try beyond ten for each place of the net; groups
            that would need more are not found.

    Returns:
        Groups in the order found, each ascending; each verified, whatever the search did.
    """
    return finished(_grown(net, steps))


def _grown(net: PetriNet, steps: int, known: Iterable[int] = ()) -> Pausing[tuple[tuple[int, ...], ...]]:
    """The units, with a pause after each search; no search begins at a place that is known to be in some."""
    search = _UnitSearch(net)
    search.covered.update(known)
    units: list[tuple[int, ...]] = []
    for unit in net.units:
        if not search.covered.issuperset(unit) and _holds_one_token(search.rows, net.initial, set(unit)):
            units.append(tuple(sorted(set(unit))))
            search.covered.update(unit)
    budget = steps + 10 * len(net.places)
    for seed in range(len(net.places)):
        if seed not in search.covered and budget > 0 and search.looked_at < SEARCH_ARCS:
            budget -= search.grow(seed, min(steps // 10, budget))
            if search.group and _holds_one_token(search.rows, net.initial, search.group):
                units.append(tuple(sorted(search.group)))
                search.covered.update(search.group)
            yield
    return tuple(units)


class _UnitSearch:
    """Grows units from single places, depth first, with undoing and without recursion."""

    WIDTH = 32
    """Unbalanced transitions that a choice compares: more cost time, fewer cost wrong choices."""

    def __init__(self, net: PetriNet) -> None:
        self.initial = net.initial
        self.rows = incidence(net)
        self.takers: list[list[int]] = [[] for _ in net.transitions]
        self.givers: list[list[int]] = [[] for _ in net.transitions]
        for place, row in enumerate(self.rows):
            for transition, change in row.items():
                (self.takers if change < 0 else self.givers)[transition].append(place)
        self.given = [{t for t, change in row.items() if change > 0} for row in self.rows]
        self.taken = [{t for t, change in row.items() if change < 0} for row in self.rows]
        self.of_ones = [all(-1 <= change <= 1 for change in row.values()) for row in self.rows]
        self.covered: set[int] = set()
        self.group: set[int] = set()
        self.barred: set[int] = set()
        self.balance: Sparse = {}
        self.over: set[int] = set()
        """Transitions that give the group a token more than they take,"""
        self.under: set[int] = set()
        """or one less."""
        self.tokens = 0
        self.looked_at = 0
        """Arcs, in all searches."""

    def grow(self, seed: int, steps: int) -> int:
        """Leaves in ``group`` a unit that holds the seed, or nothing; returns how many places it tried."""
        self.group, self.barred, self.balance, self.tokens = set(), set(), {}, 0
        self.over, self.under = set(), set()
        # The places chosen so far; with each, those tried before it at its level, which led to a dead end.
        frames: list[tuple[int, list[int]]] = []
        failed: list[int] = []
        place: int | None = seed if self.fits(seed) else None
        for tried in range(1, steps + 1):
            while place is None:
                self.barred.difference_update(failed)
                if len(frames) <= 1:
                    self.group = set()
                    return tried
                last, failed = frames.pop()
                self.shift(last, -1)
                self.barred.add(last)
                failed.append(last)
                place = self.choice()
            frames.append((place, failed))
            failed = []
            self.shift(place, 1)
            if not self.balance and self.tokens == 1:
                return tried
            if self.looked_at >= SEARCH_ARCS:
                break
            place = self.choice()
        self.group = set()
        return steps

    def shift(self, place: int, sign: int) -> None:
        """Puts a place into the group, or takes it out again."""
        (self.group.add if sign > 0 else self.group.remove)(place)
        self.tokens += sign * self.initial[place]
        for transition, change in self.rows[place].items():
            total = self.balance.get(transition, 0) + sign * change
            if total:
                self.balance[transition] = total
                (self.over if total > 0 else self.under).add(transition)
            else:
                del self.balance[transition]
            if total <= 0:
                self.over.discard(transition)
            if total >= 0:
                self.under.discard(transition)

    def fits(self, place: int) -> bool:
        """Whether the group may take the place: one token in all, one given or taken by each transition."""
        if place in self.barred or place in self.group or self.tokens + self.initial[place] > 1:
            return False
        if self.of_ones[place]:
            return self.over.isdisjoint(self.given[place]) and self.under.isdisjoint(self.taken[place])
        balance = self.balance
        return all(-1 <= balance.get(t, 0) + change <= 1 for t, change in self.rows[place].items())

    def choice(self) -> int | None:
        """A place that balances the transition which leaves the least choice; ``None`` in a dead end."""
        fewest: list[int] | None = None
        for transition, change in islice(self.balance.items(), self.WIDTH):
            ends = (self.takers if change > 0 else self.givers)[transition]
            self.looked_at += sum(len(self.rows[p]) for p in ends)
            fitting = [p for p in ends if self.fits(p)]
            if fewest is None or len(fitting) < len(fewest):
                fewest = fitting
            if len(fewest) <= 1:
                break
        if not fewest:
            return None
        return min(fewest, key=lambda p: (p in self.covered, self.unbalanced(p), p))

    def unbalanced(self, place: int) -> int:
        """How many more transitions would be out of balance with the place in the group."""
        row = self.rows[place]
        return len(row) - 2 * len(row.keys() & self.balance.keys())


def conflicts(net: PetriNet, transitions: Iterable[int]) -> tuple[tuple[int, int], ...]:
    """Pairs of transitions of which firing one may disable the other, in 1-safe markings.

    Args:
        net: The net.
        transitions: Indices of the transitions to compare.

    Returns:
        Pairs (t, u), t < u, ascending, that consume a place in common, or of which one consumes what the
        other reads; a place that a transition consumes and produces counts as read. Two that only read a
        place are not in conflict. Whether a marking enables both is not asked. Takes time linear in the
        arcs and, place by place, in the pairs.
    """
    consumers: dict[int, list[int]] = {}
    readers: dict[int, list[int]] = {}
    for number in sorted(set(transitions)):
        transition = net.safe_transitions[number]
        for place in transition.consume:
            consumers.setdefault(place, []).append(number)
        for place in transition.read:
            readers.setdefault(place, []).append(number)
    pairs: set[tuple[int, int]] = set()
    for place, consuming in consumers.items():
        pairs.update(combinations(consuming, 2))
        pairs.update((min(t, u), max(t, u)) for t in consuming for u in readers.get(place, ()))
    return tuple(sorted(pairs))


def place_bounds(net: PetriNet) -> list[float]:
    """Most tokens that a place can hold in a reachable marking, by the invariants; else infinity."""
    return finished(bounding(net))


def bounding(net: PetriNet) -> Pausing[list[float]]:
    """:func:`place_bounds`, with pauses."""
    bounds = [inf] * len(net.places)
    for vector in (yield from _eliminated(net)):
        if min(vector.values()) > 0:
            total = sum(weight * net.initial[place] for place, weight in vector.items())
            for place, weight in vector.items():
                bounds[place] = min(bounds[place], total // weight)
    safe = [place for place, bound in enumerate(bounds) if bound <= 1]
    for unit in (yield from _grown(net, SEARCH_STEPS, safe)):
        for place in unit:
            bounds[place] = min(bounds[place], 1)
    return bounds


def needs(net: PetriNet, transition: int) -> dict[int, int]:
    """Tokens that a transition needs, by place.

    Examples:
        >>> from mcpn.testing.nets import kanban
        >>> needs(kanban(2), 0), changes(kanban(2), 0)
        ({0: 1}, {1: 1, 0: -1})
    """
    arcs = net.transitions[transition]
    weights = dict(arcs.consume)
    for place, weight in arcs.read:
        weights[place] = max(weights.get(place, 0), weight)
    return weights


def changes(net: PetriNet, transition: int) -> dict[int, int]:
    """Tokens that a firing of a transition adds, or takes, by place that it changes."""
    arcs = net.transitions[transition]
    effect = dict(arcs.produce)
    for place, weight in arcs.consume:
        effect[place] = effect.get(place, 0) - weight
    return {place: by for place, by in effect.items() if by}
