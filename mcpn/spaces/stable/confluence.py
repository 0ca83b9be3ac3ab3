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
from mcpn.errors import SemanticsError
from mcpn.nets.petri import Marking, PetriNet
from mcpn.nets.structure import conflicts
from mcpn.spaces.diagrams.encoding import Encoding, behind, distinct, passing
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.completion import MOST_ENDS, fault_after, settled
from mcpn.spaces.stable.falsification import nearest_fault

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


# --- Internal evolution marking by marking, where markings that evolve alike are explored once ------------
#
# What may fire behind a marking depends on few of its places: those of the transitions that have their tokens
# there or may get them, whoever takes them before; and for each other transition one place without which it
# can never fire. Markings that agree on these places evolve alike, whatever the rest of the net is doing. So
# a set of markings as large as a diagram can hold is decided by exploring one marking of each pattern.


def without_one_end(encoding: Encoding, begun: Zdd) -> Marking | None:
    """Looks among markings for one from which internal evolution has not one stable end.

    Args:
        encoding: A net with priorities on the levels of a store.
        begun: Markings in which internal evolution begins.

    Returns:
        A marking from which there are several stable ends, a run without end, or an unsafe firing; ``None``
        where each has one end. Takes one exploration for each pattern.

    Raises:
        LimitError: There is too much to explore behind one marking.
    """
    patterns, internal = _Patterns(encoding.net), KernelNet(encoding.net, events=False)
    left = begun
    while (levels := left.pick()) is not None:
        marking = encoding.marking(levels)
        if settled(internal, marking, orders="every", max_states=MOST_ENDS).trouble is not None:
            return marking
        left -= encoding.restricted(left, *patterns.of(marking))
    return None


class _Patterns:
    """What internal evolution depends on, marking by marking.

    Args:
        net: A 1-safe net with priorities.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        internal = (t for t, made in enumerate(net.transitions) if made.internal)
        safe = net.safe_transitions
        self.internal = [t for t in internal if not safe[t].blocked]
        needs = {t: (*safe[t].consume, *safe[t].read) for t in self.internal}
        self.users: dict[int, list[int]] = {}
        for t, places in needs.items():
            for p in places:
                self.users.setdefault(p, []).append(t)
        self.counts = {t: len(places) for t, places in needs.items()}
        # Those first that most transitions need: one of them, unmarked, keeps many from firing.
        self.needs = {
            t: sorted(places, key=lambda p: (len(self.users[p]), p), reverse=True)
            for t, places in needs.items()
        }

    def of(self, marking: Marking) -> tuple[list[int], list[int]]:
        """Places that are marked, and that are not, in all markings that evolve as this one does."""
        within, firing = self._may_be_marked(marking)
        relevant = {p for t in firing for p in self.needs[t]}
        # One unmarked place for each transition that can never fire: none that needs this place can.
        for t, places in self.needs.items():
            if t not in firing:
                relevant.add(next(p for p in places if p not in within))
        return [p for p in sorted(relevant) if marking[p]], [p for p in sorted(relevant) if not marking[p]]

    def _may_be_marked(self, marking: Marking) -> tuple[set[int], set[int]]:
        """Places that may get tokens, and transitions that may fire, if firings took none: both supersets."""
        within = {p for p, tokens in enumerate(marking) if tokens}
        missing = dict(self.counts)
        for p in within:
            for user in self.users.get(p, ()):
                missing[user] -= 1
        firing, queue = set[int](), [t for t, count in missing.items() if not count]
        for t in queue:  # grows while it is walked
            firing.add(t)
            for p in self._new(t, within):
                within.add(p)
                for user in self.users.get(p, ()):
                    missing[user] -= 1
                    if not missing[user]:
                        queue.append(user)
        return within, firing

    def _new(self, transition: int, within: set[int]) -> Iterator[int]:
        return (p for p in self.net.safe_transitions[transition].produce if p not in within)


# --- The symbolic proof that internal evolution is confluent, without exploring its interleavings ---------
#
# To follow one interleaving is sound where in every reachable marking, transient ones included, any two
# enabled internal transitions commute: firing one leaves the other enabled, or both give the same marking.
# Then all internal runs from a marking that ends have the same length and the same end (*random descent*,
# Newman 1942; van Oostrom 2007), so that termination of the one run that is followed proves termination of
# all of them. Where transitions have several ranks, the steps that must commute have ranks, too.
#
# Pairs of transitions whose arcs cannot conflict need no query. For each other pair, queries on the diagram
# of reachable markings decide whether it commutes everywhere (:mod:`mcpn.spaces.stable.confluence`). Pairs
# that need not commute are judged by exploring what is behind them (:mod:`mcpn.spaces.stable.confluence`).

PROOF_OF_ENDS = "symbolic: internal transitions conflict in no reachable marking; each leads to a stable one"
PROOF_BY_PATTERNS = (
    "symbolic: behind each event every interleaving explored, once for markings that evolve alike"
)


def prove_confluent(net: PetriNet, space: SymbolicSpace | None = None) -> str:
    """Proves that internal evolution of a net is confluent and ends, without building its graph if it can.

    Args:
        net: A net with priorities.
        space: Its reachable markings, where they are known.

    Returns:
        The proof used, in words.

    Raises:
        ConfluenceError: It is not confluent.
        DivergenceError: It need not end.
        UnsafeError: The net is not 1-safe.
        LimitError: A limit was hit.

    See Also:
        :func:`mcpn.spaces.stable.alternatives.direct_with_proof`: the proof along the list of stable states.
        :func:`proof_of_conflicts`: what it says of a set of markings.
    """
    space = space or reach(net)
    if not space.endless and next(open_conflicts(space.encoding, space.reachable), None) is None:
        return PROOF_OF_ENDS
    proof_of_conflicts(space)
    return PROOF_BY_PATTERNS


def proof_of_conflicts(space: SymbolicSpace) -> None:
    """Proves that conflicts between internal transitions do not decide the outcome, and that all runs end.

    Args:
        space: The reachable markings of a net with priorities.

    Raises:
        ConfluenceError: Two runs behind one event end in different stable markings.
        DivergenceError: An internal run need not end.
        LimitError: There is too much to explore behind one marking.
    """
    net = space.encoding.net
    assert space.stable is not None, "asked of nets with priorities"
    encoding = space.encoding
    events = [e for t, e in encoding.events.items() if not net.transitions[t].internal]
    marking = without_one_end(encoding, encoding.initial() | space.stable.images(distinct(events)))
    if marking is not None:
        raise nearest_fault(net) or _error_behind(space, marking)


def _error_behind(space: SymbolicSpace, marking: Marking) -> SemanticsError:
    """The error for a marking, just after an event, from which internal evolution has not one end."""
    net = space.encoding.net
    fired = [t for t in _run_to(space, marking) if not net.transitions[t].internal]
    error = fault_after(net, fired)
    assert error is not None, "the marking is reached by these events"
    return error


def _run_to(space: SymbolicSpace, marking: Marking) -> list[int]:
    markings = DiagramMarkings(space)
    begin = markings.initial.pick()
    assert begin is not None, "there is an initial marking"
    run = markings.run(begin, space.encoding.set_of(marking))
    assert run is not None, "the marking is reachable"
    return [edge.transition for edge in run]
