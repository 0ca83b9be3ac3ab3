"""The small independent reference: markings as pyeda BDDs, a plain fixpoint, exact counts.

It shares nothing with the kernel: a variable for each place, one image per transition, breadth first. pyeda's
``restrict`` is not memoised and takes exponential time, so images are made of conjunction and ``smoothing``
(existential quantification) alone; its ``satisfy_count`` counts cubes, not models, so models are counted by a
memoised walk of the nodes.

How far it reaches: nets of about 25 places in some seconds; beyond, use the kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mcpn.errors import UnsafeError
from mcpn.net.petri import EVENTS, PetriNet, SafeTransition


@dataclass(frozen=True)
class ReferenceCounts:
    """What the reference engine counts.

    Args:
        states: Reachable markings.
        edges: Firings, priorities respected.
        stable_states: Markings that enable no internal transition; ``None`` for nets without priorities.
        dead_states: Markings that enable no transition.
        max_tokens: Most tokens in a marking.
    """

    states: int
    edges: int
    stable_states: int | None
    dead_states: int
    max_tokens: int


class _Space:
    def __init__(self, net: PetriNet) -> None:
        from pyeda.boolalg.bdd import BDDNODEONE, BDDNODEZERO, BDDONE, BDDZERO, bddvar

        self.net = net
        self.one, self.zero = BDDONE, BDDZERO
        self.one_node, self.zero_node = BDDNODEONE, BDDNODEZERO
        self.places = [bddvar("p", number) for number in range(len(net.places))]
        self.index = {place.top.uniqid: number for number, place in enumerate(self.places)}

    def marked(self, places: tuple[int, ...]) -> Any:
        condition = self.one
        for place in places:
            condition = condition & self.places[place]
        return condition

    def unmarked(self, places: tuple[int, ...]) -> Any:
        condition = self.one
        for place in places:
            condition = condition & ~self.places[place]
        return condition

    def enabled(self, markings: Any, t: SafeTransition) -> Any:
        return self.zero if t.blocked else markings & self.marked((*t.consume, *t.read))

    def image(self, enabled: Any, t: SafeTransition) -> Any:
        changed = [self.places[p] for p in (*t.consume, *t.produce)]
        left = enabled.smoothing(changed) if changed else enabled
        return left & self.unmarked(t.consume) & self.marked(t.produce)

    def stable(self, markings: Any) -> Any:
        """The markings that enable no internal transition."""
        return self._calm(markings)[EVENTS]

    def _calm(self, markings: Any) -> dict[int, Any]:
        """By rank, the markings that enable no transition of a lower one."""
        by_rank: dict[int, Any] = {}
        for rank in sorted({*self.net.ranks, EVENTS}):
            by_rank[rank] = markings
            for t, own in zip(self.net.safe_transitions, self.net.ranks, strict=True):
                if own == rank:
                    markings = markings & ~self.enabled(by_rank[rank], t)
        return by_rank

    def firing(self, markings: Any) -> list[Any]:
        """The markings in which each transition fires, priorities respected."""
        calm = self._calm(markings) if self.net.priorities else None
        return [
            self.enabled(markings if calm is None else calm[rank], t)
            for t, rank in zip(self.net.safe_transitions, self.net.ranks, strict=True)
        ]

    def reach(self) -> Any:
        initial = self.one
        for place, tokens in zip(self.places, self.net.initial, strict=True):
            initial = initial & (place if tokens else ~place)
        reachable = layer = initial
        while not layer.is_zero():
            after = self.zero
            for number, enabled in enumerate(self.firing(layer)):
                t = self.net.safe_transitions[number]
                self.refuse_unsafe(enabled, number, t)
                after = after | self.image(enabled, t)
            layer = after & ~reachable
            reachable = reachable | layer
        return reachable

    def refuse_unsafe(self, enabled: Any, number: int, t: SafeTransition) -> None:
        for place in (*t.overflow, *t.produce):
            doubled = enabled if place in t.overflow else enabled & self.places[place]
            if not doubled.is_zero():
                marking = doubled.satisfy_one()
                names = [p.name for p, v in zip(self.net.places, self.places, strict=True) if marking.get(v)]
                raise UnsafeError(self.net.places[place].name, self.net.transitions[number].name, names, [])

    def count(self, markings: Any) -> int:
        """Models over all places: a skipped variable doubles them."""
        size = len(self.places)
        memo: dict[Any, int] = {}

        def level(node: Any) -> int:
            return size if node in (self.one_node, self.zero_node) else self.index[node.root]

        def visit(node: Any) -> int:
            if node is self.zero_node:
                return 0
            if node is self.one_node:
                return 1
            if node not in memo:
                here = level(node)
                memo[node] = sum(visit(n) << (level(n) - here - 1) for n in (node.lo, node.hi))
            return memo[node]

        return visit(markings.node) << level(markings.node)

    def largest(self, markings: Any) -> int:
        """Most marked places in one model: a skipped variable may be marked."""
        size = len(self.places)
        memo: dict[Any, int] = {}

        def level(node: Any) -> int:
            return size if node in (self.one_node, self.zero_node) else self.index[node.root]

        def visit(node: Any) -> int:
            if node is self.one_node:
                return 0
            if node not in memo:
                here = level(node)
                memo[node] = max(
                    marked + visit(n) + level(n) - here - 1
                    for marked, n in ((0, node.lo), (1, node.hi))
                    if n is not self.zero_node
                )
            return memo[node]

        return visit(markings.node) + level(markings.node)


def count(net: PetriNet) -> ReferenceCounts:
    """Counts the reachable markings of a small 1-safe net.

    Args:
        net: The net, of some 20 places.

    Returns:
        Exact counts.

    Raises:
        UnsafeError: The net is not 1-safe (no run is given).
    """
    for place in net.places:
        if place.initial > 1:
            raise UnsafeError(place.name, "", net.marked(net.initial), [])
    space = _Space(net)
    reachable = space.reach()
    firing = space.firing(reachable)
    alive = space.zero
    for enabled in firing:
        alive = alive | enabled
    return ReferenceCounts(
        states=space.count(reachable),
        edges=sum(space.count(enabled) for enabled in firing),
        stable_states=space.count(space.stable(reachable)) if net.priorities else None,
        dead_states=space.count(reachable & ~alive),
        max_tokens=space.largest(reachable),
    )
