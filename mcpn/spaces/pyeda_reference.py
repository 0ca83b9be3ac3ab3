"""The independent reference: markings as pyeda's BDDs, plain fixpoints, exact counts.

It shares nothing with the kernel but a static order of places, on which no count depends. pyeda gives the
nodes and their unique table; its operators are not memoised, which makes them exponential, and its
``satisfy_count`` counts cubes instead of models. So the operators here are the memoised *apply* of Bryant
(*Graph-based algorithms for Boolean function manipulation*, IEEE Transactions on Computers 35, 1986), written
on pyeda's nodes. What no transition may overtake is closed by *saturation* (Ciardo, Lüttgen, Siminiceanu,
TACAS 2001), other transitions fire one after the other in what those before them have made (*chaining*).
It has closures of its own because, behind the protocol of :mod:`mcpn.spaces.custom_engine`,
the Ulysse mission takes 24 s of CPU time instead of 0.5 s, and 13 s where ranks are closed in the order used
here: the protocol moves whole sets, and saturation works on the parts of a diagram.
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import EVENTS, PetriNet
from mcpn.spaces.diagrams.order import clustered

MAX_NODES = 5_000_000
"""Nodes that pyeda may hold at a time; some 300 bytes each."""
MAX_SECONDS = 3600.0
"""CPU seconds that a count may take."""
MAX_RESULTS = 3_000_000
"""Results of operators that are remembered at a time."""
CHECKED = 4096
"""How many results there are from one look at the limits to the next."""

Node: TypeAlias = Any
"""A node of pyeda, which has no types: ``root`` is its variable, ``lo`` and ``hi`` what follows."""

Asked: TypeAlias = tuple[int, bool, bool]
"""A level, whether its place must be marked, and whether it is marked afterwards."""


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
        peak_nodes: Most nodes that pyeda held when the limits were looked at.
    """

    states: int
    edges: int
    stable_states: int | None
    dead_states: int
    max_tokens: int
    nodes: int
    peak_nodes: int


