"""Names of one section as those of another of the same type."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import chain
from typing import Literal, NamedTuple, TypeAlias

from mcpn._kernel import Store, Zdd, clustered
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.sections import Element, LocalPart
from mcpn.mission.conditions import all_flags, flags
from mcpn.mission.expansion.faults import noticed
from mcpn.mission.flatten import ElementarySection, Section
from mcpn.mission.graph import names_in
from mcpn.nets.events import What
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY
from mcpn.spaces.memoized import memoized
from mcpn.spaces.run import Completion


class Renaming:
    """From the names in one section to those in another of the same type.

    Args:
        old: The section that the names are of.
        new: The other section.

    Attributes:
        activities: By name in the old section.
        alternatives: As ``activity.alternative``.
        hardware: By name.
        once: Handlers that happen once, by where they are written.
        facts: What may be true of facts (:attr:`LocalPart.flags`), and of hardware that is detected late.
        objectives: By name, blocks and branches with them.
        elements: All of them, with software and parallel blocks, each with its kind.
    """

    def __init__(self, old: LocalPart, new: LocalPart) -> None:
        both = list(zip(old.used.activities, new.used.activities, strict=True))
        self.activities = {theirs.name: mine.name for theirs, mine in both}
        self.alternatives = {
            f"{theirs.name}.{a.name}": f"{mine.name}.{b.name}"
            for theirs, mine in both
            for a, b in zip(theirs.alternatives, mine.alternatives, strict=True)
        }
        self.hardware = {a.name: b.name for a, b in zip(old.used.hardware, new.used.hardware, strict=True)}
        self.once = dict(zip(old.once, new.once, strict=True))
        self.facts = dict(zip(old.flags, new.flags, strict=True))
        late = zip(old.used.late, new.used.late, strict=True)
        self.facts |= {noticed(theirs): noticed(mine) for theirs, mine in late}
        sections = zip(old.graph.sections, new.graph.sections, strict=True)
        self.objectives = {
            its: own for pair in sections for its, own in zip(*map(names_in, pair), strict=True)
        }
        software = zip(old.used.software, new.used.software, strict=True)
        by_kind = {
            "hardware": self.hardware,
            "once": self.once,
            "fact": {a.name: b.name for a, b in zip(old.facts, new.facts, strict=True)},
            "software": {a.name: b.name for a, b in software},
            "activity": self.activities,
            "alternative": self.alternatives,
        }
        self.elements: dict[Element, Element] = {
            (kind, name): (kind, mine) for kind, names in by_kind.items() for name, mine in names.items()
        } | renamed_sections(old, new)


def renamed_sections(old: LocalPart, new: LocalPart) -> dict[Element, Element]:
    """From the objectives and blocks of a part to those of another of the same type."""
    both = zip(old.graph.all_sections(), new.graph.all_sections(), strict=True)
    return {(kind_of(theirs), theirs.name): (kind_of(mine), mine.name) for theirs, mine in both}


def kind_of(section: Section) -> str:
    """What the provenances of a section's places call it."""
    return "objective" if isinstance(section, ElementarySection) else "parallel"


# The diagram store of a composite: one for all sections, so that sets pass from section to section.
#
# The first levels hold the places of the local net of one section; all sections use the same levels. The last
# levels, the *slots*, hold the status that sections hand on: for each hardware resource of the mission
# whether it is out of service (and lost for good, where hardware may die), for each handler that happens once
# whether it has happened, for each fact what is true of it, and for hardware that is detected late whether it
# is known to be out of service. A section keeps the status of its own hardware and handlers in places of its
# local net. Its diagrams leave the slots of these unconstrained, so that sections of one type have equal
# diagrams whatever their hardware is called.

Said: TypeAlias = Literal["oos", "dead", "happened", "fact", "known"]

HARDWARE: tuple[Said, ...] = ("oos", "dead")
"""What the slots of a resource say, as the roles of places that say so; the second implies the first."""

ONCE: tuple[Said, ...] = ("happened",)
"""What the slot of a handler that happens once says."""

FACT: tuple[Said, ...] = ("fact",)
"""What the slot of a truth value of a fact says (:func:`mcpn.mission.conditions.flags`)."""

KNOWN: tuple[Said, ...] = ("known",)
"""What the slot of hardware that is detected late says besides: that its loss is known."""

CHANGES = {What.OUT_OF_SERVICE: (0, 1), What.REPAIRED: (1, 0), What.LOST: (1, 2)}
"""By event of hardware, its status before and after: how many of its slots are marked."""


