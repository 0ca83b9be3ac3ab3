"""The symbolic proof that internal evolution is confluent, without exploring its interleavings.

The direct way follows one interleaving. That is sound where in every reachable marking, transient ones
included, any two enabled internal transitions commute: firing one leaves the other enabled, or both give the
same marking. Then every internal run from a marking that ends has the same length and the same end (*random
descent*, Newman 1942; van Oostrom 2007), so that the end of the one run that is followed proves termination
of them all.

Transitions whose arcs cannot conflict are passed over; for each other pair, one query on the diagram of
reachable markings asks whether any of them enables both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from mcpn._kernel import Zdd
from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.net.structure import conflicts
from mcpn.space.alternatives import DEFAULT_MAX_STATES, AlternativesGraph, direct
from mcpn.space.symbolic import SymbolicSpace, reach

PROOF_OF_ENDS = "symbolic: internal transitions conflict in no reachable marking; each leads to a stable one"
PROOF = "symbolic: in no reachable marking do internal transitions conflict; each run followed has ended"


def harmless(net: PetriNet, first: int, second: int) -> bool:
    """Whether firing either of two transitions, each enabled, gives the same marking."""
    one, other = net.safe_transitions[first], net.safe_transitions[second]
    return set(one.consume) == set(other.consume) and set(one.produce) == set(other.produce)


def open_conflicts(
    space: SymbolicSpace, among: Zdd | None = None, pairs: Iterable[tuple[int, int]] | None = None
) -> Iterator[tuple[int, int]]:
    """Pairs of internal transitions in conflict that some reachable marking enables both.

    Args:
        space: The reachable markings of a net with priorities.
        among: Those of them to look at; all by default.
        pairs: The pairs to ask for; all that conflict by default.

    Yields:
        Pairs whose results differ; where there is none, all enabled internal transitions commute.
    """
    encoding, net = space.encoding, space.encoding.net
    if pairs is None:
        pairs = conflicts(net, [t for t in encoding.transitions if net.transitions[t].internal])
    found: list[tuple[tuple[int, int], int]] = []
    for first, second in pairs:
        if harmless(net, first, second):
            continue
        one, other = net.safe_transitions[first], net.safe_transitions[second]
        condition = encoding.condition((*one.consume, *one.read, *other.consume, *other.read))
        if condition is not None:
            found.append(((first, second), condition))
    markings = space.reachable if among is None else among
    while (at := markings.first([condition for _, condition in found])) >= 0:
        yield found[at][0]
        del found[: at + 1]


def direct_with_proof(
    net: PetriNet,
    *,
    max_states: int = DEFAULT_MAX_STATES,
    progress: Callable[[int, int], None] | None = None,
) -> AlternativesGraph:
    """Builds the alternatives graph directly, with the cheaper proof where it holds.

    Args:
        net: A net with priorities.
        max_states: How many stable states it may have.
        progress: As for :func:`mcpn.space.alternatives.direct`.

    Returns:
        The graph, which says the proof used: the symbolic one, or else each transient marking explored once.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings.
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place.
        LimitError: More stable states than allowed.
    """
    try:
        space = reach(net)
    except LimitError:  # no diagram within memory: edge by edge may still do
        return direct(net, proof=True, max_states=max_states, progress=progress)
    if next(open_conflicts(space), None) is None:
        graph = direct(net, proof=False, max_states=max_states, progress=progress)
        return replace(graph, proof=PROOF)
    return direct(net, proof=True, max_states=max_states, progress=progress)


def prove_confluent(
    net: PetriNet, *, max_states: int = DEFAULT_MAX_STATES, space: SymbolicSpace | None = None
) -> str:
    """Proves that internal evolution of a net is confluent and ends, without building its graph if it can.

    Args:
        net: A net with priorities.
        max_states: How many stable states there may be, where it must be decided edge by edge.
        space: Its reachable markings, where they are known.

    Returns:
        The proof used, in words.

    Raises:
        ConfluenceError: It is not confluent.
        DivergenceError: It need not end.
        UnsafeError: The net is not 1-safe.
        LimitError: A limit was hit.
    """
    space = space or reach(net)
    if not space.endless and next(open_conflicts(space), None) is None:
        return PROOF_OF_ENDS
    proof = direct(net, proof=True, max_states=max_states).proof
    assert proof is not None, "a proof was asked for"
    return proof
