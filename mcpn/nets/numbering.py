"""How the nodes of a net are numbered of which parts are copies: by arithmetic, without a list of them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import accumulate, chain
from typing import TypeVar, overload

T = TypeVar("T")
Node = TypeVar("Node")


class Numbering:
    """Where nodes that are drawn by themselves, and copies, lie among all places, or all transitions.

    Args:
        firsts: By copy the number of its first node, in ascending order.
        sizes: By copy how many nodes it has.
        direct: How many nodes are drawn by themselves.

    Examples:
        >>> numbering = Numbering([2, 5], [2, 2], 4)
        >>> [*numbering.row("abcd", lambda copy: f"{copy}" * 2)]
        ['a', 'b', '0', '0', 'c', '1', '1', 'd']
        >>> [numbering.at(number) for number in (0, 3, 4, 7)]
        [(None, 0), (0, 1), (None, 2), (None, 3)]
    """

    def __init__(self, firsts: Sequence[int], sizes: Sequence[int], direct: int) -> None:
        self.firsts, self.sizes, self.direct = firsts, sizes, direct
        self._copied = [0, *accumulate(sizes)]
        self.base = firsts[0] if firsts else direct
        self.total = direct + self._copied[-1]

    def at(self, number: int) -> tuple[int | None, int]:
        """The copy that a node is of, and which of its nodes it is; or its place among those of no copy."""
        if number < self.base:
            return None, number
        after = bisect_right(self.firsts, number)
        within = number - self.firsts[after - 1]
        return (after - 1, within) if within < self.sizes[after - 1] else (None, number - self._copied[after])

    def row(self, direct: Sequence[T], copied: Callable[[int], Iterable[T]]) -> Iterator[T]:
        """What is said of each node, in their order: of those of no copy, and by copy of its own."""
        begin = 0
        for copy, first in enumerate(self.firsts):
            end = first - self._copied[copy]
            if begin < end:
                yield from direct[begin:end]
                begin = end
            yield from copied(copy)
        yield from direct[begin:]

    def directly(self) -> Iterator[int]:
        """The numbers of the nodes of no copy."""
        ends = (first + size for first, size in zip(self.firsts, self.sizes, strict=True))
        gaps = zip((0, *ends), (*self.firsts, self.total), strict=True)
        return chain.from_iterable(range(begin, end) for begin, end in gaps)

    def extended(self, more: int) -> Numbering:
        """The numbering with more nodes of no copy after all others."""
        return Numbering(self.firsts, self.sizes, self.direct + more)


class Nodes(Sequence[Node]):
    """The places, or the transitions, of a net with copies: each is drawn when somebody asks for it.

    Who asks for all of them has them drawn for good.

    Args:
        direct: Those of no copy.
        numbering: Where they lie.
        draw: Draws one of a copy.
    """

    def __init__(
        self, direct: Sequence[Node], numbering: Numbering, draw: Callable[[int, int], Node]
    ) -> None:
        self.direct = direct
        self._numbering, self._draw = numbering, draw
        self._all: tuple[Node, ...] | None = None

    @property
    def drawn(self) -> bool:
        """Whether all have been asked for."""
        return self._all is not None

    def __len__(self) -> int:
        return self._numbering.total

    def __iter__(self) -> Iterator[Node]:
        return iter(self._every())

    @overload
    def __getitem__(self, number: int) -> Node: ...

    @overload
    def __getitem__(self, number: slice) -> Sequence[Node]: ...

    def __getitem__(self, number: int | slice) -> Node | Sequence[Node]:
        if self._all is not None or isinstance(number, slice):
            return self._every()[number]
        if 0 <= number < self._numbering.base:
            return self.direct[number]
        if not -len(self) <= number < len(self):
            raise IndexError(number)
        copy, within = self._numbering.at(number % len(self))
        return self.direct[within] if copy is None else self._draw(copy, within)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and self._every() == tuple(other)

    def __hash__(self) -> int:
        return hash(self._every())

    def _every(self) -> tuple[Node, ...]:
        if self._all is None:
            numbering, draw = self._numbering, self._draw
            row = numbering.row(self.direct, lambda c: (draw(c, i) for i in range(numbering.sizes[c])))
            self._all = tuple(row)
        return self._all