class _Diagrams:
    """Sets of markings as nodes of pyeda, one level for each place.

    Args:
        places: How many there are.
        max_nodes: How many nodes pyeda may hold.
        seconds: How much CPU time there is.

    Raises:
        ImportError: pyeda is not installed.
    """

    def __init__(self, places: int, max_nodes: int, seconds: float) -> None:
        from pyeda.boolalg import bdd

        # A variable has the same number whatever net it is used for: later ones have larger numbers.
        self.roots: list[int] = [bdd.bddvar("p", number).node.root for number in range(places)]
        self.places = places
        self.zero: Node = bdd.BDDNODEZERO
        self.one: Node = bdd.BDDNODEONE
        self.level = {root: number for number, root in enumerate(self.roots)}
        self.level |= {self.zero.root: places, self.one.root: places}
        self._made: Callable[[int, Node, Node], Node] = bdd._bddnode
        self.held, self.max_nodes, self.peak = bdd._NODES, max_nodes, 0
        self.seconds, self.begun = seconds, time.process_time()
        self._results = 0
        self._known: dict[tuple[Any, ...], Node] = {}
        self._moved: defaultdict[tuple[Asked, ...], dict[Node, Node]] = defaultdict(dict)
        self.forgetting = [self._known.clear, self._moved.clear]

    def made(self, level: int, lo: Node, hi: Node) -> Node:
        """The node of a level; every so many times, the limits are looked at.

        Raises:
            LimitError: pyeda holds more nodes than allowed, or the time is over.
        """
        self._results += 1
        if self._results % CHECKED == 0:
            self.check()
        return self._made(self.roots[level], lo, hi)

    def check(self) -> None:
        """Looks at the limits, and forgets results of operators where there are many.

        Raises:
            LimitError: pyeda holds more nodes than allowed, or the time is over.
        """
        self.peak = max(self.peak, len(self.held))
        took = time.process_time() - self.begun
        if len(self.held) > self.max_nodes or self._results > MAX_RESULTS:
            self._results = 0
            for forget in self.forgetting:
                forget()
        over = f"pyeda holds {len(self.held)} nodes after {took:.0f} s of CPU time"
        if len(self.held) > self.max_nodes:
            raise LimitError(f"{over}: the limit is {self.max_nodes} nodes")
        if took > self.seconds:
            raise LimitError(f"{over}: the limit is {self.seconds:g} s")

    def parts(self, f: Node, level: int) -> tuple[Node, Node]:
        """The markings of a set without and with a token in the place of a level, which is not below it."""
        return (f.lo, f.hi) if self.level[f.root] == level else (f, f)

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
            level = min(self.level[f.root], self.level[g.root])
            f_lo, f_hi = self.parts(f, level)
            g_lo, g_hi = self.parts(g, level)
            found = self.made(level, operator(f_lo, g_lo), operator(f_hi, g_hi))
            self._known[name, f, g] = found
        return found

    def moved(self, f: Node, asked: tuple[Asked, ...]) -> Node:
        """The markings of a set that are as asked, with the tokens moved.

        Args:
            f: The set.
            asked: Of some levels, in ascending order.
        """
        if not asked or f is self.zero:
            return f
        if _clashing(asked):
            return self.zero
        known = self._moved[asked]
        (level, before, after), *below = asked
        rest = tuple(below)

        def walk(f: Node) -> Node:
            if f is self.zero or (found := known.get(f)) is not None:
                return f if f is self.zero else found
            own = self.level[f.root]
            if own < level:
                found = self.made(own, walk(f.lo), walk(f.hi))
            else:
                kept = self.moved(self.parts(f, level)[before], rest)
                found = self.made(level, *((self.zero, kept) if after else (kept, self.zero)))
            known[f] = found
            return found

        return walk(f)

    def nodes(self, f: Node) -> set[Node]:
        """The nodes of a diagram, without its two ends."""
        found, open_ = {self.zero, self.one}, [f]
        while open_:
            if (node := open_.pop()) not in found:
                found.add(node)
                open_ += (node.lo, node.hi)
        return found - {self.zero, self.one}

    def some(self, f: Node) -> set[int]:
        """The levels that one marking of a set marks."""
        marked = set[int]()
        while f is not self.one:
            marked |= {self.level[f.root]} if f.lo is self.zero else set()
            f = f.hi if f.lo is self.zero else f.lo
        return marked

    def folded(
        self,
        f: Node,
        empty: int,
        skipped: Callable[[int, int], int],
        joined: Callable[[int | None, int | None], int],
    ) -> Callable[[Node, int], int | None]:
        """A number of each set that is below a set of markings, made from the last place to the first.

        Args:
            f: The set.
            empty: The number where no place is left.
            skipped: The number over more places than these, any of which may be marked, from the number and
                how many more they are.
            joined: The number over one place more, from those without and with a token in it, of which one
                may be ``None``: there is no such marking.

        Returns:
            From a node of the diagram and a level not below it, the number of what the places from this level
            on are like there; ``None`` where there is no such marking.
        """
        known: dict[Node, int | None] = {self.zero: None, self.one: empty}

        def over(node: Node, first: int) -> int | None:
            number = known[node]
            return None if number is None else skipped(number, self.level[node.root] - first)

        for node in sorted(self.nodes(f), key=lambda node: self.level[node.root], reverse=True):
            below = self.level[node.root] + 1
            known[node] = joined(over(node.lo, below), over(node.hi, below))
        return over


def _clashing(asked: Sequence[Asked]) -> bool:
    """Whether one place is asked to be marked, and to be free: its transition reads what it would put."""
    return any(one[0] == other[0] for one, other in pairwise(asked))


class _Saturated:
    """Closes sets of markings under transitions that nothing overtakes.

    Args:
        sets: What the sets are made of.
        moving: What each transition asks and moves.
    """

    def __init__(self, sets: _Diagrams, moving: Iterable[tuple[Asked, ...]]) -> None:
        self.sets = sets
        self.top: defaultdict[int, list[tuple[Asked, ...]]] = defaultdict(list)
        for asked in moving:
            if any(before != after for _, before, after in asked) and not _clashing(asked):
                self.top[asked[0][0]].append(asked)
        self.next = _following(self.top, sets.places)
        self._known: dict[tuple[Node, int], Node] = {}
        sets.forgetting.append(self._known.clear)

    def closed(self, f: Node, level: int = 0) -> Node:
        """The closure of a set under the transitions that touch no place above a level.

        What a transition makes of a part is closed under all transitions below before it is joined, so that
        each set that others grow from is as whole as it can be.
        """
        sets = self.sets
        level = min(self.next[level], sets.level[f.root])
        if f is sets.zero or self.next[level] == sets.places:
            return f
        if (found := self._known.get((f, level))) is not None:
            return found
        parts = [self.closed(part, level + 1) for part in sets.parts(f, level)]
        own = self.top.get(level, ())
        taken, changed = [sets.zero for _ in own], bool(own)
        while changed:
            changed = False
            for number, asked in enumerate(own):
                _, before, after = asked[0]
                fresh, taken[number] = sets.difference(parts[before], taken[number]), parts[before]
                made = self.closed(sets.moved(fresh, asked[1:]), level + 1)
                more = sets.union(parts[after], made)
                changed |= more is not parts[after]
                parts[after] = more
        found = sets.made(level, *parts)
        self._known[f, level] = self._known[found, level] = found
        return found


