"""Sets of states of a composite: a diagram for each section."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from heapq import heappop, heappush
from typing import TYPE_CHECKING

from mcpn._kernel import Zdd

if TYPE_CHECKING:
    from mcpn.space.local.glued import Glued

Member = tuple[str, tuple[int, ...]]
"""A state: its section, and its marked levels with the section's own slots unmarked."""


class CompositeSet:
    """A set of states of a composite.

    Args:
        space: The composite.
        parts: By section, a diagram that is not empty; the section's own slots are open in it.
    """

    __slots__ = ("parts", "space")

    def __init__(self, space: Glued, parts: dict[str, Zdd]) -> None:
        self.space = space
        self.parts = parts

    def __and__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        found = ((name, part & many[name]) for name, part in few.items() if name in many)
        return CompositeSet(self.space, {name: part for name, part in found if part})

    def __or__(self, other: CompositeSet) -> CompositeSet:
        few, many = sorted((self.parts, other.parts), key=len)
        found = dict(many)
        for name, part in few.items():
            found[name] = found[name] | part if name in found else part
        return CompositeSet(self.space, found)

    def __sub__(self, other: CompositeSet) -> CompositeSet:
        theirs = other.parts
        found = ((name, part - theirs[name] if name in theirs else part) for name, part in self.parts.items())
        return CompositeSet(self.space, {name: part for name, part in found if part})

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
    """Parts of a set that are to be worked on, again each time that one has changed.

    Args:
        found: The parts by name; they are changed in place.
        rank: The order in which they are worked on.
    """

    def __init__(self, found: dict[str, Zdd], rank: Callable[[str], int]) -> None:
        self.found = found
        self.rank = rank
        self._heap = sorted((rank(name), name) for name in found)
        self._queued = set(found)

    def __iter__(self) -> Iterator[str]:
        while self._heap:
            _, name = heappop(self._heap)
            self._queued.discard(name)
            yield name

    def widen(self, name: str, part: Zdd) -> None:
        """Adds states to a part; if it grows it is to be worked on."""
        known = self.found.get(name)
        wider = part if known is None else known | part
        if wider and wider != known:
            self.found[name] = wider
            self.again(name)

    def again(self, name: str) -> None:
        """Has a part worked on once more, if it does not wait already."""
        if name not in self._queued:
            self._queued.add(name)
            heappush(self._heap, (self.rank(name), name))
