"""The stable marking after internal evolution, by the net's own rule."""

from __future__ import annotations

from collections.abc import Sequence

from mcpn.nets.petri import Marking, PetriNet


def stabilise(net: PetriNet, marking: Sequence[int]) -> Marking:
    """Fires internal transitions, the first enabled each time, until none is: the caller knows it ends."""
    at = tuple(marking)
    while (enabled := net.enabled(at)) and net.transitions[enabled[0]].internal:
        at = net.fire(at, enabled[0])
    return at
