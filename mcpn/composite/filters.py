"""Which edges sections may take, of a choice of transitions of the whole net: found once for sections alike.

Sections that are copies of one lie alike in the net of the whole but for a range of transitions of their own.
Most choices hold the same ones of each range; then they are the same for all these copies.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeAlias, TypeVar

from mcpn.composite.section_type import ALL, Allowed, SectionType
from mcpn.composite.sections import NOWHERE, Moved, Stage
from mcpn.drawing.sections import Used
from mcpn.spaces.algebra import Without
from mcpn.spaces.memoized import ByKey, memoized

Found = TypeVar("Found")

Filter: TypeAlias = Callable[[str], Allowed]
"""By section, what its edges may carry."""


class Filters:
    """Makes filters.

    Args:
        stages: The sections by name, with what is around them.
        carrying: All transitions that carry an event.
        toggles: The transitions of hardware that no section uses.
    """

    def __init__(
        self, stages: Mapping[str, Stage], carrying: frozenset[int], toggles: Collection[int]
    ) -> None:
        self.stages, self.carrying, self.toggles = stages, carrying, toggles
        # By what is asked, where the section lies, and which of its own are chosen, and no others.
        self._of_own: dict[object, Any] = {}

    def unguarded(self, transitions: Collection[int] | None) -> Filter:
        """What edges may carry, as each section sees it, of some transitions or of all."""
        if transitions is None:
            return lambda name: ALL
        if not isinstance(transitions, Without):
            return self._of(frozenset(transitions))
        known, few = self._of(transitions.many), transitions.few
        if not few:
            return known

        def of(name: str) -> Allowed:
            stage, (local, beside, _) = self.stages[name], known(name)
            own, carrying = [*stage.transitions], stage.type.carrying
            left = local and local.difference([i for i in carrying if own[i] in few])
            return Allowed(left, beside and beside - few)

        return self._shared("without", few, of, known)

    def guarded(self, transitions: Collection[int]) -> Callable[[str], Sequence[int]]:
        """By section, which of its local net's events some transitions are."""

        def of(name: str) -> Sequence[int]:
            own = [*self.stages[name].transitions]
            return [i for i in self.stages[name].type.carrying if own[i] in transitions]

        return self._shared("guarded", transitions, of)

    def _of(self, wanted: frozenset[int]) -> Filter:
        """What edges may carry, kept for choices that may hold some of each section."""
        return self._wanted[wanted] if len(wanted) > len(self.stages) else self._made(wanted)

    @cached_property
    def _wanted(self) -> Mapping[frozenset[int], Filter]:
        return ByKey(self._made)

    def _made(self, wanted: frozenset[int]) -> Filter:
        beside = wanted.intersection(self.toggles)

        def divided(key: tuple[SectionType, Used]) -> frozenset[int]:
            used = self._lists[key]
            return frozenset([i for i in key[0].carrying if used[i] in wanted])

        of_used = ByKey(divided)

        def of(name: str) -> Allowed:
            stage = self.stages[name]
            used, control = of_used[stage.type, stage.part.used], self._control[stage.type, stage.part.used]
            lie = [*stage.transitions]
            return self._once(Allowed(used.union([i for i in control if lie[i] in wanted]), beside))

        return self._shared("wanted", wanted, of)

    def _shared(
        self, asked: str, chosen: Collection[int], of: Callable[[str], Found], before: Filter | None = None
    ) -> Callable[[str], Found]:
        """What is asked once for copies that lie alike to some transitions, and to a filter before."""
        ordered = array("i", sorted(self.carrying.intersection(chosen)))
        others = dict[object, Found]()

        def shared(name: str) -> Found:
            stage = self.stages[name]
            if not isinstance(row := stage.transitions, Moved):
                return of(name)
            begin, end = row.own
            first = bisect_left(ordered, begin)
            own = tuple([t - begin for t in ordered[first : bisect_left(ordered, end, first)]])
            found: dict[object, Found] = self._of_own if len(own) == len(chosen) else others
            key = asked, id(row.other), id(stage.used), before and before(name), own
            if key not in found:
                found[key] = of(name)
            return found[key]

        return ByKey(shared).__getitem__

    @cached_property
    def _lists(self) -> Mapping[tuple[SectionType, Used], Sequence[int]]:
        """By what stages use, where its events lie."""
        return {(s.type, s.part.used): s.used["transitions"] for s in self.stages.values()}

    @cached_property
    def _control(self) -> Mapping[tuple[SectionType, Used], Sequence[int]]:
        """By what stages use, the events of their control, in their local net."""
        lists = self._lists.items()
        return {key: [i for i in key[0].carrying if used[i] == NOWHERE] for key, used in lists}

    @memoized
    def _once(self, allowed: Allowed) -> Allowed:
        """One object for equal ones (interning)."""
        return allowed