class _Guards:
    """Says of sets of markings which transitions they enable, and takes out the markings that do.

    All transitions are asked in one walk of the nodes, which takes along those whose places were marked so
    far.

    Args:
        sets: What the sets are made of.
        guards: By transition, the levels that must be marked, in ascending order.
    """

    def __init__(self, sets: _Diagrams, guards: dict[int, Sequence[int]]) -> None:
        self.sets = sets
        self.always = frozenset(t for t, levels in guards.items() if not levels)
        # What waits for a level is a number; behind it comes the next such number, or ~t where t is enabled.
        self.starts: defaultdict[int, list[int]] = defaultdict(list)
        self.waits: list[int] = []
        self.behind: list[int] = []
        for t, levels in guards.items():
            if levels:
                first = len(self.waits)
                self.waits += levels[1:]
                self.behind += [*range(first + 1, len(self.waits)), ~t][: len(levels) - 1]
                self.starts[levels[0]].append(first if len(levels) > 1 else ~t)
        self.next = _following(self.starts, sets.places)
        self._known: dict[tuple[Node, int, frozenset[int]], tuple[Node, frozenset[int]]] = {}
        sets.forgetting.append(self._known.clear)

    def apart(self, f: Node) -> tuple[Node, frozenset[int]]:
        """The markings of a set that enable no transition, and the transitions that others enable."""
        if self.always and f is not self.sets.zero:
            return self.sets.zero, self.always | self._walk(f, 0, frozenset())[1]
        return self._walk(f, 0, frozenset())

    def _walk(self, f: Node, level: int, waiting: frozenset[int]) -> tuple[Node, frozenset[int]]:
        sets, waits = self.sets, self.waits
        if f is sets.zero:
            return f, frozenset()
        level = min(sets.level[f.root], self.next[level], *(waits[w] for w in waiting))
        if level == sets.places:
            return f, frozenset()
        if (found := self._known.get((f, level, waiting))) is not None:
            return found
        here = [w for w in waiting if waits[w] == level]
        on = [*(self.behind[w] for w in here), *self.starts.get(level, ())]
        others = waiting.difference(here)
        lo, hi = sets.parts(f, level)
        without, enabled = self._walk(lo, level + 1, others)
        with_, more = self._walk(hi, level + 1, others.union(w for w in on if w >= 0))
        fired = frozenset(~w for w in on if w < 0)
        if fired and hi is not sets.zero:
            with_, more = sets.zero, more | fired
        found = sets.made(level, without, with_), enabled | more
        self._known[f, level, waiting] = found
        return found


def _following(levels: Iterable[int], places: int) -> list[int]:
    """Of each level, the first of some levels that is not above it."""
    own, found = {*levels}, [places] * (places + 1)
    for level in range(places - 1, -1, -1):
        found[level] = level if level in own else found[level + 1]
    return found


