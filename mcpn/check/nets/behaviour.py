"""Behaviour of a net, decided on diagrams: liveness, quasi-liveness, reversibility, home markings.

All of it follows from the *bottom components*: strongly connected sets of markings that no firing leaves.
From every marking some run ends in one of them. So a transition is live (L4) if it fires in each of them, a
home marking is one that lies in the only one, and the net is reversible if its initial marking lies there.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section IV.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcpn._kernel import Zdd
from mcpn.check.ctl import SymbolicMarkings
from mcpn.space.symbolic import SymbolicSpace

EXAMINATIONS = ("ReachabilityDeadlock", "QuasiLiveness", "Liveness", "OneSafe", "StableMarking")
"""Names of the Model Checking Contest for properties that need no formula."""


@dataclass(frozen=True)
class Behaviour:
    """What a 1-safe net does.

    Args:
        deadlock: Whether some reachable marking enables nothing.
        quasi_live: Transitions that fire somewhere, as indices.
        live: Transitions that, whatever has happened, can fire again (L4).
        reversible: Whether every reachable marking leads back to the initial one.
        home_markings: Number of markings that every reachable marking leads to.
        constant_places: Places whose marking never changes.
    """

    deadlock: bool
    quasi_live: frozenset[int]
    live: frozenset[int]
    reversible: bool
    home_markings: int
    constant_places: frozenset[int]


def behaviour(space: SymbolicSpace) -> Behaviour:
    """Decides the behavioural properties of a net.

    Args:
        space: Its reachable markings.

    Returns:
        The properties. One forward and one backward closure for each bottom component; a net with a deadlock
        needs no more of them than tell whether there is a second.
    """
    graph = SymbolicMarkings(space)
    transitions = frozenset(range(len(space.encoding.net.transitions)))
    deadlock = space.dead_states > 0
    live, home, components = transitions, 0, 0
    left = space.reachable
    while left:
        bottom = _bottom(graph, left)
        components += 1
        home = bottom.count() if components == 1 else 0
        # In a component that is no deadlock every transition fires that is enabled somewhere in it.
        live = live.intersection(t for t in live if graph.enabling([t]) & bottom)
        if components > 1 and (deadlock or not live):
            break
        left = left - graph.until(space.reachable, bottom)
    quasi_live = frozenset(t for t, count in space.fired.items() if count)
    reversible = components == 1 and graph.until(space.reachable, graph.initial) == space.reachable
    return Behaviour(deadlock, quasi_live, live, reversible, home, _constant(space))


def _bottom(graph: SymbolicMarkings, within: Zdd) -> Zdd:
    """A bottom component that some marking of a non-empty set leads to.

    From any marking forward; what it reaches and does not lead back is further down, so there it goes on.
    """
    encoding = graph.space.encoding
    while True:
        picked = within.pick()
        assert picked is not None, "the set is not empty"
        here = encoding.store.singleton(picked)
        ahead = graph.reached(here)
        beyond = ahead - graph.until(ahead, here)
        if not beyond:
            return ahead
        within = beyond


def _constant(space: SymbolicSpace) -> frozenset[int]:
    """Places that are marked in every reachable marking, or in none."""
    encoding, net = space.encoding, space.encoding.net
    found = set()
    for place, tokens in enumerate(net.initial):
        condition = encoding.condition([], [place]) if tokens else encoding.condition([place])
        if condition is None or space.reachable.first([condition]) < 0:
            found.add(place)
    return frozenset(found)


def examine(examination: str, space: SymbolicSpace) -> bool:
    """Answers an examination of the contest on a net that was found to be 1-safe.

    Args:
        examination: One of :data:`EXAMINATIONS`.
        space: The net's reachable markings.
    """
    if examination == "OneSafe":
        return True
    if examination == "ReachabilityDeadlock":
        return space.dead_states > 0
    if examination == "QuasiLiveness":
        return all(space.fired.values())
    if examination == "StableMarking":
        return bool(_constant(space))
    transitions = range(len(space.encoding.net.transitions))
    if space.dead_states > 0 or not all(space.fired.values()):
        return not transitions
    return behaviour(space).live == frozenset(transitions)
