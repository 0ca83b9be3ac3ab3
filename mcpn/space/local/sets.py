"""Sets of states of a composite: a diagram for each section."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from heapq import heappop, heappush
from typing import TYPE_CHECKING

from mcpn._kernel import Zdd

if TYPE_CHECKING:
    from mcpn.space.local.glued import Glued

Member = tuple[str, tuple[int, ...]]
"""A state: its section, and its marked levels with the section's own slots unmarked."""


class Parts(dict[str, Zdd]):
    """A set of states in the making: by section, a diagram that is not empty."""

    def add(self, name: str, part: Zdd) -> bool:
        """Adds states of a section; whether some are new."""
        known = self.get(name)
        wider = part if known is None else known | part
        if not wider or wider == known:
            return False
        self[name] = wider
        return True


class CompositeSet:
    """A set of states of a composite.

    Args:
        space: The composite.
        parts: By section, a diagram with the section's own slots open; those that are empty are left out.
    """

    __slots__ = ("parts", "space")

    def __init__(self, space: Glued, parts: Mapping[str, Zdd]) -> None:
        self.space = space
        self.parts = {name: part for name, part in parts.items() if part}

    def __and__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        return CompositeSet(self.space, {n: part & many[n] for n, part in few.items() if n in many})

    def __or__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        return CompositeSet(self.space, many | {n: p | many[n] if n in many else p for n, p in few.items()})

    def __sub__(self, other: CompositeSet) -> CompositeSet:
        theirs = other.parts
        found = {n: part - theirs[n] if n in theirs else part for n, part in self.parts.items()}
        return CompositeSet(self.space, found)

    def __bool__(self) -> bool:
        return bool(self.parts)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CompositeSet) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash(frozenset(self.parts.items()))

    def count(self) -> int:
        """How many states the set has."""
        return sum(self.space.closed(name, part).count() for name, part in self.parts.items())

    def pick(self) -> Member | None:
        """A state of the first section in the mission's order, with little hardware out of service."""
        for name in self.space.in_order(self.parts):
            levels = self.space.closed(name, self.parts[name]).pick()
            assert levels is not None, "no part is empty"
            return name, tuple(levels)
        return None


class Waiting:
    """Sections that are to be worked on, again each time that something has changed for them.

    Args:
        names: The sections.
        rank: The order in which they are worked on.
    """

    def __init__(self, names: Iterable[str], rank: Callable[[str], int]) -> None:
        self.rank = rank
        self._queued = set(names)
        self._heap = sorted((rank(name), name) for name in self._queued)

    def __iter__(self) -> Iterator[str]:
        while self._heap:
            _, name = heappop(self._heap)
            self._queued.discard(name)
            yield name

    def again(self, name: str) -> None:
        """Has a section worked on once more, if it does not wait already."""
        if name not in self._queued:
            self._queued.add(name)
            heappush(self._heap, (self.rank(name), name))