class _Space:
    def __init__(self, net: PetriNet, max_nodes: int, seconds: float) -> None:
        self.net, self.sets = net, _Diagrams(len(net.places), max_nodes, seconds)
        self.order = clustered(net)
        self.level = {place: level for level, place in enumerate(self.order)}
        safe = net.safe_transitions
        self.enabling = [self._asked(read=(*t.consume, *t.read)) for t in safe]
        self.moving = [self._asked(t.read, t.consume, t.produce) for t in safe]
        # By rank, the most urgent first, the transitions that may fire in some marking.
        by_rank = defaultdict[int, list[int]](list)
        for t, rank in enumerate(net.ranks):
            if not safe[t].blocked:
                by_rank[rank if net.priorities else EVENTS].append(t)
        self.events = by_rank.pop(EVENTS, [])
        self.internal = [by_rank[rank] for rank in sorted(by_rank)]
        self.guards = [
            _Guards(self.sets, {t: [level for level, _, _ in self.enabling[t]] for t in own})
            for own in (*self.internal, self.events)
        ]
        first = self.internal[0] if self.internal else [] if net.priorities else self.events
        self.saturated = _Saturated(self.sets, (self.moving[t] for t in first))

    def _asked(
        self, read: Sequence[int] = (), consume: Sequence[int] = (), produce: Sequence[int] = ()
    ) -> tuple[Asked, ...]:
        ways = ((read, True, True), (consume, True, False), (produce, False, True))
        return tuple(sorted((self.level[p], before, after) for own, before, after in ways for p in own))

    def images(self, markings: Node, transitions: Iterable[int]) -> Node:
        """What firings of some transitions make of markings."""
        found = self.sets.zero
        for t in transitions:
            found = self.sets.union(found, self.sets.moved(markings, self.moving[t]))
        return found

    def settled(self, markings: Node) -> tuple[Node, Node]:
        """What internal transitions lead to from some markings, and what of it enables none of them.

        The most urgent ones are closed by saturation. Whatever a less urgent one makes begins there again.
        """
        sets = self.sets
        everything = stable = sets.zero
        waiting = {0: markings}  # by rank, markings in which nothing more urgent is enabled
        while waiting:
            rank = min(waiting)
            here = waiting.pop(rank)
            if rank == 0:
                here = sets.difference(self.saturated.closed(here), everything)
                everything = sets.union(everything, here)
            if rank == len(self.internal):
                stable = sets.union(stable, here)
                continue
            idle, enabled = self.guards[rank].apart(here)
            if rank > 0:
                new = sets.difference(self.images(here, sorted(enabled)), everything)
                if new is not sets.zero:
                    waiting[0] = new
            if idle is not sets.zero:
                waiting[rank + 1] = sets.union(waiting.get(rank + 1, sets.zero), idle)
        return everything, stable

    def reach(self) -> Node:
        """All reachable markings.

        Markings that settle stay out of the sets that grow: their diagrams are large on the way. Events of
        one element after the other fire as often as they make something new, those of resources
        last; what is on the way behind all events is put together at the end.
        """
        sets = self.sets
        initial = sets.one
        for level in range(sets.places - 1, -1, -1):
            marked = self.net.initial[self.order[level]]
            initial = sets.made(level, *((sets.zero, initial) if marked else (initial, sets.zero)))
        everything, stable = self.settled(initial)
        if not self.net.priorities:
            return everything
        by_element = defaultdict[Any, list[int]](list)
        for t in self.events:
            by_element[self.net.transitions[t].provenance].append(t)
        elements = [
            by_element[e]
            for e in sorted(
                by_element, key=lambda element: element is not None and element.part == "resource"
            )
        ]
        taken = [sets.zero for _ in elements]
        changed = True
        while changed:
            changed = False
            for number, events in enumerate(elements):
                while (new := sets.difference(stable, taken[number])) is not sets.zero:
                    taken[number] = stable
                    stable = sets.union(stable, self.settled(self.images(new, events))[1])
                    if stable is taken[number]:
                        break
                    changed = True
        for events in elements:
            everything = sets.union(everything, self.settled(self.images(stable, events))[0])
        return everything

    def by_urgency(self, markings: Node) -> Iterator[tuple[Sequence[int], Node]]:
        """Ranks of transitions with the markings that enable nothing more urgent; what is left comes last."""
        for own, guards in zip((*self.internal, self.events), self.guards, strict=True):
            yield own, markings
            markings, _ = guards.apart(markings)
        yield (), markings

    def firings(self, markings: Node, transitions: Sequence[int]) -> int:
        """How often some transitions fire in some markings, each of which they may fire in.

        Raises:
            UnsafeError: A firing would put a second token in a place.
        """
        sets, total = self.sets, 0
        below = self.counting(markings)
        first = {t: self.moving[t][0][0] if self.moving[t] else 0 for t in transitions}
        crossing = self.crossing(markings, {*first.values()})

        def counted(node: Node, asked: Sequence[Asked], level: int, known: dict[Any, int]) -> int:
            """How many markings of the places from a level on are as asked."""
            if not asked or node is sets.zero:
                return below(node, level) or 0
            if (found := known.get((node, len(asked), level))) is None:
                at, before, _ = asked[0]
                here = min(at, sets.level[node.root])
                parts = sets.parts(node, here)
                if here == at:
                    found = counted(parts[before], asked[1:], here + 1, known)
                else:
                    found = counted(parts[0], asked, here + 1, known)
                    found += counted(parts[1], asked, here + 1, known)
                found <<= here - level
                known[node, len(asked), level] = found
            return found

        def possible(t: int, asked: Sequence[Asked]) -> int:
            known: dict[Any, int] = {}
            if _clashing(asked):
                return 0
            here = crossing[first[t]].items()
            return sum(ways * counted(node, asked, first[t], known) for node, ways in here)

        for t in transitions:
            enabled, safe = possible(t, self.enabling[t]), possible(t, self.moving[t])
            if safe < enabled or (enabled and self.net.safe_transitions[t].overflow):
                raise self.unsafe(markings, t)
            total += enabled
        return total

    def crossing(self, markings: Node, levels: set[int]) -> dict[int, dict[Node, int]]:
        """By level, the nodes that what is marked above it leads to, each with in how many ways."""
        sets, found = self.sets, dict[int, dict[Node, int]]()
        here = {markings: 1}
        for level in range(sets.places + 1):
            if level in levels:
                found[level] = here
            then = defaultdict[Node, int](int)
            for node, ways in here.items():
                for part in sets.parts(node, level):
                    if part is not sets.zero:
                        then[part] += ways
            here = then
        return found

    def unsafe(self, markings: Node, t: int) -> UnsafeError:
        """The error of a transition that puts a second token in a place in one of some markings."""
        sets, safe = self.sets, self.net.safe_transitions[t]
        enabled = sets.moved(markings, self.enabling[t])
        free = self._asked(produce=safe.produce)
        unmoved = tuple((level, False, False) for level, _, _ in free)
        doubled = sets.difference(enabled, sets.moved(enabled, unmoved))
        marked = sets.some(enabled if safe.overflow else doubled)
        place = next(
            p for p in (*safe.overflow, *safe.produce) if p in safe.overflow or self.level[p] in marked
        )
        names = [p.name for n, p in enumerate(self.net.places) if self.level[n] in marked]
        return UnsafeError(self.net.places[place].name, self.net.transitions[t].name, names, [])

    def counting(self, markings: Node) -> Callable[[Node, int], int | None]:
        """Counts what places from a level on are like behind a node of a set."""
        return self.sets.folded(markings, 1, int.__lshift__, lambda lo, hi: (lo or 0) + (hi or 0))

    def count(self, markings: Node) -> int:
        """How many markings."""
        return self.counting(markings)(markings, 0) or 0

    def largest(self, markings: Node) -> int:
        """Most tokens in one marking."""
        return self.sets.folded(markings, 0, int.__add__, _most)(markings, 0) or 0


