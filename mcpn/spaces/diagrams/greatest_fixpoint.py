"""Maximal runs that stay in a set, on diagrams: by layers, and beside them by what fires on cycles.

This is EG: a greatest fixpoint. Layers drop the states without a successor in the set until none is left to
drop; where runs out of the set are long, layers are many. After some steps of the kernel another way takes
turns with them. A run that stays in the set comes to

- a dead state: one closure back finds what does;
- or a cycle. Of the states that remain, only transitions of a T-semiflow of those with edges there may fire
  on one (:mod:`mcpn.nets.structure`). Where there are none, there is no cycle. Where they are few, layers by
  the edges of these alone, which lead less far, reach the cycles, and a closure back to what leads there.
  Else this way is given up.

Where only some states are asked for, it looks at what runs from them come to alone: any cycle is an answer.

Measured on 161 such sets of nets of the Model Checking Contest that took over 0.1 s: the closure and the
semiflows alone decide 64 of them. Layers win where most transitions are on cycles; there to take turns costs
up to twice the time. Cycles of one semiflow after the other, components by closures from states that walks
come to, and removal transition by transition took longer on most sets.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from mcpn._kernel import BudgetExceeded, Zdd
from mcpn.nets.repeatable import repeatable
from mcpn.spaces.algebra import Space

SHARE = 4
"""Layers of some transitions alone are worth while where they are at most one in so many."""
FIRST_CHECK = 8
"""After how many layers what may fire on cycles is looked at again."""
LONGER = 2
"""By how many times both ways may take longer each time, and what may fire on cycles is looked at later."""


class Steps(Space[Zdd], Protocol):
    """A space of diagrams, with the steps of the kernel that it has taken."""

    steps: int
    steps_of_layers: int
    most_steps: int

    def continuing(self, states: Zdd, transitions: Collection[int] | None = None) -> Zdd:
        """Those of some states with an edge of some transitions that leads to one of them."""

    def firing(self, states: Zdd) -> frozenset[int]:
        """Transitions that fire on edges from some states, or more."""


class Staying:
    """States from which some maximal run stays in a set. What was broken off goes on where it was.

    Args:
        space: The space.
        along: The set.
        asked: Where given, it is enough to know whether some of these are among them.
    """

    def __init__(self, space: Steps, along: Zdd, asked: Zdd | None) -> None:
        self.space = space
        self.asked = asked
        self.rest = along
        self.steps = space.steps_of_layers
        self.cycles: _ByCycles | None = None

    def states(self) -> Zdd:
        """The states; where some are asked for, a set that meets these just where the exact one does."""
        while (result := self._by_layers()) is None:
            if self.cycles is None:
                self.cycles = _ByCycles(self.space, self.rest, self.asked)
            if (result := self.cycles.states(self.steps)) is not None:
                return result
            self.steps *= LONGER
        return result

    def _by_layers(self) -> Zdd | None:
        """Drops layers until the steps are spent; what is left where none is left to drop."""
        space, until = self.space, self.space.steps + self.steps
        while space.steps < until:
            kept = space.continuing(self.rest) | (self.rest & space.dead)
            if kept == self.rest or (self.asked is not None and not self.asked & kept):
                return kept
            self.rest = kept
        return None


class _ByCycles:
    """EG by the cycles that runs come to; given up where that has no advantage over layers."""

    def __init__(self, space: Steps, along: Zdd, asked: Zdd | None) -> None:
        self.space = space
        self.along = along
        self.asked = asked
        self.given_up = False
        self.to_dead = space.nothing  # states from which some run in the set ends in a dead one
        self.room: Zdd | None = None  # where cycles are looked for
        self.rest = along  # what of it may still be on a cycle, or lead to one
        self.transitions: frozenset[int] = frozenset()  # what may fire on cycles there
        self.layers, self.check = 0, FIRST_CHECK

    def states(self, steps: int) -> Zdd | None:
        """The states, unless a closure, or all layers, take more steps."""
        self.space.most_steps = steps
        try:
            return None if self.given_up else self._states(self.space.steps + steps)
        except BudgetExceeded:
            return None
        finally:
            self.space.most_steps = 0

    def _states(self, until: int) -> Zdd | None:
        space = self.space
        if self.room is None:
            self.room = self.rest = self._without_ends()
            firing = space.firing(self.rest)
            self.transitions = repeatable(space.net, firing)
            self.given_up = SHARE * len(self.transitions) > len(firing)
        if self.asked is not None and self.asked & self.to_dead:
            return self.to_dead
        if self.given_up and self.rest:
            return None
        while self.rest and self.transitions:
            if space.steps >= until:
                return None
            kept = space.continuing(self.rest, self.transitions)
            self.layers += 1
            ended = kept == self.rest
            self.rest = kept
            if ended or self.layers >= self.check:
                self.check = LONGER * self.layers
                known = self.transitions
                self.transitions = repeatable(space.net, known & space.firing(self.rest))
                if ended and self.transitions == known:
                    return self.to_dead | (
                        space.reaching(self.rest, self.room) if self.asked is None else self.room
                    )
        return self.to_dead

    def _without_ends(self) -> Zdd:
        """States of the set, reached from those asked for, from which no run in it ends in a dead state."""
        space, ends = self.space, self.along & self.space.dead
        if self.asked is not None:
            room = space.reached(self.asked & self.along, self.along)
            self.to_dead = room if room & ends else space.nothing
            return room
        self.to_dead = space.reaching(ends, self.along) if ends else ends
        return self.along - self.to_dead
