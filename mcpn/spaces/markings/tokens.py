"""Boundedness of nets whose places may hold many tokens.

Without priorities the coverability tree of Karp and Miller (*Parallel program schemata*, JCSS 1969) decides
boundedness. With priorities it is undecidable in general (they can test for zero): then only a finite state
space, or a run of internal transitions that can be repeated for ever, decides it here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcpn.errors import LimitError
from mcpn.nets.petri import Arcs, PetriNet
from mcpn.nets.structure import needs

OMEGA = -1
"""In the bounds of places and in markings of the coverability tree: any number of tokens."""

MAX_COVERED = 1_000_000
"""Nodes that a coverability tree may have."""

REPEATED = "this run can be repeated with more and more tokens"


@dataclass(frozen=True)
class Boundedness:
    """Whether a net is bounded.

    Args:
        bounded: The answer, ``None`` where it is not known.
        bounds: By place, the most tokens it holds, :data:`OMEGA` where there is no such number; ``None``
            where that is not known.
        run: Where the net is unbounded, transitions from the initial marking on,
        pump: and those that can then be repeated for ever, each time leaving more tokens.
        reason: What the answer rests on.
    """

    bounded: bool | None
    bounds: tuple[int, ...] | None
    run: tuple[str, ...] = ()
    pump: tuple[str, ...] = ()
    reason: str = ""

    @property
    def bound(self) -> int | None:
        """The least bound of all places, where the net is bounded."""
        return max(self.bounds, default=0) if self.bounded and self.bounds is not None else None


def boundedness(net: PetriNet, *, max_states: int = MAX_COVERED) -> Boundedness:
    """Decides whether a net is bounded, and by what.

    Args:
        net: The net.
        max_states: How many markings, or nodes of the coverability tree, may be looked at.

    Returns:
        The answer; where priorities leave it open, an honest ``None``. Bounds of an unbounded net are left
        out where the limit was hit.

    Raises:
        LimitError: The limit was hit in a net without priorities, and no run was found that can be repeated
            with more and more tokens.
    """
    return _with_priorities(net, max_states) if net.priorities else _karp_miller(net, max_states)


@dataclass
class _Node:
    marking: tuple[int, ...]
    parent: _Node | None
    transition: int

    def ancestors(self) -> list[_Node]:
        nodes, at = list["_Node"](), self.parent
        while at is not None:
            nodes.append(at)
            at = at.parent
        return nodes


def _covers(more: Sequence[int], less: Sequence[int]) -> bool:
    return all(a == OMEGA or (b != OMEGA and a >= b) for a, b in zip(more, less, strict=True))


def _enabled(marking: tuple[int, ...], needed: Arcs) -> bool:
    return all(marking[p] == OMEGA or marking[p] >= w for p, w in needed)


def _karp_miller(net: PetriNet, max_nodes: int) -> Boundedness:
    root = _Node(net.initial, None, -1)
    stack, nodes, bounds = [root], 1, list(net.initial)
    seen: set[tuple[int, ...]] = set()
    pumping: tuple[tuple[str, ...], tuple[str, ...]] | None = None  # a run, and what repeats after it
    while stack:
        node = stack.pop()
        if node.marking in seen:
            continue
        seen.add(node.marking)
        bounds = [OMEGA if OMEGA in pair else max(pair) for pair in zip(bounds, node.marking, strict=True)]
        for t, transition in enumerate(net.transitions):
            if not _enabled(node.marking, (*transition.consume, *transition.read)):
                continue
            after = list(node.marking)
            for arcs, sign in ((transition.consume, -1), (transition.produce, 1)):
                for p, w in arcs:
                    after[p] += 0 if after[p] == OMEGA else sign * w
            child = _Node(tuple(after), node, t)
            for ancestor in child.ancestors():
                if child.marking != ancestor.marking and _covers(child.marking, ancestor.marking):
                    if pumping is None:
                        pumping = _names(net, ancestor), _names(net, child)[len(_names(net, ancestor)) :]
                    grown = [
                        OMEGA if a != b else a for a, b in zip(child.marking, ancestor.marking, strict=True)
                    ]
                    child.marking = tuple(grown)
            stack.append(child)
            nodes += 1
            if nodes > max_nodes and pumping is None:
                raise LimitError(f"more than {max_nodes} nodes: the limit on the coverability tree was hit")
            if nodes > max_nodes and pumping is not None:
                return Boundedness(False, None, *pumping, reason=REPEATED)
    if pumping is None:
        return Boundedness(True, tuple(bounds), reason="the coverability tree holds every marking")
    return Boundedness(False, tuple(bounds), *pumping, reason=REPEATED)


def _names(net: PetriNet, node: _Node) -> tuple[str, ...]:
    path = [n for n in (node, *node.ancestors()) if n.parent is not None]
    return tuple(net.transitions[n.transition].name for n in reversed(path))


def _with_priorities(net: PetriNet, max_states: int) -> Boundedness:
    """Explores the markings, and looks for an internal run that adds tokens and can be repeated for ever.

    Events cannot prevent the repetition, since internal transitions come first. Nor do internal transitions
    of lower ranks than those fired, where each of them lacks tokens in a place that the run does not fill.
    """
    stack = [_Node(net.initial, None, -1)]
    seen: set[tuple[int, ...]] = set()
    bounds = list(net.initial)
    while stack:
        node = stack.pop()
        if node.marking in seen:
            continue
        seen.add(node.marking)
        bounds = [max(pair) for pair in zip(bounds, node.marking, strict=True)]
        if len(seen) > max_states:
            reason = f"more than {max_states} markings, and with priorities no run was found that must repeat"
            return Boundedness(None, None, reason=reason)
        at, lacking = node, set[frozenset[int]]()
        while at.parent is not None and net.transitions[at.transition].internal:
            lacking |= _lacking(net, at.parent.marking, net.ranks[at.transition])
            at = at.parent
            if node.marking == at.marking or not _covers(node.marking, at.marking):
                continue
            filled = {p for p, tokens in enumerate(at.marking) if node.marking[p] > tokens}
            if not any(places <= filled for places in lacking):
                prefix = _names(net, at)
                reason = "this internal run can be repeated with more and more tokens"
                return Boundedness(False, None, prefix, _names(net, node)[len(prefix) :], reason)
        for t in net.enabled(node.marking):
            stack.append(_Node(net.fire(node.marking, t), node, t))
    return Boundedness(True, tuple(bounds), reason="every marking was explored")


def _lacking(net: PetriNet, marking: tuple[int, ...], rank: int) -> set[frozenset[int]]:
    """For each transition of a lower rank, the places in which it lacks tokens."""
    lower = [t for same_rank in net.internal_ranks for t in same_rank if net.ranks[t] < rank]
    return {frozenset(p for p, tokens in needs(net, t).items() if marking[p] < tokens) for t in lower}
