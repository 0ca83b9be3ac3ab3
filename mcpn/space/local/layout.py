"""The diagram store of a composite: one for all sections, so that sets pass from section to section.

The first levels hold the places of a section's local net, those of another section elsewhere in the same
place. The last levels, the *slots*, hold the state of all hardware of the mission: out of service, and lost
for good where hardware may die. A section keeps its own hardware in its local places; its own slots are left
open (in either state), so that sections of one type have equal diagrams whatever their hardware is called.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Sequence
from functools import cached_property
from itertools import chain
from typing import Literal, NamedTuple

from mcpn._kernel import Store, Zdd
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY

Bits = tuple[Literal["oos", "dead"], ...]
"""What a slot says of a hardware resource, as the role of the place that says the same."""

IMMORTAL: Bits = ("oos",)
MORTAL: Bits = ("oos", "dead")


class Toggle(NamedTuple):
    """What an idle resource may do.

    Args:
        event: The event of the store.
        undo: The one that undoes it.
        marked: Slots that must be marked for it.
        unmarked: Slots that must be unmarked.
        changed: Slots that it changes.
    """

    event: int
    undo: int
    marked: list[int]
    unmarked: list[int]
    changed: frozenset[int]


class Layout:
    """Levels of the store of one composite.

    Args:
        hardware: All hardware of the mission that can fail, in document order.
        bits: What is known of each resource.
        places: Most places of a local net.
        memory_limit: Bytes that the store may take.
    """

    def __init__(
        self, hardware: Sequence[str], bits: Bits, places: int, memory_limit: int = DEFAULT_MEMORY
    ) -> None:
        self.hardware = tuple(hardware)
        self.bits = bits
        self.first_slot = places
        self.store = Store(places + len(bits) * len(hardware), memory_limit)
        self.slots = {
            name: tuple(places + len(bits) * i + b for b in range(len(bits)))
            for i, name in enumerate(self.hardware)
        }
        self._events: dict[tuple[tuple[int, ...], ...], int] = {}
        self._known: dict[Hashable, list[int]] = {}

    @cached_property
    def all_slots(self) -> list[int]:
        """The slots of all hardware."""
        return list(chain.from_iterable(self.slots.values()))

    def slots_of(self, hardware: Sequence[str]) -> list[int]:
        """The slots of some hardware."""
        return list(chain.from_iterable(self.slots[name] for name in hardware))

    def event(
        self,
        consume: Iterable[int] = (),
        produce: Iterable[int] = (),
        read: Iterable[int] = (),
        zero: Iterable[int] = (),
    ) -> int:
        """An event of the store, the same for the same levels."""
        key = tuple(tuple(sorted(levels)) for levels in (consume, produce, read, zero))
        if key not in self._events:
            self._events[key] = self.store.event(*map(list, key))
        return self._events[key]

    def opened(self, states: Zdd, slots: Sequence[int]) -> Zdd:
        """The same with some slots, unmarked so far, in either state."""
        return states.saturate([self.event(produce=[slot]) for slot in slots])

    # --- hardware beside a section ---

    @cached_property
    def toggles(self) -> dict[str, dict[str, Toggle]]:
        """What each resource that nobody uses does, by the kind of its event.

        ``fails`` and ``repaired``; ``dies`` where hardware may die.
        """
        found: dict[str, dict[str, Toggle]] = {}
        for name, (oos, *dead) in self.slots.items():
            found[name] = {"fails": self._toggle([], [oos], dead), "repaired": self._toggle([oos], [], dead)}
            if dead:
                found[name]["dies"] = self._toggle([], dead, [], [oos])
        return found

    def _toggle(
        self, consume: list[int], produce: list[int], zero: list[int], read: Sequence[int] = ()
    ) -> Toggle:
        marked, unmarked = [*consume, *read], [*produce, *zero]
        events = self.event(consume, produce, read, zero), self.event(produce, consume, read, zero)
        return Toggle(*events, sorted(marked), sorted(unmarked), frozenset((*consume, *produce)))

    @cached_property
    def universe(self) -> Zdd:
        """All states of all hardware."""
        return self.store.singleton([]).saturate(self.beside(None, undone=False))

    def beside(
        self, kinds: Collection[tuple[str, str]] | None, *, undone: bool, but: Collection[str] = ()
    ) -> list[int]:
        """Events of the store for what idle hardware does, or what undoes it.

        Args:
            kinds: Those that are wanted, as pairs (resource, kind); ``None`` for all.
            undone: Whether those are wanted that undo it.
            but: Hardware whose events are not wanted.
        """
        key = kinds, undone, tuple(but)
        if key not in self._known:
            self._known[key] = [
                toggle.undo if undone else toggle.event
                for name, toggles in self.toggles.items()
                for kind, toggle in toggles.items()
                if name not in but and (kinds is None or (name, kind) in kinds)
            ]
        return self._known[key]

    def statuses(self) -> list[tuple[int, ...]]:
        """The states of one resource but for *in service*, each as the bits that are marked."""
        return [(0,)] if len(self.bits) == 1 else [(0,), (0, 1)]