class Toggle(NamedTuple):
    """What a resource, or a fact, may do while nobody uses it."""

    transition: int  # of the whole net
    elements: frozenset[Element]
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
        once: All its handlers that happen once.
        flags: What may be true of its facts.
        late: All hardware of the mission that is detected late.
        said: By kind of element, what its slots say.
        slots: By element, its slots.
    """

    def __init__(self, mission_net: MissionNet, places: int) -> None:
        self.mission_net = mission_net
        faulty = set(mission_net.saying("oos").values())
        self.hardware = tuple(h.name for h in mission_net.mission.hardware if h.name in faulty)
        self.once = tuple(mission_net.graph.once())
        facts = mission_net.usage.world.facts
        self.flags = tuple(flag for fact in facts.values() for flag in all_flags(fact))
        self.said = {
            "hardware": tuple(role for role in HARDWARE if mission_net.saying(role)),
            "once": ONCE,
            "fact": FACT,
            "known": KNOWN,
        }
        self.first_slot = end = places
        self.slots: dict[Element, range] = {}
        self.late = tuple(h.name for h in mission_net.mission.late)
        # What is said of one resource stands together: apart it makes diagrams large.
        pairs = ((kind, name) for name in self._standing() for kind in ("hardware", "known"))
        elements = [(kind, name) for kind, name in pairs if kind != "known" or name in self.late]
        elements += [("once", name) for name in self.once]
        elements += [("fact", flag) for flag in self.flags]
        for kind, name in elements:
            begin, end = end, end + len(self.said[kind])
            self.slots[kind, name] = range(begin, end)
        self.store = Store(end, DEFAULT_MEMORY)

    def _standing(self) -> list[str]:
        """The order in which slots of hardware stand: where some of it is a crash or a common cause, by use.

        A section often ends because what one alternative consumes has failed, or what another one does. Sets
        of such states are small where the two stand apart and each stands together; a crash, or a common
        cause, is declared far from the hardware that is consumed with it.
        """
        mission, number = self.mission_net.mission, {name: i for i, name in enumerate(self.hardware)}
        if not mission.faults and not mission.crashes:
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
        """Places of the whole net that say, while nobody uses it, what a slot of an element says, or not."""
        places = idle_places(self.mission_net).items()
        return {place: (self.slots[element][number], reverse) for place, (element, number, reverse) in places}

    @cached_property
    def all_slots(self) -> tuple[int, ...]:
        """The slots of all elements."""
        return self.slots_of([*self.slots])

    def slots_of(self, elements: Sequence[Element]) -> tuple[int, ...]:
        """The slots of some elements."""
        return tuple(chain.from_iterable(self.slots[element] for element in elements))

    def opened(self, states: Zdd, slots: Iterable[int]) -> Zdd:
        """The set with some slots, which are unmarked in it, left unconstrained."""
        return states.saturate([self.store.event([], [slot]) for slot in slots])

    @cached_property
    def toggles(self) -> dict[int, Toggle]:
        """What each resource does while nobody uses it, by the transition of the whole net."""
        by_transition: dict[int, Toggle] = {}
        for t, what, name in _idle_events(self.mission_net):
            elements = frozenset(
                element for element in (("hardware", name), ("known", name)) if element in self.slots
            )
            slots, known = self.slots["hardware", name], self.slots.get(("known", name), range(0))
            before, after = CHANGES[what]
            lost, gained = [*slots[after:before]], [*slots[before:after]]
            marked, unmarked = [*slots[: min(before, after)]], [*slots[max(before, after) :]]
            if what is What.REPAIRED:
                lost += known  # nobody repairs what is not known to be out of service
            elif what is What.OUT_OF_SERVICE:
                unmarked += known
            event, condition = self.store.event, self.store.condition
            events = event(lost, gained, marked, unmarked), event(gained, lost, marked, unmarked)
            by_transition[t] = Toggle(t, elements, *events, condition([*lost, *marked], [*gained, *unmarked]))
        return by_transition | {toggle.transition: toggle for toggle in self._events_of_facts()}

    def _events_of_facts(self) -> Iterator[Toggle]:
        """What declared events do to facts."""
        net = self.mission_net.net
        said = self.mission_net.saying("fact")
        for t, transition in enumerate(net.transitions):
            if transition.event is None or transition.provenance is None:
                continue  # nothing, or what facts have become is forgotten
            if transition.provenance.kind != "fact":
                continue
            before = self._slots_true(said[p] for p, _ in (*transition.consume, *transition.read))
            after = self._slots_true(said[p] for p, _ in (*transition.produce, *transition.read) if p in said)
            names = {said[p].partition("=")[0] for p, _ in (*transition.consume, *transition.read)}
            facts = self.mission_net.usage.world.facts
            elements = frozenset(("fact", flag) for name in names for flag in all_flags(facts[name]))
            slots = {*self.slots_of([*elements])}
            lost, gained, kept = before - after, after - before, before & after
            event = self.store.event
            away = slots - before - after
            yield Toggle(
                t,
                elements,
                event(sorted(lost), sorted(gained), sorted(kept), sorted(away)),
                event(sorted(gained), sorted(lost), sorted(kept), sorted(away)),
                self.store.condition(sorted(before), sorted(slots - before)),
            )

    def _slots_true(self, values: Iterable[str]) -> set[int]:
        """The slots that are marked where facts have some values, each as ``fact=value``."""
        facts, slots = self.mission_net.usage.world.facts, set[int]()
        for said in values:
            name, _, value = said.partition("=")
            slots |= {*self.slots_of([("fact", flag) for flag in flags(facts[name])[value]])}
        return slots

    @memoized
    def toggling(
        self, transitions: frozenset[int] | None = None, but: tuple[Element, ...] = ()
    ) -> list[Toggle]:
        """The toggles of some transitions, of all by default, without those of some elements."""
        return [
            toggle
            for t, toggle in self.toggles.items()
            if toggle.elements.isdisjoint(but) and (transitions is None or t in transitions)
        ]


def _idle_events(mission_net: MissionNet) -> Iterator[tuple[int, What, str]]:
    """The events of hardware that nobody uses: transition, what happens, the resource."""
    initial = mission_net.in_service
    for t, transition in enumerate(mission_net.net.transitions):
        if transition.event is not None and (what := transition.event.what) in CHANGES:
            needed = (*transition.consume, *transition.read)
            if what is not What.OUT_OF_SERVICE or all(initial[p] for p, _ in needed):
                yield t, what, transition.event.element


def _crashed_places(mission_net: MissionNet) -> Iterator[tuple[str, tuple[int, ...]]]:
    """The resources that stand for crashes, each with the places that say that it has crashed."""
    for name in dict.fromkeys(mission_net.saying("ready").values()):
        yield name, mission_net.by_role["oos", name]


def idle_places(mission_net: MissionNet) -> dict[int, tuple[Element, int, bool]]:
    """The places that encode the status that sections hand on, in the net of a mission or of a part of it.

    Returns:
        By place that follows the status of hardware while nobody uses it, of a handler that happens once, or
        of a fact: the element, the number of the slot among its slots, and whether the place is marked where
        the slot is not.
    """
    net, places = mission_net.net, dict[int, tuple[Element, int, bool]]()
    facts = mission_net.usage.world.facts
    initial = mission_net.in_service
    completion, marking = Completion(net), list(initial)
    for t, what, name in _idle_events(mission_net):
        if what is What.OUT_OF_SERVICE:
            net.fire_in_place(marking, t)
            fired = [net.transitions[u] for u in (t, *completion.settle(marking, [t]))]
            for place in {p for one in fired for p, _ in (*one.consume, *one.produce)}:
                if marking[place] != initial[place]:
                    places[place] = ("hardware", name), 0, bool(initial[place])
                    marking[place] = initial[place]
    for name, out in _crashed_places(mission_net):  # there is no crash while nobody uses the resource
        places |= dict.fromkeys(out, (("hardware", name), 0, False))
        places |= dict.fromkeys(mission_net.by_role["ready", name], (("hardware", name), 0, True))
    # Dying changes nothing else: see :func:`mcpn.drawing.mortal.mortal`.
    for role, kind, number, reverse in (
        ("dead", "hardware", 1, False),
        ("alive", "hardware", 1, True),
        ("happened", "once", 0, False),
        ("open", "once", 0, True),
        ("known", "known", 0, False),
        ("presumed", "known", 0, True),
    ):
        for place, name in mission_net.saying(role).items():
            places[place] = (kind, name), number, reverse
    for place, said in mission_net.saying("fact").items():
        first, *others = all_flags(facts[said.partition("=")[0]])
        reverse = bool(net.initial[place])
        places[place] = ("fact", first if reverse or not others else said), 0, reverse
    return places
