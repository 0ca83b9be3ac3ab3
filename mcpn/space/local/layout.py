"""The diagram store of a composite: one for all sections, so that sets pass from section to section.

The first levels hold the places of a section's local net, those of another section elsewhere in the same
place. The last levels, the *slots*, hold the state of all hardware of the mission: out of service, and lost
for good where hardware may die. A section keeps its own hardware in its local places; its own slots are left
open (in either state), so that sections of one type have equal diagrams whatever their hardware is called.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from functools import cached_property
from itertools import chain
from typing import Literal

from mcpn._kernel import Store, Zdd
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY

Bits = tuple[Literal["oos", "dead"], ...]
"""What a slot says of a hardware resource, as the role of the place that says the same."""

IMMORTAL: Bits = ("oos",)
MORTAL: Bits = ("oos", "dead")


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
        self._toggles: dict[str, dict[str, tuple[int, int]]] = {}
        self.known: dict[Hashable, list[int]] = {}

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
    def universe(self) -> Zdd:
        """All states of all hardware."""
        ways = [event for name in self.hardware for event, _ in self.toggles(name).values()]
        return self.store.singleton([]).saturate(ways)

    def toggles(self, name: str) -> dict[str, tuple[int, int]]:
        """What a resource that nobody uses does: by its event's kind, the event and the one that undoes it.

        ``fails`` and ``repaired``; ``dies`` where hardware may die.
        """
        if name not in self._toggles:
            self._toggles[name] = self._drawn_toggles(name)
        return self._toggles[name]

    def _drawn_toggles(self, name: str) -> dict[str, tuple[int, int]]:
        oos, *rest = self.slots[name]
        if not rest:
            return {
                "fails": (self.event(produce=[oos]), self.event(consume=[oos])),
                "repaired": (self.event(consume=[oos]), self.event(produce=[oos])),
            }
        (dead,) = rest
        return {
            "fails": (self.event(produce=[oos], zero=[dead]), self.event(consume=[oos], zero=[dead])),
            "repaired": (self.event(consume=[oos], zero=[dead]), self.event(produce=[oos], zero=[dead])),
            "dies": (self.event(produce=[dead], read=[oos]), self.event(consume=[dead], read=[oos])),
        }

    def statuses(self) -> list[tuple[int, ...]]:
        """The states of one resource but for *in service*, each as the bits that are marked."""
        return [(0,)] if len(self.bits) == 1 else [(0,), (0, 1)]

    def needs(self, name: str) -> dict[str, tuple[list[int], list[int]]]:
        """By kind of event of an idle resource, the slots that must be marked for it, and unmarked."""
        oos, *rest = self.slots[name]
        needed: dict[str, tuple[list[int], list[int]]] = {"fails": ([], [oos]), "repaired": ([oos], [*rest])}
        if rest:
            needed["dies"] = [oos], [*rest]
        return needed

    def changes(self, kind: str, name: str) -> set[int]:
        """The slots that an event of an idle resource changes."""
        return {self.slots[name][-1 if kind == "dies" else 0]}
