"""Boundedness of nets whose places may hold many tokens.

Without priorities the coverability tree of Karp and Miller (*Parallel program schemata*, JCSS 1969) decides
boundedness. Walks take turns with it, for the tree may be far too large where a run that can be repeated is
near: they try to fire the numbers that a linear program proposes. With priorities boundedness is
undecidable in general (they can test for zero): then only a finite state space, or a run of internal
transitions that can be repeated for ever, decides it here.
"""

from __future__ import annotations

import random
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf, lcm

from mcpn.errors import LimitError
from mcpn.nets.petri import Arcs, PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.structure import changes, incidence, needs
from mcpn.records import record

OMEGA = -1
"""In the bounds of places and in markings of the coverability tree: any number of tokens."""

MAX_COVERED = 1_000_000
"""Nodes that a coverability tree may have."""

TURN = 500
"""Nodes that are made before walks have a turn."""
TURNS, TRIES, STRAY = 8, 30, 8
"""Turns of the walks, tries to fire the proposed numbers in each, and firings at random between two tries."""
MOST_SHARES, LONGEST = 1_000, 10_000
"""The largest denominator in a proposal, and the most firings of one."""

REPEATED = "this run can be repeated with more and more tokens"


@record(frozen=True)
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
    if net.priorities:
        return _with_priorities(net, max_states)
    tree, walks = _karp_miller(net, max_states), _growing(net)
    while True:
        try:
            for _ in range(TURN):
                next(tree)
        except StopIteration as ended:
            return ended.value  # type: ignore[no-any-return]
        except LimitError:
            if found := next((found for found in walks if found), None):
                return found
            raise
        if found := next(walks, None):
            return found


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


def _karp_miller(net: PetriNet, max_nodes: int) -> Generator[None, None, Boundedness]:
    """The coverability tree, as work that rests after each node; it returns the answer.

    Raises:
        LimitError: There are more nodes, and none covers one before it.
    """
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
            yield
            if nodes > max_nodes and pumping is None:
                raise LimitError(f"more than {max_nodes} nodes: the limit on the coverability tree was hit")
            if nodes > max_nodes and pumping is not None:
                return Boundedness(False, None, *pumping, reason=REPEATED)
    if pumping is None:
        return Boundedness(True, tuple(bounds), reason="the coverability tree holds every marking")
    return Boundedness(False, tuple(bounds), *pumping, reason=REPEATED)


def _growing(net: PetriNet) -> Iterator[Boundedness | None]:
    """Looks for a run that adds tokens and takes none, to be repeated for ever; each turn takes little time.

    A linear program proposes numbers of firings that take from no place and add to some. A walk tries to fire
    them one after the other, wherever it is; the next turn has another proposal, by other costs.
    """
    draw = random.Random(net.name)
    effects = [changes(net, t) for t in range(len(net.transitions))]
    for _ in range(TURNS):
        numbers = _proposed_growth(net, [draw.uniform(1, 2) for _ in effects])
        if not numbers:
            return  # then nothing grows, or the proposal was no whole one
        marking, run = list(net.initial), list[int]()
        for _ in range(TRIES):
            before, left = len(run), dict(numbers)
            while left and (ready := [t for t in left if net.covers(marking, t)]):
                t = draw.choice(ready)
                left[t] -= 1
                if not left[t]:
                    del left[t]
                net.fire_in_place(marking, t)
                run.append(t)
            if not left:
                names = [net.transitions[t].name for t in run]
                yield Boundedness(False, None, (*names[:before],), (*names[before:],), reason=REPEATED)
                return
            for t in draw.choices(range(len(effects)), k=STRAY * len(effects)):
                if net.covers(marking, t):
                    net.fire_in_place(marking, t)
                    run.append(t)
                    if len(run) >= before + STRAY:
                        break
        yield None


def _proposed_growth(net: PetriNet, costs: Sequence[float]) -> dict[int, int]:
    """Few firings, by transition, that together add tokens and take none; nothing where none are found."""
    rows = incidence(net)
    total: dict[int, float] = {}
    for row in rows:
        for t, change in row.items():
            total[t] = total.get(t, 0) + change
    count = len(net.transitions)
    wanted: list[tuple[Mapping[int, float], float, float]] = [
        *((row, 0.0, inf) for row in rows),
        (total, 1.0, inf),
    ]
    solved = minimise(costs, wanted, [0.0] * count, [inf] * count)
    if solved.kind != "solved":
        return {}
    shares = [Fraction(value).limit_denominator(MOST_SHARES) for value in solved.values]
    common = lcm(*(share.denominator for share in shares))
    numbers = {t: int(share * common) for t, share in enumerate(shares) if share}
    sums = [sum(numbers.get(t, 0) * change for t, change in row.items()) for row in rows]
    return numbers if min(sums) >= 0 < max(sums) and sum(numbers.values()) <= LONGEST else {}


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
