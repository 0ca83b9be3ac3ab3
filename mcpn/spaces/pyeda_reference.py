"""The independent reference: markings as pyeda's BDDs, a plain fixpoint, exact counts.

It shares nothing with the kernel but a static order of places, on which no count depends. pyeda gives the
nodes and their unique table; its operators are not memoised, which makes them exponential, and its
``satisfy_count`` counts cubes instead of models. So the operators here are the memoised *apply* of Bryant
(*Graph-based algorithms for Boolean function manipulation*, IEEE Transactions on Computers 35, 1986), written
on pyeda's nodes, and a transition fires in one walk of the nodes, which asks for tokens and moves them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import EVENTS, PetriNet, SafeTransition
from mcpn.spaces.diagrams.order import clustered

MAX_NODES = 5_000_000
"""Nodes that pyeda may hold at a time; some 300 bytes each."""

Node: TypeAlias = Any
"""A node of pyeda, which has no types: ``root`` is its variable, ``lo`` and ``hi`` what follows."""

Asked: TypeAlias = tuple[int, bool, bool]
"""A variable, whether it must be marked, and whether it is marked afterwards."""


@dataclass(frozen=True)
class ReferenceCounts:
    """What the reference engine counts.

    Args:
        states: Reachable markings.
        edges: Firings, priorities respected.
        stable_states: Markings that enable no internal transition; ``None`` for nets without priorities.
        dead_states: Markings that enable no transition.
        max_tokens: Most tokens in a marking.
        nodes: Nodes of the diagram of the reachable markings.
        peak_nodes: Most nodes that pyeda held at the end of a round of the fixpoint.
    """

    states: int
    edges: int
    stable_states: int | None
    dead_states: int
    max_tokens: int
    nodes: int
    peak_nodes: int


class _Diagrams:
    """Sets of markings as nodes of pyeda, one variable for each place.

    Args:
        places: How many there are.
        max_nodes: How many nodes pyeda may hold.

    Raises:
        ImportError: pyeda is not installed.
    """

    def __init__(self, places: int, max_nodes: int) -> None:
        from pyeda.boolalg import bdd

        # A variable has the same number whatever net it is used for: later ones have larger numbers.
        self.roots: list[int] = [bdd.bddvar("p", number).node.root for number in range(places)]
        self.level = {root: number for number, root in enumerate(self.roots)}
        self.zero: Node = bdd.BDDNODEZERO
        self.one: Node = bdd.BDDNODEONE
        self.made: Callable[[int, Node, Node], Node] = bdd._bddnode
        self.held, self.max_nodes, self.peak = bdd._NODES, max_nodes, 0
        self._known: dict[tuple[str, Node, Node], Node] = {}

    def union(self, f: Node, g: Node) -> Node:
        """Markings of either set."""
        if f is g or g is self.zero:
            return f
        if f is self.zero:
            return g
        if f is self.one or g is self.one:
            return self.one
        return self._applied("or", self.union, f, g)

    def difference(self, f: Node, g: Node) -> Node:
        """Markings of the first set that are not in the second."""
        if f is g or f is self.zero or g is self.one:
            return self.zero
        return f if g is self.zero else self._applied("minus", self.difference, f, g)

    def _applied(self, name: str, operator: Callable[[Node, Node], Node], f: Node, g: Node) -> Node:
        found = self._known.get((name, f, g))
        if found is None:
            root = (max if self.one in (f, g) else min)(f.root, g.root)  # that of an end is negative
            f_lo, f_hi = (f.lo, f.hi) if f.root == root else (f, f)
            g_lo, g_hi = (g.lo, g.hi) if g.root == root else (g, g)
            found = self.made(root, operator(f_lo, g_lo), operator(f_hi, g_hi))
            self._known[name, f, g] = found
        return found

    def moved(self, f: Node, asked: Sequence[Asked]) -> Node:
        """The markings of a set that are as asked, with the tokens moved.

        Args:
            f: The set.
            asked: Of some variables, in ascending order.
        """
        known: list[dict[Node, Node]] = [{} for _ in asked]

        def walk(f: Node, number: int) -> Node:
            if number == len(asked) or f is self.zero:
                return f
            if (found := known[number].get(f)) is not None:
                return found
            root, before, after = asked[number]
            if f is not self.one and f.root < root:
                found = self.made(f.root, walk(f.lo, number), walk(f.hi, number))
            else:
                rest = f if f is self.one or f.root > root else (f.hi if before else f.lo)
                rest = walk(rest, number + 1)
                found = self.made(root, *((self.zero, rest) if after else (rest, self.zero)))
            known[number][f] = found
            return found

        return walk(f, 0)

    def forget(self) -> None:
        """Lets go of what is memoised, and with it of nodes that no set needs.

        Raises:
            LimitError: pyeda holds more nodes than allowed.
        """
        self.peak = max(self.peak, len(self.held))
        if self.peak > self.max_nodes:
            raise LimitError(f"pyeda holds {self.peak} nodes: the limit is {self.max_nodes}")
        self._known.clear()

    def marked(self, f: Node) -> set[int]:
        """The variables that a marking of a set may mark, as far as its nodes tell."""
        found = set(self.roots[: self.level.get(f.root)])
        for node in self.nodes(f):
            found |= {node.root} if node.hi is not self.zero else set()
            for below in {node.lo, node.hi} - {self.zero}:
                found.update(self.roots[self.level[node.root] + 1 : self.level.get(below.root)])
        return found

    def some(self, f: Node) -> set[int]:
        """The variables that one marking of a set marks."""
        marked = set[int]()
        while f is not self.one:
            marked |= {f.root} if f.lo is self.zero else set()
            f = f.hi if f.lo is self.zero else f.lo
        return marked

    def nodes(self, f: Node) -> set[Node]:
        """The nodes of a diagram, without its two ends."""
        found, open_ = {self.zero, self.one}, [f]
        while open_:
            if (node := open_.pop()) not in found:
                found.add(node)
                open_ += (node.lo, node.hi)
        return found - {self.zero, self.one}

    def folded(
        self,
        f: Node,
        empty: int,
        skipped: Callable[[int, int], int],
        joined: Callable[[int | None, int | None], int],
    ) -> int | None:
        """A number of a set of markings, made from the last place to the first.

        Args:
            f: The set.
            empty: The number where no place is left.
            skipped: The number over more places than these, any of which may be marked, from the number and
                how many more they are.
            joined: The number over one place more, from those without and with a token in it, of which one
                may be ``None``: there is no such marking.

        Returns:
            The number; ``None`` of no markings.
        """
        known: dict[Node, int | None] = {self.zero: None, self.one: empty}

        def level(node: Node) -> int:
            return self.level.get(node.root, len(self.roots))

        def over(node: Node, first: int) -> int | None:
            number = known[node]
            return None if number is None else skipped(number, level(node) - first)

        for node in sorted(self.nodes(f), key=level, reverse=True):
            known[node] = joined(over(node.lo, level(node) + 1), over(node.hi, level(node) + 1))
        return over(f, 0)


class _Space:
    def __init__(self, net: PetriNet, max_nodes: int) -> None:
        self.net, self.sets = net, _Diagrams(len(net.places), max_nodes)
        self.root = dict(zip(clustered(net), self.sets.roots, strict=True))
        self.enabling = [self._asked(read=(*t.consume, *t.read)) for t in net.safe_transitions]
        self.moving = [self._asked(t.read, t.consume, t.produce) for t in net.safe_transitions]

    def _asked(
        self, read: Sequence[int] = (), consume: Sequence[int] = (), produce: Sequence[int] = ()
    ) -> list[Asked]:
        return sorted(
            (self.root[p], before, after)
            for places, before, after in ((read, True, True), (consume, True, False), (produce, False, True))
            for p in places
        )

    def enabled(self, markings: Node, t: int) -> Node:
        blocked = self.net.safe_transitions[t].blocked
        return self.sets.zero if blocked else self.sets.moved(markings, self.enabling[t])

    def calm(self, markings: Node) -> dict[int, Node]:
        """By rank, the markings that enable no transition of a lower one."""
        by_rank: dict[int, Node] = {}
        for rank in sorted({*self.net.ranks, EVENTS}):
            by_rank[rank] = markings
            for t, own in enumerate(self.net.ranks):
                if own == rank:
                    markings = self.sets.difference(markings, self.enabled(by_rank[rank], t))
        return by_rank

    def firing(self, markings: Node) -> Iterator[tuple[int, Node]]:
        """Each transition with the markings in which it fires, priorities respected."""
        calm = self.calm(markings) if self.net.priorities else None
        for t, rank in enumerate(self.net.ranks):
            yield t, self.enabled(markings if calm is None else calm[rank], t)

    def reach(self) -> Node:
        """All reachable markings.

        The lowest rank that some marking waits for fires first. Within a rank each transition fires in what
        the ones before it have made, too (chaining), if that enables no lower rank.
        """
        sets, places = self.sets, range(len(self.net.places))
        marked = [(self.root[p], bool(self.net.initial[p])) for p in places]
        reachable = sets.moved(sets.one, sorted((root, tokens, tokens) for root, tokens in marked))
        ranks = sorted({*self.net.ranks, EVENTS}) if self.net.priorities else [EVENTS]
        waiting = {ranks[0]: reachable}  # by rank, markings whose lower ranks enable nothing
        while waiting:
            rank = min(waiting)
            here = waiting.pop(rank)
            idle, fresh, marked_in_some = here, sets.zero, sets.marked(here)
            for t, own in enumerate(self.net.ranks):
                needed = (root for root, _, _ in self.enabling[t])
                if (own == rank or not self.net.priorities) and marked_in_some.issuperset(needed):
                    enabled = self.enabled(here, t)
                    self.refuse_unsafe(enabled, t)
                    idle = sets.difference(idle, enabled)
                    new = sets.difference(sets.moved(enabled, self.moving[t]), reachable)
                    fresh, reachable = sets.union(fresh, new), sets.union(reachable, new)
                    if rank == ranks[0]:
                        here = sets.union(here, new)
                        marked_in_some.update(root for root, _, after in self.moving[t] if after)
            later = ranks[ranks.index(rank) + 1 :]
            for then, markings in ((ranks[0], fresh), *((r, idle) for r in later[:1])):
                if markings is not sets.zero:
                    waiting[then] = sets.union(waiting.get(then, sets.zero), markings)
            sets.forget()
        return reachable

    def refuse_unsafe(self, enabled: Node, t: int) -> None:
        safe: SafeTransition = self.net.safe_transitions[t]
        free = [(self.root[p], False, False) for p in safe.produce]
        doubled = self.sets.difference(enabled, self.sets.moved(enabled, sorted(free)))
        unsafe = enabled if safe.overflow else doubled
        if unsafe is not self.sets.zero:
            marked = self.sets.some(unsafe)
            place = next(
                p for p in (*safe.overflow, *safe.produce) if p in safe.overflow or self.root[p] in marked
            )
            names = [p.name for n, p in enumerate(self.net.places) if self.root[n] in marked]
            raise UnsafeError(self.net.places[place].name, self.net.transitions[t].name, names, [])

    def count(self, markings: Node) -> int:
        """How many markings."""
        return self.sets.folded(markings, 1, int.__lshift__, lambda lo, hi: (lo or 0) + (hi or 0)) or 0

    def largest(self, markings: Node) -> int:
        """Most tokens in one marking."""
        return self.sets.folded(markings, 0, int.__add__, _most) or 0


def _most(without: int | None, marked: int | None) -> int:
    return max(tokens for tokens in (without, None if marked is None else marked + 1) if tokens is not None)


@contextmanager
def _deep(levels: int) -> Iterator[None]:
    """Lets functions recur as deep as a diagram has levels."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, before + 2 * levels))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def count(net: PetriNet, max_nodes: int = MAX_NODES) -> ReferenceCounts:
    """Counts the reachable markings of a 1-safe net.

    Args:
        net: The net.
        max_nodes: How many nodes pyeda may hold.

    Returns:
        Exact counts.

    Raises:
        UnsafeError: The net is not 1-safe (no run is given).
        LimitError: pyeda holds more nodes than allowed.
    """
    for place in net.places:
        if place.initial > 1:
            raise UnsafeError(place.name, "", net.marked(net.initial), [])
    with _deep(len(net.places)):
        space = _Space(net, max_nodes)
        reachable = space.reach()
        edges, stuck = 0, reachable
        for _, enabled in space.firing(reachable):
            edges += space.count(enabled)
            stuck = space.sets.difference(stuck, enabled)
        return ReferenceCounts(
            states=space.count(reachable),
            edges=edges,
            stable_states=space.count(space.calm(reachable)[EVENTS]) if net.priorities else None,
            dead_states=space.count(stuck),
            max_tokens=space.largest(reachable),
            nodes=len(space.sets.nodes(reachable)),
            peak_nodes=space.sets.peak,
        )
