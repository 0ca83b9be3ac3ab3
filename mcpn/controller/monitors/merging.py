"""Merges states of monitors that no run of the mission tells apart.

An event that the mission does not allow in a state may lead anywhere, so that two states must stay apart
only where some run that both allow ends with different values. To find the fewest states then is hard
(Pfleeger, *State reduction in incompletely specified finite-state machines*, IEEE Transactions on Computers
22, 1973): each state in turn is merged with the first that it can be merged with, and with them the states
that the same events lead to, as automata are learnt from examples (Oncina, García, *Inferring regular
languages in polynomial updated time*, 1992).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Generic, TypeVar

Value = TypeVar("Value")
Moves = dict[str, int]


def merged(values: Sequence[Value], moves: Sequence[Moves]) -> tuple[list[Value], list[Moves]]:
    """A machine that says the same after each run of another.

    Args:
        values: What is said in each state; it begins in state 0.
        moves: By state, where each event leads that may happen there; none where it never changes again.

    Returns:
        The same of fewer states, without moves that change nothing.
    """
    folding = _Folding(*_blocks(values, moves))
    folding.fold()
    kept = [q for q in range(len(folding.values)) if folding.root(q) == q]
    number = {q: i for i, q in enumerate(kept)}
    return (
        [folding.values[q] for q in kept],
        [
            {
                event: number[to]
                for event, target in sorted(folding.moves[q].items())
                if (to := folding.root(target)) != q
            }
            for q in kept
        ],
    )


def _blocks(values: Sequence[Value], moves: Sequence[Moves]) -> tuple[list[Value], list[Moves]]:
    """The machine with bisimilar states merged (Moore 1956), in the order of their first states."""
    targets = [[targets_of[event] for event in sorted(targets_of)] for targets_of in moves]
    known: dict[object, int] = {}
    blocks = [
        known.setdefault((value, tuple(sorted(targets_of))), len(known))
        for value, targets_of in zip(values, moves, strict=True)
    ]
    count = 0
    while count != len(known):
        count, known = len(known), {}
        blocks = [
            known.setdefault((block, tuple([blocks[to] for to in targets_of])), len(known))
            for block, targets_of in zip(blocks, targets, strict=True)
        ]
    first: dict[int, int] = {}
    for q, block in enumerate(blocks):
        first.setdefault(block, q)
    return (
        [values[q] for q in first.values()],
        [{event: blocks[to] for event, to in moves[q].items()} for q in first.values()],
    )


class _Folding(Generic[Value]):
    """States that are merged one after the other.

    Args:
        values: What is said in each state.
        moves: By state, where events lead.
    """

    def __init__(self, values: list[Value], moves: list[Moves]) -> None:
        self.values, self.moves = values, moves
        self._above = list(range(len(values)))

    def root(self, q: int) -> int:
        """The state that a state has been merged with."""
        while self._above[q] != q:
            self._above[q] = self._above[self._above[q]]
            q = self._above[q]
        return q

    def fold(self) -> None:
        """Merges what can be merged, in the order of the states."""
        unmerged: list[int] = []
        for q in range(len(self.values)):
            if self.root(q) == q and not any(self._merge(other, q) for other in unmerged):
                unmerged.append(q)

    def _merge(self, one: int, other: int) -> bool:
        """Merges two states, and the states that the same events lead to from them.

        Where values of such states differ it changes nothing and returns false.
        """
        above: dict[int, int] = {}
        moves: dict[int, Moves] = {}

        def root(q: int) -> int:
            q = self.root(q)
            while q in above:
                q = self.root(above[q])
            return q

        pairs = [(one, other)]
        while pairs:
            low, high = sorted(map(root, pairs.pop()))
            if low == high:
                continue
            if self.values[low] != self.values[high]:
                return False
            above[high] = low
            mine = moves.setdefault(low, dict(self.moves[low]))
            theirs: Mapping[str, int] = moves.pop(high, self.moves[high])
            for event, target in theirs.items():
                if event in mine:
                    pairs.append((mine[event], target))
                else:
                    mine[event] = target
        for q, into in above.items():
            self._above[q] = into
        for q, joined in moves.items():
            self.moves[q] = joined
        return True
