"""Behaviour of a net: liveness, quasi-liveness, reversibility, home markings, over any space of its markings.

All of it follows from the *bottom components*: strongly connected sets of markings that no firing leaves.
From every marking some run ends in one of them. So a transition is live (L4) if it fires in each of them, a
home marking is one that lies in the only one, and the net is reversible if its initial marking lies there.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section IV.
"""

from __future__ import annotations

from dataclasses import dataclass

from mcpn.net.petri import PetriNet
from mcpn.net.structure import incidence
from mcpn.space.algebra import S, Space

EXAMINATIONS = ("ReachabilityDeadlock", "QuasiLiveness", "Liveness", "OneSafe", "StableMarking")
"""Names of the Model Checking Contest for properties that need no formula."""


@dataclass(frozen=True)
class Behaviour:
    """What a bounded net does.

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


def behaviour(space: Space[S]) -> Behaviour:
    """Decides the behavioural properties of a net.

    Args:
        space: Its reachable markings.

    Returns:
        The properties. One forward and one backward closure for each bottom component; a net with a deadlock
        needs no more of them than tell whether there is a second.
    """
    everything, transitions = space.everything, frozenset(range(len(space.net.transitions)))
    deadlock = bool(space.dead)
    live, home, components = frozenset() if deadlock else transitions, 0, 0
    left = everything
    while left:
        bottom = _bottom(space, left)
        components += 1
        home = bottom.count() if components == 1 else 0
        # In a component that is no deadlock every transition fires that is enabled somewhere in it.
        live = live.intersection(space.firings(bottom))
        if components > 1 and (deadlock or not live):
            break
        left = left - space.reaching(bottom)
    fired = quasi_live(space)
    reversible = components == 1 and not everything - space.reaching(space.initial)
    return Behaviour(deadlock, fired, live, reversible, home, _constant(space.net, fired))


def _bottom(space: Space[S], within: S) -> S:
    """A bottom component that some marking of a non-empty set leads to.

    From any marking forward; what it reaches and does not lead back is further down, so there it goes on.
    """
    while True:
        here = space.single(within.pick())
        ahead = space.reached(here)
        beyond = ahead - space.reaching(here, ahead)
        if not beyond:
            return ahead
        within = beyond


def quasi_live(space: Space[S]) -> frozenset[int]:
    """Transitions that fire somewhere."""
    return frozenset(t for t, count in space.firings(space.everything).items() if count)


def _constant(net: PetriNet, fired: frozenset[int]) -> frozenset[int]:
    """Places whose tokens no transition that fires changes."""
    rows = enumerate(incidence(net))
    return frozenset(place for place, changes in rows if fired.isdisjoint(changes))


def examine(examination: str, space: Space[S]) -> bool:
    """Answers an examination of the contest.

    Args:
        examination: One of :data:`EXAMINATIONS`, but ``OneSafe``, which needs no more than a 1-safe space.
        space: The net's reachable markings.
    """
    if examination == "ReachabilityDeadlock":
        return bool(space.dead)
    fired = quasi_live(space)
    if examination == "StableMarking":
        return bool(_constant(space.net, fired))
    transitions = frozenset(range(len(space.net.transitions)))
    if examination == "QuasiLiveness":
        return fired == transitions
    if space.dead or fired != transitions:
        return not transitions
    return behaviour(space).live == transitions
