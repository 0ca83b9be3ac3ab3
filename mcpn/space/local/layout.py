"""The diagram store of a composite: one for all sections, so that sets pass from section to section.

The first levels hold the places of a section's local net, those of another section elsewhere in the same
place. The last levels, the *slots*, hold the status of all hardware of the mission: out of service, and lost
for good where hardware may die. A section keeps its own hardware in its local places; its own slots are left
open (in either state), so that sections of one type have equal diagrams whatever their hardware is called.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Literal

from mcpn._kernel import Store, Zdd
from mcpn.net.compose import MissionNet
from mcpn.net.events import What
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY

ROLES: tuple[Literal["oos", "dead"], ...] = ("oos", "dead")
"""What the slots of a resource say, as the roles of places that say so; the second implies the first."""

CHANGES = {What.OUT_OF_SERVICE: (0, 1), What.REPAIRED: (1, 0), What.LOST: (1, 2)}
"""By event of hardware, its status before and after: how many of its slots are marked."""


@dataclass(frozen=True, slots=True)
class Toggle:
    """What a resource may do while nobody uses it.

    Args:
        transition: Its transition of the whole net.
        hardware: The resource.
        event: The event of the store.
        undo: The one that undoes it.
        condition: The condition of the store for it.
        marked: Slots that must be marked for it.
        unmarked: Slots that must be unmarked.
        changed: Slots that it changes.
    """

    transition: int
    hardware: str
    event: int
    undo: int
    condition: int
    marked: frozenset[int]
    unmarked: frozenset[int]
    changed: frozenset[int]


class Layout:
    """Levels of the store of one composite.

    Args:
        mission_net: The net of the whole mission.
        places: Most places of a local net.
        memory_limit: Bytes that the store may take.

    Attributes:
        hardware: All hardware of the mission that can fail, in document order.
        roles: What the slots of a resource say.
        slots: By hardware, its slots.
    """

    def __init__(self, mission_net: MissionNet, places: int, memory_limit: int = DEFAULT_MEMORY) -> None:
        self.mission_net = mission_net
        faulty = {name for said, name in mission_net.roles.values() if said == "oos"}
        self.hardware = tuple(h.name for h in mission_net.mission.hardware if h.name in faulty)
        self.roles = [role for role in ROLES if mission_net.saying(role)]
        self.first_slot, each = places, len(self.roles)
        self.store = Store(places + each * len(self.hardware), memory_limit)
        self.slots = {
            name: range(places + each * i, places + each * (i + 1)) for i, name in enumerate(self.hardware)
        }
        self._known: dict[tuple[frozenset[int] | None, tuple[str, ...]], list[Toggle]] = {}

    @cached_property
    def all_slots(self) -> list[int]:
        """The slots of all hardware."""
        return self.slots_of(self.hardware)

    def slots_of(self, hardware: Sequence[str]) -> list[int]:
        """The slots of some hardware."""
        return list(chain.from_iterable(self.slots[name] for name in hardware))

    def opened(self, states: Zdd, slots: Iterable[int]) -> Zdd:
        """The same with some slots, unmarked so far, in either state."""
        return states.saturate([self.store.event([], [slot]) for slot in slots])

    @cached_property
    def toggles(self) -> dict[int, Toggle]:
        """What each resource does while nobody uses it, by the transition of the whole net."""
        net, store = self.mission_net.net, self.store
        found: dict[int, Toggle] = {}
        for t, transition in enumerate(net.transitions):
            event = transition.event
            if event is None or event.what not in CHANGES or event.element not in self.slots:
                continue
            before, after = CHANGES[event.what]
            if before == 0 and not all(net.initial[p] for p, _ in transition.consume):
                continue  # the failure of a resource in use
            slots = self.slots[event.element]
            lost, gained = slots[after:before], slots[before:after]
            read, zero = slots[: min(before, after)], slots[max(before, after) :]
            marked, unmarked = slots[:before], slots[before:]
            found[t] = Toggle(
                t,
                event.element,
                store.event(lost, gained, read, zero),
                store.event(gained, lost, read, zero),
                store.condition(marked, unmarked),
                frozenset(marked),
                frozenset(unmarked),
                frozenset((*lost, *gained)),
            )
        return found

    def beside(self, transitions: frozenset[int] | None = None, but: tuple[str, ...] = ()) -> list[Toggle]:
        """What hardware may do while nobody uses it.

        Args:
            transitions: Those that are wanted; all by default.
            but: Hardware whose events are not wanted.
        """
        key = transitions, but
        if key not in self._known:
            self._known[key] = [
                toggle
                for t, toggle in self.toggles.items()
                if toggle.hardware not in but and (transitions is None or t in transitions)
            ]
        return self._known[key]
