"""Boundedness of nets whose places may hold many tokens.

Without priorities the coverability tree of Karp and Miller (*Parallel program schemata*, JCSS 1969) decides
boundedness. Walks take turns with it, for the tree may be far too large where a run that can be repeated is
near: they try to fire the numbers that a linear program proposes. With priorities boundedness is
undecidable in general (they can test for zero): then only a finite state space, or a run of internal
transitions that can be repeated for ever, decides it here.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import floor, inf, isinf, lcm
from typing import TYPE_CHECKING

from mcpn._kernel import CountedNet, Exploration, MemoryLimit, StateLimit
from mcpn.errors import LimitError, UnboundedError, UnsafeError
from mcpn.nets.petri import Arcs, PetriNet
from mcpn.nets.programs import minimise
from mcpn.nets.siphons import p_semiflows
from mcpn.nets.structure import changes, incidence, needs, place_bounds
from mcpn.spaces.markings.explicit import DEFAULT_MAX_MEMORY, MAX_MARKINGS, Counts, count, explore
from mcpn.steps import telling

if TYPE_CHECKING:
    from mcpn.spaces.markings.graph import Field, StateGraph

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


# --- Bit widths of the counters of tokens: from invariants, and widened where a counter overflows ---------
#
# No bound is believed. Whoever explores says which places a firing has put too many tokens in, and explores
# again with wider ones. Once they have grown, P-semiflows, the coverability tree and linear programs are
# asked whether there is an end to it.

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
            max(place.initial.bit_length(), first if isinf(bound) else int(bound).bit_length(), 1)
            for place, bound in zip(net.places, bounds, strict=True)
        ]
        """By place."""
        self._patience = 0 if net.priorities else TREE_NODES
        """Nodes of the next coverability tree; 0 once bounds are no longer asked for."""
        self._check()
        if asking and self._patience:
            self._ask([place for place, bound in enumerate(bounds) if isinf(bound)])

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
    return dict(enumerate(map(float, verdict.bounds)))


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


# Markings with several tokens in a place, explored one at a time, breadth first, priorities respected.
#
# The native kernel does the work: a marking is a row of words, each place a field of bits in it. Where a
# firing does not fit into a field, places are made wider and exploration begins anew
# (:mod:`mcpn.spaces.markings.counted`).

FIRST_BITS = 4
"""Width of a place of which no bound is known."""
MOST_BITS = 40
"""Sums of tokens stay within 64 bits."""
MOST_WEIGHT = 2**62
WORD = 64


@dataclass(frozen=True)
class TokenCounts(Counts):
    """Sizes of a markings graph whose places hold several tokens.

    Args:
        bounds: Most tokens by place.
    """

    bounds: tuple[int, ...]


def explore_markings(net: PetriNet, *, max_states: int = MAX_MARKINGS) -> StateGraph:
    """Builds the markings graph of a net, 1-safe or not.

    Args:
        net: The net; with priorities it must be 1-safe.
        max_states: How many states it may have.

    Raises:
        UnsafeError: The net has priorities and is not 1-safe.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit.
    """
    try:
        return explore(net, max_states=max_states)
    except UnsafeError:
        if net.priorities:
            raise
        return explore_tokens(net, max_states=max_states)


def count_markings(net: PetriNet, *, max_states: int = MAX_MARKINGS) -> Counts:
    """Counts what :func:`explore_markings` builds, without keeping the edges."""
    try:
        return count(net, max_states=max_states)
    except UnsafeError:
        if net.priorities:
            raise
        return count_tokens(net, max_states=max_states)


def explore_tokens(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> StateGraph:
    """Builds the markings graph of a net with as many tokens as there are, priorities respected.

    Args:
        net: The net.
        max_states: How many states it may have.
        max_memory: Bytes that the kernel's tables may take; the graph's own arrays come on top.

    Raises:
        UnboundedError: The net has no priorities and is unbounded.
        LimitError: A limit was hit.
    """
    from mcpn.spaces.markings.graph import StateGraph

    exploration, fields = _explored(net, True, max_states, max_memory)
    offsets, targets = exploration.take_offsets().astype("int64"), exploration.take_targets().astype("int64")
    labels = exploration.take_labels().astype("int64")
    return StateGraph(net, exploration.take_markings(), offsets, targets, labels, fields=tuple(fields))


def count_tokens(
    net: PetriNet,
    *,
    max_states: int = MAX_MARKINGS,
    max_memory: int = DEFAULT_MAX_MEMORY,
) -> TokenCounts:
    """Counts what :func:`explore_tokens` builds, without keeping the edges."""
    exploration, _ = _explored(net, False, max_states, max_memory)
    sizes = (
        exploration.states,
        exploration.edges,
        exploration.dead,
        exploration.stable,
        exploration.most_tokens,
    )
    return TokenCounts(*sizes, tuple(exploration.bounds))


def layout(widths: Sequence[int]) -> list[Field]:
    """Fields of some widths in words, none across two of them."""
    fields: list[Field] = []
    word, shift = 0, 0
    for width in widths:
        if shift + width > WORD:
            word, shift = word + 1, 0
        fields.append((word, shift, width))
        shift += width
    return fields


def _explored(
    net: PetriNet, edges: bool, max_states: int, max_memory: int
) -> tuple[Exploration, list[Field]]:
    widths = Widths(net, first=FIRST_BITS, most=MOST_BITS, asking=True)
    encoded = []
    for t, transition in enumerate(net.transitions):
        need, change = needs(net, t), changes(net, t)
        if max((*need.values(), *change.values()), default=0) > MOST_WEIGHT:
            raise LimitError(f"{transition.name} has a weight of more than {MOST_WEIGHT}: the limit was hit")
        encoded.append((list(need.items()), list(change.items()), net.ranks[t]))
    while True:
        fields = layout(widths.bits)
        kernel = CountedNet(fields, encoded, net.priorities)
        try:
            exploration = kernel.explore(net.initial, edges, max_states, max_memory, telling())
        except (StateLimit, MemoryLimit) as error:
            raise LimitError(str(error)) from error
        if exploration.trouble is None:
            return exploration, fields
        state, beyond, _ = exploration.trouble
        marking = net.initial
        for t in (*exploration.run(state), *beyond):
            marking = net.fire(marking, t)
        widths.widen([p for p, (_, _, width) in enumerate(fields) if marking[p] >> width])
