"""Decides by sets, without interleavings, whether the order at equal priority matters: confluence.

To follow one interleaving is sound where in every reachable marking, transient ones included, any two
enabled internal transitions commute: firing one leaves the other enabled, or both give the same marking.
Then all internal runs from a marking that ends have the same length and the same end (*random descent*,
Newman 1942; van Oostrom 2007), so that termination of the one run that is followed proves termination of
all of them. Where transitions have several ranks, the steps that must commute have ranks, too.

Pairs of transitions whose arcs cannot conflict need no query. For each other pair, queries on the diagram
of reachable markings decide whether it commutes everywhere (:mod:`mcpn.spaces.stable.confluence_by_ranks`).
Pairs that need not commute are judged by exploring what is behind them
(:mod:`mcpn.spaces.stable.representatives`).
"""

from __future__ import annotations

from mcpn.errors import SemanticsError
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.diagrams.encoding import distinct
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.stable.confluence_by_ranks import open_conflicts
from mcpn.spaces.stable.nearest_nonconfluence import nearest_fault
from mcpn.spaces.stable.representatives import without_one_end
from mcpn.spaces.stable.run_to_completion import fault_after

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
