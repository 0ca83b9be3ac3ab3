"""What machines of sections do on events: as columns of numbers, of which each move is made when asked for.

Moves are many and do few things: which actions they order, when they are taken and what becomes of facts is
kept once for all that have it in common.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias, overload

import numpy as np

from mcpn.controller.machine import PlannedAction
from mcpn.drawing.forgetful import ALWAYS, Guard
from mcpn.spaces.markings.graph import Ints

Done: TypeAlias = tuple[tuple[PlannedAction, ...], Guard, tuple[str, ...], tuple[str, ...]]
"""The actions of a move, its guard, and what becomes true and false of facts."""


@dataclass(frozen=True, slots=True)
class Move:
    """What a section's machine does on an event inside it.

    Args:
        source: Number of the state that it is in.
        event: Number of the event.
        target: Number of the state that it goes to, or the outcome with which it leaves the section.
        actions: In order.
        guard: When it is taken; at most one of those of a state and event is.
        gained: What becomes true of facts.
        lost: What is no longer true of them.
    """

    source: int
    event: int
    target: int | str
    actions: tuple[PlannedAction, ...]
    guard: Guard = ALWAYS
    gained: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()


class Moves(Sequence[Move]):
    """The moves of a machine, in columns.

    Args:
        sources: By move, the state that it starts in.
        events: By move, its event.
        targets: By move, the state that it leads to; of one that leaves the section, -1 less the number of
            its outcome.
        outcomes: Outcomes by number.
        kinds: By move, the number of what it does.
        done: By number, what moves do.
    """

    def __init__(
        self,
        sources: Ints,
        events: Ints,
        targets: Ints,
        outcomes: Sequence[str],
        kinds: Ints,
        done: Sequence[Done],
    ) -> None:
        self.sources, self.events, self.kinds = sources, events, kinds
        self._targets, self._outcomes, self.done = targets, outcomes, done

    @classmethod
    def of(cls, moves: Iterable[Move]) -> Moves:
        """Some moves in columns."""
        outcomes, done, rows = dict[str, int](), dict[Done, int](), list[tuple[int, int, int, int]]()
        for m in moves:
            to = m.target if isinstance(m.target, int) else -1 - outcomes.setdefault(m.target, len(outcomes))
            kind = done.setdefault((m.actions, m.guard, m.gained, m.lost), len(done))
            rows.append((m.source, m.event, to, kind))
        sources, events, targets, kinds = np.array(rows, np.int64).reshape(-1, 4).T
        return cls(sources, events, targets, (*outcomes,), kinds, (*done,))

    @property
    def targets(self) -> list[int | str]:
        """By move, the number of the state that it goes to, or the outcome with which it leaves."""
        outcomes = self._outcomes
        return [to if to >= 0 else outcomes[-1 - to] for to in self._targets.tolist()]

    def __len__(self) -> int:
        return len(self.sources)

    @overload
    def __getitem__(self, number: int) -> Move: ...
    @overload
    def __getitem__(self, number: slice) -> Moves: ...
    def __getitem__(self, number: int | slice) -> Move | Moves:
        if isinstance(number, slice):
            columns = (self.sources[number], self.events[number], self._targets[number])
            return Moves(*columns, self._outcomes, self.kinds[number], self.done)
        to = int(self._targets[number])
        target = to if to >= 0 else self._outcomes[-1 - to]
        actions, guard, gained, lost = self.done[self.kinds[number]]
        source, event = int(self.sources[number]), int(self.events[number])
        return Move(source, event, target, actions, guard, gained, lost)

    def __iter__(self) -> Iterator[Move]:
        columns = (self.sources.tolist(), self.events.tolist(), self.targets, self.kinds.tolist())
        for source, event, target, kind in zip(*columns, strict=True):
            yield Move(source, event, target, *self.done[kind])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and tuple(self) == tuple(other)

    __hash__ = None  # type: ignore[assignment]  # as of lists
