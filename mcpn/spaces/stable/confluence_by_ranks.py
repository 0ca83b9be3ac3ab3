"""Confluence rank by rank: conflicts between internal transitions that some marking leaves open.

A transition of rank *k* fires where none of a lower rank is enabled; what it enables of lower ranks follows
before another of rank *k* may fire. Both together are one step. Two such steps commute where

1. their first transitions do;
2. nothing of a lower rank that one brings about is in conflict with the first transition of the other;
3. what follows of lower ranks after both first transitions is without conflict, in whatever order it fires.

So conflicts of rank *k* are asked for in the markings that rank *k* may come to, and those of lower ranks
also in all markings behind two firings of rank *k*, priorities between the lower ranks aside: what follows
after one need not be what its ranks let fire first after both (``papers/mcpn.md``, Proposition 2). Where all
internal transitions have one rank, this asks whether some reachable marking enables both of a pair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from mcpn._kernel import Zdd
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import conflicts
from mcpn.spaces.diagrams.encoding import Encoding, distinct
from mcpn.spaces.diagrams.internal_evolution import behind, passing

Pair = tuple[int, int]
"""Two internal transitions, the first of no higher rank than the second."""


def open_pairs(net: PetriNet, transitions: Iterable[int] | None = None) -> Iterator[Pair]:
    """Pairs of internal transitions that may be in conflict and do not give the same marking."""
    among = range(len(net.transitions)) if transitions is None else transitions
    for t, u in conflicts(net, [t for t in among if net.transitions[t].internal]):
        if not harmless(net, t, u):
            yield (t, u) if net.ranks[t] <= net.ranks[u] else (u, t)


def harmless(net: PetriNet, first: int, second: int) -> bool:
    """Whether firing either of two transitions, each enabled, gives the same marking."""
    one, other = net.safe_transitions[first], net.safe_transitions[second]
    return set(one.consume) == set(other.consume) and set(one.produce) == set(other.produce)


def open_conflicts(encoding: Encoding, markings: Zdd) -> Iterator[Pair]:
    """Pairs of internal transitions in conflict that leave it open whether steps commute.

    Args:
        encoding: A net with priorities on the levels of a store.
        markings: Its reachable markings, or some from which internal evolution does not lead out.

    Yields:
        Pairs; where there is none, every internal run from one of the markings that ends has the same end
        and the same length.
    """
    net, ranks = encoding.net, encoding.net.internal_ranks
    rank_of = {t: rank for rank, transitions in enumerate(ranks) for t in transitions}
    by_rank: list[dict[int, list[Pair]]] = [{} for _ in ranks]
    for pair in open_pairs(net, encoding.transitions):
        by_rank[rank_of[pair[1]]].setdefault(rank_of[pair[0]], []).append(pair)
    allowed, yielded = passing(encoding, markings), set[Pair]()
    below: list[Pair] = []  # pairs of ranks below the present one
    for rank, events in enumerate(encoding.internal_ranks):
        for lower, pairs in by_rank[rank].items():
            for pair in _both_covered(encoding, allowed[lower], pairs):
                if lower == rank or _meet(encoding, allowed[rank], rank, *pair):
                    yielded.add(pair)
                    yield pair
        twice = allowed[rank].images(events).images(events) if below else encoding.store.empty()
        if twice:
            behind_both = twice.saturate([*chain.from_iterable(encoding.internal_ranks[:rank])])
            yield from (pair for pair in _both_covered(encoding, behind_both, below) if pair not in yielded)
        below += [pair for pairs in by_rank[rank].values() for pair in pairs]


def _both_covered(encoding: Encoding, markings: Zdd, pairs: Iterable[Pair]) -> Iterator[Pair]:
    """The pairs of which some marking has the tokens for both."""
    conditions = [(pair, c) for pair in pairs if (c := _covering(encoding, *pair)) is not None]
    while (at := markings.first([condition for _, condition in conditions])) >= 0:
        yield conditions[at][0]
        del conditions[: at + 1]


def _covering(encoding: Encoding, *transitions: int) -> int | None:
    """The condition that a marking has the tokens that transitions need."""
    safe = encoding.net.safe_transitions
    return encoding.condition([p for t in transitions for p in (*safe[t].consume, *safe[t].read)])


def _meet(encoding: Encoding, allowed: Zdd, rank: int, lower: int, second: int) -> bool:
    """Whether firing another transition of the second one's rank may lead to where both have their tokens."""
    alone, both = _covering(encoding, second), _covering(encoding, lower, second)
    assert alone is not None, "some marking covers it"
    assert both is not None, "some marking covers both"
    others = distinct(
        event
        for t in encoding.net.internal_ranks[rank]
        if t != second and (event := encoding.events.get(t)) is not None
    )
    begun = (allowed - allowed.without([alone])).images(others)
    return behind(encoding, begun, ranks=rank)[0].first([both]) >= 0
