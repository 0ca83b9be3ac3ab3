"""Families of sets as diagrams of their own: images of states on some places, and their minimal members.

Which hardware is out of service in some states is such an image; minimal cut sets are the minimal members of
another. The families are far too large to be listed, so they are built diagram from diagram.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

from mcpn._kernel import Store, Zdd
from mcpn.errors import LimitError

MAX_MINIMAL = 10_000
"""Minimal sets of a family that are listed at most."""

Bit = tuple[int, bool] | bool
"""How a diagram encodes whether a place is marked: a level and whether it is negated, or a constant."""


class ImageStore:
    """Families of sets of the numbers from 0 to ``levels - 1``.

    Args:
        levels: How many numbers there are.
    """

    def __init__(self, levels: int) -> None:
        self.levels = levels
        self.store = Store(max(levels, 1))
        self._known: dict[Hashable, Zdd] = {}  # images of diagrams
        self._puts = [self.store.event([], [level]) for level in range(levels)]

    @property
    def nothing(self) -> Zdd:
        """The family without a member."""
        return self.store.empty()

    @property
    def everything(self) -> Zdd:
        """The family of all sets."""
        return self.upward(self.store.singleton([]))

    def of_rows(self, rows: Iterable[Sequence[int]]) -> Zdd:
        """The family of sets given one by one, each as its numbers."""
        family = self.nothing
        for row in rows:
            family |= self.store.singleton(sorted(row))
        return family

    def upward(self, family: Zdd) -> Zdd:
        """The sets of a family and all that contain one of them."""
        return family.saturate(self._puts)

    def with_member(self, family: Zdd, number: int) -> Zdd:
        """The sets of a family that have not a number, with it."""
        return family.images([self._puts[number]])

    def of_diagram(self, states: Zdd, store: Store, bits: Sequence[Bit]) -> Zdd:
        """The image of a diagram of another store.

        Args:
            states: The diagram.
            store: Its store.
            bits: For each number, where the diagram says whether it is in the set.

        Returns:
            The family; linear in the size of the diagram's projection on the levels named.
        """
        levels = sorted({bit[0] for bit in bits if not isinstance(bit, bool)})
        key = states.onto(levels), tuple(bits)
        if key not in self._known:
            self._known[key] = self._built(key[0], store, levels, bits)
        return self._known[key]

    def _built(self, states: Zdd, store: Store, levels: Sequence[int], bits: Sequence[Bit]) -> Zdd:
        # By level, the numbers in the set where it is unmarked, and where it is marked.
        members = {level: (list[int](), list[int]()) for level in levels}
        for number, bit in enumerate(bits):
            if not isinstance(bit, bool):
                members[bit[0]][not bit[1]].append(number)
        always = self.store.event([], [number for number, bit in enumerate(bits) if bit is True])
        ways = [
            (level, store.event([level], []), *(self.store.event([], numbers) for numbers in members[level]))
            for level in levels
        ]
        memo: dict[tuple[Zdd, int], Zdd] = {}

        def built(part: Zdd, depth: int) -> Zdd:
            if not part or depth == len(ways):
                return self.store.singleton([]) if part else self.nothing
            if (part, depth) not in memo:
                level, take, where_unmarked, where_marked = ways[depth]
                unmarked, marked = part.subset(unmarked=[level]), part.images([take])
                without = built(unmarked, depth + 1).images([where_unmarked])
                memo[part, depth] = without | built(marked, depth + 1).images([where_marked])
            return memo[part, depth]

        return built(states, 0).images([always])

    def sized(self, family: Zdd) -> int:
        """The size of the largest member of a family that is not empty."""
        return family.largest([1] * self.store.levels)

    def minimal(self, family: Zdd) -> list[tuple[int, ...]]:
        """The minimal members of a family, those that contain no other member; smaller ones first.

        Raises:
            LimitError: There are more than :data:`MAX_MINIMAL`.
        """
        minima: list[tuple[int, ...]] = []
        weights = [1] * self.store.levels
        for size in range(self.levels + 1):
            if not family:
                break
            members = family.weighing(weights, size, size)
            if len(minima) + members.count() > MAX_MINIMAL:
                raise LimitError(f"more than {MAX_MINIMAL} minimal sets: the limit on cut sets was hit")
            new = [tuple(sorted(member)) for member in members]
            minima += new
            family = family.without([self.store.condition(list(member)) for member in new]) if new else family
        return minima
