"""A space of diagrams whose work is left off again and again."""

from __future__ import annotations

from collections.abc import Collection

from mcpn._kernel import Zdd
from mcpn.spaces.diagrams.spaces import DiagramMarkings


class _Spent(Exception):
    """Time is over."""


class ByTurns(DiagramMarkings):
    """Closures take turns from the first step on; of a greatest fixpoint each attempt takes one step.

    What stays in a set is found without layers of all transitions.
    """

    first_steps = 1
    steps_of_layers = 1
    attempted = 0

    def staying(
        self, along: Zdd, asked: Zdd | None = None, transitions: Collection[int] | None = None
    ) -> Zdd:
        while True:
            try:
                return super().staying(along, asked, transitions)
            except _Spent:
                continue

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        self.attempted += 1
        if self.attempted % 2:
            raise _Spent
        return super().continuing(states, transitions)
