"""The symbolic proof that internal evolution is confluent, without exploring its interleavings.

The direct way follows one interleaving. That is sound where in every reachable marking, transient ones
included, any two enabled internal transitions commute: firing one leaves the other enabled, or both give the
same marking. Then every internal run from a marking that ends has the same length and the same end (*random
descent*, Newman 1942; van Oostrom 2007), so that the end of the one run that is followed proves termination
of them all.

Transitions whose arcs cannot conflict are passed over; for each other pair, one query on the diagram of
reachable markings asks whether any of them enables both. Pairs that some marking does enable are joined
(:mod:`mcpn.space.stable.joining`): where both ways always lead to the same marking again, that proves the
same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mcpn._kernel import Zdd
from mcpn.errors import LimitError, SemanticsError
from mcpn.net.petri import PetriNet
from mcpn.space.diagrams.encoding import Encoding, distinct
from mcpn.space.diagrams.spaces import DiagramMarkings
from mcpn.space.diagrams.symbolic import SymbolicSpace, reach
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.markings.firing import mask_of
from mcpn.space.stable.joining import EndlessRun, Joining, Parting, open_pairs, parting_among
from mcpn.space.stable.nearest import nearest_fault
from mcpn.space.stable.settling import DEFAULT_MAX_STATES, PROOF_BY_MARKINGS, confluence_error, judged
from mcpn.steps import step

PROOF_OF_ENDS = "symbolic: internal transitions conflict in no reachable marking; each leads to a stable one"
PROOF_BY_JOINING = (
    "symbolic: wherever internal transitions conflict, both ways lead to the same marking again"
)
PROOF = "symbolic: in no reachable marking do internal transitions conflict; each run followed has ended"


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
        pairs = open_pairs(net, encoding.transitions)
    found: list[tuple[tuple[int, int], int]] = []
    for first, second in pairs:
        one, other = net.safe_transitions[first], net.safe_transitions[second]
        condition = encoding.condition((*one.consume, *one.read, *other.consume, *other.read))
        if condition is not None:
            found.append(((first, second), condition))
    markings = space.reachable if among is None else among
    while (at := markings.first([condition for _, condition in found])) >= 0:
        yield found[at][0]
        del found[: at + 1]


def proof_by_diagram(net: PetriNet) -> str | None:
    """Proves on a diagram of all markings that internal evolution is confluent.

    Args:
        net: A net with priorities.

    Returns:
        The proof in words: it says so of evolution that ends where runs are followed. ``None`` where the
        diagram does not fit, or internal evolution may have no end.

    Raises:
        ConfluenceError: Two runs behind one event end in different stable markings.
        UnsafeError: The net is not 1-safe.
    """
    step("proving confluence on a diagram of all markings")
    try:
        space = reach(net)
    except LimitError:  # no diagram within memory: marking by marking may still do
        return None
    return PROOF if next(open_conflicts(space), None) is None else proof_by_joining(space)


def prove_confluent(
    net: PetriNet, *, max_states: int = DEFAULT_MAX_STATES, space: SymbolicSpace | None = None
) -> str:
    """Proves that internal evolution of a net is confluent and ends, without building its graph if it can.

    Args:
        net: A net with priorities.
        max_states: How many stable states there may be, where it must be decided marking by marking.
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
    proof = proof_by_joining(space)
    if proof is None:
        judged(KernelNet(net), max_states)
        return PROOF_BY_MARKINGS
    return proof


def proof_by_joining(space: SymbolicSpace) -> str | None:
    """Proves that conflicts between internal transitions do not decide the outcome, where that is so.

    Args:
        space: The reachable markings of a net with priorities.

    Returns:
        The proof in words; ``None`` where internal evolution may have no end.

    Raises:
        ConfluenceError: Two runs behind one event end in different stable markings.
    """
    net = space.encoding.net
    if space.endless:
        return None
    assert space.stable is not None, "asked of nets with priorities"
    encoding, conflicts = space.encoding, list(open_conflicts(space))
    events = [e for t, e in encoding.events.items() if not net.transitions[t].internal]
    begun = encoding.initial() | space.stable.images(distinct(events))
    try:
        found = parting_among(encoding, begun, conflicts)
    except EndlessRun:
        return None
    if found is not None:
        raise nearest_fault(net) or _error_at(space, *found)
    return PROOF_BY_JOINING


def endless_runs(encoding: Encoding, markings: Zdd) -> Zdd:
    """The markings of a set from which some internal run through it goes on for ever: a greatest fixpoint."""
    left, before = markings, None
    while left != before:
        before = left
        left = left.images(encoding.internal_back, within=left)
    return left


def _error_at(space: SymbolicSpace, marking: tuple[int, ...], parting: Parting) -> SemanticsError:
    """The error for runs that part in a marking."""
    net = space.encoding.net
    markings = DiagramMarkings(space)
    begin = markings.initial.pick()
    assert begin is not None, "there is an initial marking"
    run = markings.run(begin, space.encoding.set_of(marking))
    assert run is not None, "the marking is reachable"
    before = [edge.transition for edge in run]
    before, _, parting = Joining(net).deciding(before, mask_of(marking), parting)
    runs = [[*before, *way] for way in (parting.first, parting.second)]
    return confluence_error(net, [[net.transitions[t].name for t in run] for run in runs])
