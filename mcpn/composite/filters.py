"""Which edges sections may take, of a choice of transitions of the whole net: found once for sections alike.

Sections that are copies of one lie alike in the net of the whole but for a range of transitions of their own.
Most choices hold all of such a range, or nothing of it; then they are the same for all these copies.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from typing import TypeAlias

from mcpn.composite.section_type import ALL, Allowed, SectionType
from mcpn.composite.sections import NOWHERE, Moved, Stage
from mcpn.drawing.sections import Used
from mcpn.spaces.algebra import Without
from mcpn.spaces.memoized import ByKey, memoized

Filter: TypeAlias = Callable[[str], Allowed]
"""By section, what its edges may carry."""

Divided: TypeAlias = tuple[frozenset[int], Sequence[int]]
"""Some events of a local net, and all those of the section's control."""


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

    def unguarded(self, transitions: Collection[int] | None) -> Filter:
        """What edges may carry, as each section sees it, of some transitions or of all."""
        if transitions is None:
            return lambda name: ALL
        if not isinstance(transitions, Without):
            return self._wanted[frozenset(transitions)]
        known, few = self._wanted[transitions.many], transitions.few
        if not few:
            return known

        def of(name: str) -> Allowed:
            stage, (local, beside, _) = self.stages[name], known(name)
            own, carrying = [*stage.transitions], stage.type.carrying
            left = local and local.difference([i for i in carrying if own[i] in few])
            return Allowed(left, beside and beside - few)

        return self._shared(few, of, known)

    @cached_property
    def _wanted(self) -> Mapping[frozenset[int], Filter]:
        """By transitions what edges may carry, as each section sees it."""

        def filter_(wanted: frozenset[int]) -> Filter:
            beside = wanted.intersection(self.toggles)

            def of(name: str) -> Allowed:
                stage = self.stages[name]
                used, control = self._of_used[wanted, stage.type, stage.part.used]
                lie = [*stage.transitions]
                own = [i for i in control if lie[i] in wanted]
                return self._once(Allowed(used.union(own), beside))

            return self._shared(wanted, of)

        return ByKey(filter_)

    def _shared(self, chosen: frozenset[int], of: Filter, before: Filter | None = None) -> Filter:
        """A filter that is asked once for copies that lie alike to some transitions, and to one before."""
        ordered = array("i", sorted(chosen & self.carrying))
        found = dict[tuple[int, int, Allowed | None, bool], Allowed]()

        def shared(name: str) -> Allowed:
            stage = self.stages[name]
            if not isinstance(row := stage.transitions, Moved):
                return of(name)
            begin, end = row.own
            held = bisect_left(ordered, end) - bisect_left(ordered, begin)
            if held and held != self._carrying_of[id(row.other)]:
                return of(name)
            key = id(row.other), id(stage.used), before and before(name), bool(held)
            if key not in found:
                found[key] = of(name)
            return found[key]

        return ByKey(shared).__getitem__

    @cached_property
    def _carrying_of(self) -> Mapping[int, int]:
        """By what copies are copied from, how many of the transitions of each carry an event."""
        rows = {
            id(s.transitions.other): s.transitions
            for s in self.stages.values()
            if isinstance(s.transitions, Moved)
        }
        return {number: sum(t in self.carrying for t in range(*row.own)) for number, row in rows.items()}

    @cached_property
    def _of_used(self) -> Mapping[tuple[frozenset[int], SectionType, Used], Divided]:
        """By transitions: events of what stages use, in their local net, and those of their control."""
        lists = {(s.type, s.part.used): s.used["transitions"] for s in self.stages.values()}

        def divided(key: tuple[frozenset[int], SectionType, Used]) -> Divided:
            wanted, used, carrying = key[0], lists[key[1:]], key[1].carrying
            chosen = frozenset([i for i in carrying if used[i] in wanted])
            return chosen, [i for i in carrying if used[i] == NOWHERE]

        return ByKey(divided)

    @memoized
    def _once(self, allowed: Allowed) -> Allowed:
        """One object for equal ones (interning)."""
        return allowed
