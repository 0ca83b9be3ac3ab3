"""One type of sections on the store of a composite: its local states, and steps and closures among them.

A set of local states is a diagram over the places of the local net and the slots of the hardware beside it;
the section's own slots are open in it. What is computed once for a set serves every section of the type.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeVar

from mcpn._kernel import Zdd
from mcpn.errors import SemanticsError
from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart
from mcpn.space.encoding import Encoding, distinct
from mcpn.space.local.layout import Layout
from mcpn.space.symbolic import SymbolicSpace, chained, elements

Exit = str
"""The role of the place that a section marks when it ends: ``success``, ``failure``, or a handler's."""

Known = TypeVar("Known")


class PremiseError(SemanticsError):
    """A section hands on more than the state of its hardware, so local graphs do not give the mission's.

    Args:
        section: The section's name.
        place: A place that differs at the section's exit from what it was at its entry.
    """

    def __init__(self, section: str, place: str) -> None:
        self.section = section
        self.place = place
        super().__init__(
            f"section {section} does not leave the place {place} as it was at its entry, so local graphs do "
            "not give the mission's: use --engine explicit or symbolic"
        )


@dataclass(frozen=True, slots=True)
class Allowed:
    """What edges may carry, as a type of sections sees it; hashable, so that results are remembered.

    Args:
        local: Event transitions of the local net; ``None`` for all.
        beside: Events of hardware beside the section, as pairs (resource, kind); ``None`` for all.
    """

    local: frozenset[int] | None = None
    beside: frozenset[tuple[str, str]] | None = None


ALL = Allowed()


@dataclass(frozen=True, slots=True)
class _Patterns:
    """What an idle resource marks in each of its states.

    Args:
        levels: Levels on which the states differ.
        in_service: Those marked in service.
        by_state: Those marked in each other state, by the state's bits.
    """

    levels: frozenset[int]
    in_service: frozenset[int]
    by_state: Mapping[tuple[int, ...], frozenset[int]]