def _most(without: int | None, marked: int | None) -> int:
    return max(tokens for tokens in (without, None if marked is None else marked + 1) if tokens is not None)


@contextmanager
def _deep(levels: int) -> Iterator[None]:
    """Lets functions recur as deep as a diagram has levels."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, before + 6 * levels))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def count(net: PetriNet, max_nodes: int = MAX_NODES, seconds: float = MAX_SECONDS) -> ReferenceCounts:
    """Counts the reachable markings of a 1-safe net.

    Args:
        net: The net.
        max_nodes: How many nodes pyeda may hold.
        seconds: How much CPU time it may take.

    Returns:
        Exact counts.

    Raises:
        UnsafeError: The net is not 1-safe (no run is given).
        LimitError: pyeda holds more nodes than allowed, or the time is over.
    """
    for place in net.places:
        if place.initial > 1:
            raise UnsafeError(place.name, "", net.marked(net.initial), [])
    with _deep(len(net.places)):
        space = _Space(net, max_nodes, seconds)
        reachable = space.reach()
        by_rank = [*space.by_urgency(reachable)]
        edges = sum(space.firings(by_urgency, transitions) for transitions, by_urgency in by_rank)
        *_, (_, stable), (_, dead) = by_rank
        space.sets.check()
        return ReferenceCounts(
            states=space.count(reachable),
            edges=edges,
            stable_states=space.count(stable) if net.priorities else None,
            dead_states=space.count(dead),
            max_tokens=space.largest(reachable),
            nodes=len(space.sets.nodes(reachable)),
            peak_nodes=space.sets.peak,
        )
