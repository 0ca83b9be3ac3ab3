"""The markings of a set, of whatever space."""

from __future__ import annotations

from typing import Any

from mcpn.nets.petri import Marking
from mcpn.spaces.algebra import Space


def members(space: Space[Any], states: Any) -> set[Marking]:
    """The markings of a set, picked one after the other."""
    found = set()
    while states:
        state = states.pick()
        found.add(space.marking(state))
        states = states - space.single(state)
    return found
