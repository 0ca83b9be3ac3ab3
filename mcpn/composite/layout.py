"""The diagram store of a composite: one for all sections, so that sets pass from section to section.

The first levels hold the places of the local net of one section; all sections use the same levels. The last
levels, the *slots*, hold the status that sections hand on (:mod:`mcpn.drawing.status`): one for each flag
that the net of the mission tells. A section keeps the status of its own elements in places of its local
net. Its diagrams leave the slots of these unconstrained, so that sections of one type have equal diagrams
whatever their elements are called.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from mcpn._kernel import Store, Zdd, clustered
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.sections import LocalPart
from mcpn.drawing.status import HARDWARE, Element
from mcpn.drawing.templates.copied import of_no_copy
from mcpn.events import What
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY
from mcpn.spaces.memoized import memoized
from mcpn.spaces.run import Completion


class Toggle(NamedTuple):
    """What a status may do while nobody uses its element."""

    transition: int  # of the whole net
    flags: frozenset[Element]  # of what it concerns
    event: int  # of the store
    undo: int  # the event that undoes it
    condition: int  # of the store, for it


class Layout:
    """Levels of the store of one composite.

    Args:
        mission_net: The net of the whole mission.
        places: Most places of a local net.

    Attributes:
        hardware: All hardware of the mission that can fail, in document order.
        slots: By flag its slot.
    """

    def __init__(self, mission_net: MissionNet, places: int) -> None:
        self.mission_net = mission_net
        self.statuses = {status.element: status for status in mission_net.statuses}
        self.hardware = tuple(name for kind, name in self.statuses if kind == "hardware")
        self.first_slot = places
        # What is said of one resource stands together: apart it makes diagrams large.
        hardware = [("hardware", name) for name in self._standing()]
        every = chain.from_iterable(
            self.flags_of(each) for each in dict.fromkeys([*hardware, *self.statuses])
        )
        self.slots: dict[Element, int] = {flag: slot for slot, flag in enumerate(every, places)}
        self.store = Store(places + len(self.slots), DEFAULT_MEMORY)

    def flags_of(self, element: Element) -> list[Element]:
        """The flags of an element that the net of the mission tells."""
        every, told = self.statuses[element].flags, self.mission_net.flag_bits
        return [flag.element for flag in every if flag.element in told]

    def carried(self, part: LocalPart) -> tuple[Element, ...]:
        """The flags of what has a status in a part of the mission: one object where they are equal."""
        return self._once(tuple([f for status in part.statuses for f in self.flags_of(status.element)]))

    @memoized
    def _once(self, flags: tuple[Element, ...]) -> tuple[Element, ...]:
        """One object for equal ones (interning)."""
        return flags

    def _standing(self) -> list[str]:
        """The order in which slots of hardware stand: where some of it is a crash or a common cause, by use.

        A section often ends because what one alternative consumes has failed, or what another one does. Sets
        of such states are small where the two stand apart and each stands together; a crash, or a common
        cause, is declared far from the hardware that is consumed with it.
        """
        mission, number = self.mission_net.core, {name: i for i, name in enumerate(self.hardware)}
        if not mission.common_causes and not mission.crashes:
            return [*self.hardware]
        groups = list[list[int]]()
        for activity in mission.activities:
            ways = [
                [number[name] for name in way.consumes if name in number] for way in activity.alternatives
            ]
            groups += [*ways, sorted(set(chain.from_iterable(ways)))]
        order = clustered([group for group in groups if len(group) > 1], [*range(len(number))])
        return [self.hardware[i] for i in order]

    @cached_property
    def idle(self) -> list[int]:
        """By place of the whole net: tokens while the mission is in a section whose local net lacks it."""
        tokens = [*self.mission_net.in_service]
        tokens[self.mission_net.beginning] = 0
        return tokens

    @cached_property
    def status(self) -> dict[int, tuple[int, bool]]:
        """Places of the whole net that say what a slot says, or the opposite, while nobody uses it."""
        places = idle_places(self.mission_net).items()
        return {place: (self.slots[flag], reverse) for place, (flag, reverse) in places}

    @cached_property
    def all_slots(self) -> tuple[int, ...]:
        """All slots."""
        return tuple(self.slots.values())

    def slots_of(self, flags: Iterable[Element]) -> tuple[int, ...]:
        """The slots of some flags."""
        return tuple(self.slots[flag] for flag in flags)

    def opened(self, states: Zdd, slots: Iterable[int]) -> Zdd:
        """The set with some slots, which are unmarked in it, left unconstrained."""
        return states.saturate([self.store.event([], [slot]) for slot in slots])

    @cached_property
    def toggles(self) -> dict[int, Toggle]:
        """What each status may do while nobody uses its element, by the transition of the whole net."""
        every = (*self._events_of_hardware(), *self._declared_events())
        return {toggle.transition: toggle for toggle in every}

    def _events_of_hardware(self) -> Iterator[Toggle]:
        for t, what, name in _idle_events(self.mission_net):
            flags = {flag[0]: self.slots[flag] for flag in self.flags_of(("hardware", name))}
            each = ([flags[kind] for kind in kinds if kind in flags] for kinds in HARDWARE[what])
            yield self._toggle(t, (("hardware", name),), *each)

    def _declared_events(self) -> Iterator[Toggle]:
        """What declared events do to what has a value whatever runs."""
        value_of = {
            place: (status, value)
            for status in self.mission_net.statuses
            for role, value in status.said.items()
            for place in self.mission_net.by_role[role]
        }
        for t, transition in of_no_copy(self.mission_net.net):
            origin = transition.provenance
            if transition.event is None or origin is None or (origin.kind, origin.name) not in self.statuses:
                continue  # an objective's, or what facts have become is forgotten
            if origin.kind == "hardware":
                continue
            asked = [value_of[p] for p, _ in (*transition.consume, *transition.read)]
            begun = [value_of[p] for p, _ in (*transition.produce, *transition.read) if p in value_of]
            before, after = (
                {self.slots[flag] for status, value in values for flag in status.values[value]}
                for values in (asked, begun)
            )
            elements = [status.element for status, _ in asked]
            absent = (
                {slot for element in elements for slot in self.slots_of(self.flags_of(element))}
                - before
                - after
            )
            yield self._toggle(t, elements, after - before, before - after, before & after, absent)

    def _toggle(
        self,
        transition: int,
        elements: Iterable[Element],
        gained: Collection[int],
        lost: Collection[int],
        kept: Collection[int],
        absent: Collection[int],
    ) -> Toggle:
        """A change of slots: some are gained, some lost, and others must be marked, or unmarked."""
        flags = frozenset(flag for element in elements for flag in self.flags_of(element))
        so, no = sorted((*lost, *kept)), sorted((*gained, *absent))
        gained, lost, kept, absent = map(sorted, (gained, lost, kept, absent))
        event = self.store.event
        there, back = event(lost, gained, kept, absent), event(gained, lost, kept, absent)
        return Toggle(transition, flags, there, back, self.store.condition(so, no))

    @memoized
    def toggling(
        self, transitions: frozenset[int] | None = None, but: tuple[Element, ...] = ()
    ) -> list[Toggle]:
        """The toggles of some transitions, of all by default, without those of some flags."""
        return [
            toggle
            for t, toggle in self.toggles.items()
            if toggle.flags.isdisjoint(but) and (transitions is None or t in transitions)
        ]


def _idle_events(mission_net: MissionNet) -> Iterator[tuple[int, What, str]]:
    """The events of hardware that nobody uses: transition, what happens, the resource."""
    initial = mission_net.in_service
    for t, event in mission_net.net.events.pairs:
        if event.what in HARDWARE:
            needed = mission_net.net.needs(t)
            if event.what is not What.OUT_OF_SERVICE or all(initial[p] for p, _ in needed):
                yield t, event.what, event.element


def idle_places(mission_net: MissionNet) -> dict[int, tuple[Element, bool]]:
    """The places that encode the status that sections hand on, in the net of a mission or of a part of it.

    Returns:
        By place that follows a status while nobody uses its element: a flag, and whether the place is marked
        where the flag is false.
    """
    net, places = mission_net.net, dict[int, tuple[Element, bool]]()
    initial = mission_net.in_service
    completion, marking = Completion(net), list(initial)
    for t, what, name in _idle_events(mission_net):
        if what is What.OUT_OF_SERVICE:
            net.fire_in_place(marking, t)
            fired = [net.transitions[u] for u in (t, *completion.settle(marking, [t]))]
            for place in {p for one in fired for p, _ in (*one.consume, *one.produce)}:
                if marking[place] != initial[place]:
                    places[place] = ("hardware", name), bool(initial[place])
                    marking[place] = initial[place]
    # Dying changes nothing else: see :func:`mcpn.drawing.permanent_loss.mortal`.
    for flag in (flag for status in mission_net.statuses for flag in status.flags):
        for said, reverse in zip(mission_net.flag_places(flag), (False, True), strict=True):
            places |= dict.fromkeys(said, (flag.element, reverse))
    return places
