"""One type of sections: its local states, and its interface to the sections before and after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.errors import LimitError, PremiseError
from mcpn.space.diagrams.spaces import DiagramAlternatives
from mcpn.space.diagrams.symbolic import SymbolicSpace
from mcpn.space.local.local_states import Exit, LocalStates
from mcpn.space.stable.alternatives import AlternativesGraph, direct


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


class SectionType(LocalStates):
    """Local states, with what is handed from section to section: the state of all hardware, in slots.

    Args:
        part: The section that stands for the type.
        net: Its local net.
        explored: Its reachable markings, from every state of its hardware, on a store of their own.
        layout: The store of the composite.
    """

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
        return self.remembered(("entered", before), lambda: self.graph.settled(before.images([start])))

    def entries(self, inside: Zdd, own: Sequence[str]) -> Zdd:
        """The states of all hardware with which the section is entered in some states inside."""
        start = self.encoding.undoing[self.net.start]
        before = self.remembered(
            ("entries", inside), lambda: self.graph.ending(inside).images([start], within=self.before)
        )
        return self.to_slots(before, own)

    def listed(self, section: str, max_states: int, why: str) -> AlternativesGraph:
        """The stable states of the local net, one by one.

        Args:
            section: The section's name, for the error.
            max_states: How many states may be listed.
            why: What needs the list, for the error.

        Raises:
            LimitError: There are more states than allowed; the message says how many.
        """
        self.refuse_list(section, max_states, why)
        # The composite has proved what the mission reaches confluent.
        return direct(self.net.net, proof=False, max_states=max_states)

    def refuse_list(self, section: str, max_states: int, why: str) -> None:
        """Raises the error of :meth:`listed` without a list."""
        if self.size > max_states:
            found = f"section {section} has {self.size:,} states: {why}"
            raise LimitError(f"{found}, the limit is {max_states:,} (--max-states)")

    def check_premise(self, section: str, explored: SymbolicSpace) -> None:
        """Checks that a section hands on the state of its hardware and nothing else.

        Args:
            section: The section's name, for the error.
            explored: The markings of its local net, on a store of their own.

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
                raise PremiseError(section, self.net.net.places[first].name, _run_to(explored, state))


def _run_to(explored: SymbolicSpace, state: Sequence[int]) -> list[str]:
    """The events of a shortest run of a local net to a stable state, given as its marked levels."""
    space = DiagramAlternatives(explored)
    run = space.run(space.initial.pick() or (), space.single(state))
    return [str(space.net.transitions[edge.transition].event) for edge in run or ()]