class SectionType:
    """The local states of one type of sections.

    Args:
        part: The section that stands for the type.
        net: Its local net.
        explored: Its reachable markings, from every state of its hardware, on a store of their own.
        layout: The store of the composite.
    """

    def __init__(self, part: LocalPart, net: MissionNet, explored: SymbolicSpace, layout: Layout) -> None:
        self.part = part
        self.net = net
        self.layout = layout
        self.faulty = part.faulty
        self.encoding = Encoding(net.net, explored.places, explored.encoding.memory_limit, layout.store)
        assert explored.stable is not None, "nets of missions have priorities"
        self._reachable, self._stable = (
            layout.store.from_bytes(states.to_bytes()) for states in (explored.reachable, explored.stable)
        )
        self._known: dict[Hashable, object] = {}

    def remembered(self, key: Hashable, compute: Callable[[], Known]) -> Known:
        """What was computed for a key before, or is now."""
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]  # type: ignore[return-value]

    # --- sets ---

    def _opened(self, states: Zdd) -> Zdd:
        """Local states with hardware beside them in any state."""
        return self.layout.opened(states, self.layout.all_slots)

    @cached_property
    def reachable(self) -> Zdd:
        """Local markings, transient ones included, beside any state of the other hardware."""
        return self._opened(self._reachable)

    @cached_property
    def stable(self) -> Zdd:
        """Those that are stable."""
        return self._opened(self._stable)

    @cached_property
    def before(self) -> Zdd:
        """Stable states before the section is entered."""
        return self.encoding.marking_all([self.net.beginning], self.stable)

    @cached_property
    def ends(self) -> Mapping[Exit, int]:
        """By exit, the place that says that the section has ended so."""
        return {"success": self.net.success, "failure": self.net.failure}

    def _ended(self, stable: Zdd, exit_: Exit) -> Zdd:
        return self.encoding.marking_all([self.ends[exit_]], stable)

    @cached_property
    def ended(self) -> Mapping[Exit, Zdd]:
        """Stable states after the section, by its exit."""
        return {exit_: self._ended(self.stable, exit_) for exit_ in self.ends}

    @cached_property
    def inside(self) -> Zdd:
        """Stable states of the section itself."""
        found = self.stable - self.before
        for states in self.ended.values():
            found -= states
        return found

    @cached_property
    def size(self) -> int:
        """Number of stable states of the local net."""
        return self._stable.count()

    @cached_property
    def dead(self) -> Zdd:
        """States inside in which no event of the section is enabled."""
        return self.inside.without([c for t in self._every if (c := self.encoding.enabling[t]) is not None])

    # --- events ---

    @cached_property
    def _by_element(self) -> list[list[int]]:
        """Event transitions of the local net but for the start, by the element that they are of."""
        return [of for of in elements(self.encoding) if self.net.start not in of]

    @cached_property
    def _every(self) -> list[int]:
        return [t for of in self._by_element for t in of]

    def _local(self, events: Mapping[int, int], allowed: Allowed) -> list[list[int]]:
        """Events of the store for the local transitions that are allowed, element by element."""
        groups = (
            distinct(events[t] for t in of if allowed.local is None or t in allowed.local)
            for of in self._by_element
        )
        return [group for group in groups if group]

    def _beside(self, allowed: Allowed, *, undone: bool) -> list[int]:
        """Events of the store for what hardware beside the section does, or what undoes it."""
        return beside(self.layout, allowed, undone=undone)

    def settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return after.saturate(self.encoding.internal) & self.stable

    def ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return goal.saturate(self.encoding.internal_back, within=self.reachable)

    def enabling(self, allowed: Allowed) -> Zdd:
        """States inside with an event of the section that is allowed."""
        wanted = [t for t in self._every if allowed.local is None or t in allowed.local]
        conditions = [c for t in wanted if (c := self.encoding.enabling[t]) is not None]
        return self.inside - self.inside.without(conditions) if conditions else self.inside - self.inside

    def firings(self, states: Zdd) -> dict[int, int]:
        """In how many of some states inside each event transition of the local net is enabled."""
        wanted = [(t, c) for t in self._every if (c := self.encoding.enabling[t]) is not None]
        counts = states.counts([c for _, c in wanted])
        return {t: n for (t, _), n in zip(wanted, counts, strict=True) if n}

    def begun(self, inside: Zdd, entering: Zdd) -> Zdd:
        """Markings just after an event, before any internal firing.

        Args:
            inside: States inside, for the section's own events.
            entering: States before the entry, for the start.
        """
        events = self.encoding.events
        return inside.images(distinct(events[t] for t in self._every)) | entering.images(
            [events[self.net.start]]
        )

    # --- steps: inside the section, or from inside to its ends ---

    def after(self, states: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States, inside or at the ends, one event of the section after some states inside."""

        def compute() -> Zdd:
            events = [e for group in self._local(self.encoding.events, allowed) for e in group]
            return self.settled(states.images(events))

        return self.remembered(("after", states, allowed), compute)

    def before_step(self, goal: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States inside with an event of the section that leads to a goal, inside or at the ends."""

        def compute() -> Zdd:
            events = [e for group in self._local(self.encoding.undoing, allowed) for e in group]
            return self.ending(goal).images(events, within=self.inside)

        return self.remembered(("before", goal, allowed), compute)

    def reached(self, begin: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States to which runs through a set of states inside lead from some of them."""

        def ahead(states: Zdd, events: list[int]) -> Zdd:
            return self.settled(states.images(events)) & along

        def compute() -> Zdd:
            steps = [partial(ahead, events=group) for group in self._local(self.encoding.events, allowed)]
            toggles = self._beside(allowed, undone=False)
            return chained(begin & along, [*steps, lambda states: states.saturate(toggles, within=along)])

        return self.remembered(("reached", begin, along, allowed), compute)

    def reaching(self, goal: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States from which runs through a set of states inside lead to a goal, inside or at the ends."""

        def back(states: Zdd, events: list[int]) -> Zdd:
            return self.ending(states).images(events, within=along)

        def compute() -> Zdd:
            steps = [partial(back, events=group) for group in self._local(self.encoding.undoing, allowed)]
            toggles = self._beside(allowed, undone=True)
            return chained(
                goal, [*steps, lambda states: states.saturate(toggles, within=along | goal) & (along | goal)]
            )

        return self.remembered(("reaching", goal, along, allowed), compute)

    # --- the interface: states of all hardware in slots, and back ---

    @cached_property
    def _idle(self) -> list[int]:
        """Marked levels before the section is entered with all its hardware in service."""
        return self.encoding.marked_levels(self.net.net.initial)

    @cached_property
    def _patterns(self) -> list[_Patterns]:
        return [self._patterns_of(name) for name in self.faulty]

    def _patterns_of(self, name: str) -> _Patterns:
        found = {bits: self._alone(name, bits) for bits in self.layout.statuses()}
        idle = set(self._idle)
        differing = frozenset().union(*(marked ^ idle for marked in found.values()))
        return _Patterns(
            differing, differing & idle, {bits: differing & marked for bits, marked in found.items()}
        )

    def _alone(self, name: str, bits: tuple[int, ...]) -> frozenset[int]:
        """Marked levels before the entry with one resource in a state, and all others in service."""
        marked, unmarked = list[int](), list[int]()
        for other in self.faulty:
            for b, role in enumerate(self.layout.bits):
                level, reverse = self.encoding.bit(self.net.by_role[role, other][0])
                (marked if (other == name and b in bits) != reverse else unmarked).append(level)
        states = self._before.subset(sorted(marked), sorted(unmarked))
        state = states.pick()
        assert state is not None, "before the entry hardware may be in any state"
        return frozenset(state)

    @cached_property
    def _before(self) -> Zdd:
        """Stable states before the entry, with nothing beside them."""
        return self.encoding.marking_all([self.net.beginning], self._stable)

    def _ways(self, own: Sequence[str]) -> list[list[tuple[int, int]]]:
        """By own hardware and state but *in service*: the event to slots, and the one from slots."""

        def compute() -> list[list[tuple[int, int]]]:
            found = []
            for name, known in zip(own, self._patterns, strict=True):
                slots, ways = self.layout.slots[name], []
                for bits, marked in known.by_state.items():
                    told = [slots[b] for b in bits]
                    untold = [slot for slot in slots if slot not in told]
                    arcs = {
                        "read": marked & known.in_service,
                        "zero": known.levels - marked - known.in_service | {*untold},
                    }
                    lost, gained = known.in_service - marked, marked - known.in_service
                    ways.append(
                        (
                            self.layout.event([*gained], [*lost, *told], **arcs),
                            self.layout.event([*lost, *told], [*gained], **arcs),
                        )
                    )
                found.append(ways)
            return found

        return self.remembered(("ways", tuple(own)), compute)

    def _marked_idle(self, exit_: Exit | None) -> list[int]:
        """Marked levels before the entry, or after an exit, with all hardware in service."""
        if exit_ is None:
            return self._idle
        marking = list(self.net.net.initial)
        marking[self.net.beginning], marking[self.ends[exit_]] = 0, 1
        return self.encoding.marked_levels(marking)

    def to_slots(self, states: Zdd, own: Sequence[str], exit_: Exit | None = None) -> Zdd:
        """The states of all hardware in some idle local states.

        Args:
            states: States before the entry, or after an exit.
            own: The section's hardware that can fail, in the order of the type's.
            exit_: The exit; ``None`` for states before the entry.
        """

        def compute() -> Zdd:
            found = states.subset(unmarked=sorted(self.layout.slots_of(own)))
            for ways, known in zip(self._ways(own), self._patterns, strict=True):
                moved = found.images([to for to, _ in ways])
                found = moved | found.subset(
                    sorted(known.in_service), sorted(known.levels - known.in_service)
                )
            return found.images([self.layout.event(consume=self._marked_idle(exit_))])

        return self.remembered(("to slots", states, tuple(own), exit_), compute)

    def from_slots(self, hardware: Zdd, own: Sequence[str], exit_: Exit | None = None) -> Zdd:
        """The idle local states, before the entry or after an exit, with all hardware in some states."""

        def compute() -> Zdd:
            found = hardware.images([self.layout.event(produce=self._marked_idle(exit_))])
            for name, ways in zip(own, self._ways(own), strict=True):
                moved = found.images([back for _, back in ways])
                found = moved | found.subset(unmarked=sorted(self.layout.slots[name]))
            return self.layout.opened(found, self.layout.slots_of(own))

        return self.remembered(("from slots", hardware, tuple(own), exit_), compute)

    def entered(self, hardware: Zdd, own: Sequence[str]) -> Zdd:
        """First states inside after the section is entered with all hardware in some states."""
        before = self.from_slots(hardware, own)
        start = self.encoding.events[self.net.start]
        return self.remembered(("entered", before), lambda: self.settled(before.images([start])))

    def entries(self, inside: Zdd, own: Sequence[str]) -> Zdd:
        """The states of all hardware with which the section is entered in some states inside."""
        start = self.encoding.undoing[self.net.start]
        before = self.remembered(
            ("entries", inside), lambda: self.ending(inside).images([start], within=self.before)
        )
        return self.to_slots(before, own)

    def check_premise(self, section: str) -> None:
        """Checks that a section hands on the state of its hardware and nothing else.

        Args:
            section: The section's name, for the error.

        Raises:
            PremiseError: Some place differs at an end of the section, or before it, from the idle marking.
        """
        local = list(range(len(self.encoding.places)))
        for exit_ in (None, *self.ends):
            states = self._before if exit_ is None else self._ended(self._stable, exit_)
            idle = self.from_slots(self.layout.universe, self.faulty, exit_).onto(local)
            state = (states - idle).pick()
            if state is not None:
                expected = set(self._marked_idle(exit_))
                levels = set(state) ^ expected
                hardware = frozenset[int]().union(*(known.levels for known in self._patterns))
                first = min(self.encoding.places[level] for level in (levels - hardware) or levels)
                raise PremiseError(section, self.net.net.places[first].name)


def beside(layout: Layout, allowed: Allowed, *, undone: bool, but: Collection[str] = ()) -> list[int]:
    """Events of the store for what idle hardware does, or what undoes it.

    Args:
        layout: The store.
        allowed: Which of them are wanted.
        undone: Whether those are wanted that undo it.
        but: Hardware whose events are not wanted.
    """
    return [
        pair[undone]
        for name in layout.hardware
        if name not in but
        for kind, pair in layout.toggles(name).items()
        if allowed.beside is None or (name, kind) in allowed.beside
    ]
