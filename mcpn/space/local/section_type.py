"""One type of sections: its local states, their steps and closures, and its interface to other sections.

A set of local states is a diagram over the places of the local net and the slots of the hardware beside it;
the section's own slots are open in it. What is computed once for a set serves every section of the type.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from functools import cached_property
from typing import Concatenate, NamedTuple, ParamSpec, TypeVar

from mcpn._kernel import Zdd
from mcpn.errors import LimitError, PremiseError
from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.diagrams.spaces import DiagramAlternatives
from mcpn.space.diagrams.symbolic import SymbolicSpace, chained
from mcpn.space.local.layout import Layout
from mcpn.space.stable.alternatives import AlternativesGraph, direct

Exit = str
"""The role of the place that a section marks when it ends: ``success``, ``failure``, or a handler's."""


class Allowed(NamedTuple):
    """What edges may carry, as a type of sections sees it.

    Args:
        local: Event transitions of the local net; ``None`` for all.
        beside: Transitions of the whole net, of hardware beside the section; ``None`` for all.
        guards: Event transitions of the local net that may be taken from some states only, with these.
    """

    local: frozenset[int] | None = None
    beside: frozenset[int] | None = None
    guards: tuple[tuple[int, Zdd], ...] = ()


ALL = Allowed()

Given = ParamSpec("Given")
Found = TypeVar("Found")
Asked = Callable[Concatenate["SectionType", Given], Found]


def remembered(compute: Asked[Given, Found]) -> Asked[Given, Found]:
    """Makes a method that keeps what it has found, for all sections of the type."""

    def method(type_: SectionType, /, *given: Given.args, **named: Given.kwargs) -> Found:
        key = compute, *given
        if key not in type_.known:
            type_.known[key] = compute(type_, *given, **named)
        return type_.known[key]  # type: ignore[return-value]

    method.__doc__ = compute.__doc__
    return method


class SectionType:
    """One type of sections.

    Args:
        part: The section that stands for the type.
        net: Its local net.
        explored: Its reachable markings, from every state of its hardware, on a store of their own.
        layout: The store of the composite.

    Attributes:
        graph: The alternatives graph of the local net, with the hardware beside it in any state.
        size: The number of stable states of the local net.
        before: The states before the section is entered.
        ended: By exit, the states after the section.
        inside: The states of the section itself.
    """

    def __init__(self, part: LocalPart, net: MissionNet, explored: SymbolicSpace, layout: Layout) -> None:
        self.part = part
        self.net = net
        self.layout = layout
        self.faulty = part.faulty
        self.known: dict[Hashable, object] = {}
        self.encoding = Encoding(net.net, explored.places, explored.encoding.memory_limit, layout.store)
        assert explored.stable is not None, "nets of missions have priorities"
        self.size = explored.stable.count()
        reachable, stable = (
            layout.opened(layout.store.from_bytes(states.to_bytes()), layout.all_slots)
            for states in (explored.reachable, explored.stable)
        )
        order = explored.order, explored.places
        self.graph = DiagramAlternatives(
            SymbolicSpace(self.encoding, reachable, stable, *order, explored.peak_nodes)
        )
        self.before = self.encoding.marking_all([net.beginning], stable)
        self.ended = {e: self.encoding.marking_all([place], stable) for e, place in net.exits.items()}
        self.inside = stable - self.before
        for states in self.ended.values():
            self.inside -= states

    # --- steps and closures: inside the section, or from inside to its ends ---

    @remembered
    def fired(self, levels: tuple[int, ...]) -> list[tuple[int, frozenset[int], Exit | None]]:
        """The events of a local state: each with the stable state after it, and its exit if it has one."""
        found = []
        for edge in self.graph.edges(levels):
            after, marks = frozenset(edge.target), self.encoding.marks
            exit_ = next((e for e, place in self.net.exits.items() if marks(after, place)), None)
            found.append((edge.transition, after, exit_))
        return found

    @remembered
    def after(self, states: Zdd, allowed: Allowed) -> Zdd:
        """States, inside or at the ends, one event of the section after some states inside."""
        return self.graph.after(states, allowed.local, dict(allowed.guards))

    @remembered
    def _ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return self.graph.ending(goal)

    @remembered
    def before_step(self, goal: Zdd, allowed: Allowed) -> Zdd:
        """States inside with an event of the section that leads to a goal, inside or at the ends."""
        if not goal or allowed.local == frozenset():
            return self.layout.store.empty()
        return self.inside & self.graph.firing_into(self._ending(goal), allowed.local, dict(allowed.guards))

    @remembered
    def crossing(self, among: Zdd, goal: Zdd) -> list[tuple[int, Zdd]]:
        """Event transitions that lead from some states inside to a goal, each with the states before."""
        ending, undoing = self._ending(goal), self.encoding.undoing
        ways = ((t, ending.images([undoing[t]], within=among)) for t in sorted(self.graph.waiting))
        return [(t, states) for t, states in ways if states]

    @remembered
    def toggling(self, among: Zdd, goal: Zdd, own: tuple[str, ...]) -> list[tuple[int, Zdd]]:
        """The same of transitions of the whole net, of hardware beside a section with some own hardware."""
        ways = ((t.transition, goal.images([t.undo], within=among)) for t in self.layout.beside(None, own))
        return [(t, states) for t, states in ways if states]

    @remembered
    def reached(self, begin: Zdd, along: Zdd, allowed: Allowed) -> Zdd:
        """States to which runs through a set of states inside lead from some of them."""
        steps = self.graph.ahead(along, allowed.local, dict(allowed.guards))
        beside = [toggle.event for toggle in self.layout.beside(allowed.beside)]
        return chained(begin & along, [*steps, lambda states: states.saturate(beside, within=along)])

    @remembered
    def reaching(self, goal: Zdd, along: Zdd, allowed: Allowed) -> Zdd:
        """States from which runs through a set of states inside lead to a goal, inside or at the ends."""
        within = along | goal
        steps = self.graph.back(along, allowed.local, dict(allowed.guards))
        beside = [toggle.undo for toggle in self.layout.beside(allowed.beside)]
        return chained(goal, [*steps, lambda states: states.saturate(beside, within=within) & within])

    # --- entry and exits: the status of all hardware is handed from section to section, in slots ---

    @remembered
    def entered(self, before: Zdd) -> Zdd:
        """First states inside after the section is entered in some states before it."""
        return self.graph.settled(before.images([self.encoding.events[self.net.start]]))

    @remembered
    def entries(self, inside: Zdd) -> Zdd:
        """States before the section in which it is entered in some states inside."""
        return self.graph.ending(inside).images([self.encoding.undoing[self.net.start]], within=self.before)

    @remembered
    def to_slots(self, states: Zdd, own: Sequence[str], exit_: Exit | None) -> Zdd:
        """The states of all hardware in some idle local states.

        Args:
            states: States before the entry, or after an exit.
            own: The section's hardware that can fail, in the order of the type's.
            exit_: The exit; ``None`` for states before the entry.
        """
        found = states.subset(unmarked=self.layout.slots_of(own))
        for ways in self._ways(own):
            found = found.images([to for to, _ in ways])
        return found.images([self.layout.store.event(self._idle(exit_), [])])

    @remembered
    def from_slots(self, hardware: Zdd, own: Sequence[str], exit_: Exit | None) -> Zdd:
        """The idle local states, before the entry or after an exit, with all hardware in some states."""
        found = hardware.images([self.layout.store.event([], self._idle(exit_))])
        for ways in self._ways(own):
            found = found.images([back for _, back in ways])
        return self.layout.opened(found, self.layout.slots_of(own))

    def _idle(self, exit_: Exit | None) -> list[int]:
        """Marked levels before the entry, or after an exit, with all hardware in service."""
        marking = list(self.net.net.initial)
        if exit_ is not None:
            marking[self.net.beginning], marking[self.net.exits[exit_]] = 0, 1
        return self.encoding.marked_levels(marking)

    @cached_property
    def _patterns(self) -> list[list[frozenset[int]]]:
        """By own hardware and its status, what is marked of the levels that its status decides."""
        found = []
        for name in self.faulty:
            states = [self._alone(name, status) for status in range(len(self.layout.roles) + 1)]
            always = states[0].intersection(*states)
            found.append([state - always for state in states])
        return found

    def _alone(self, name: str, status: int) -> frozenset[int]:
        """Marked levels before the entry with one resource in a status, and all others in service."""
        marked, unmarked = list[int](), list[int]()
        for other in self.faulty:
            for number, role in enumerate(self.layout.roles):
                level, reverse = self.encoding.bit(self.net.by_role[role, other][0])
                (marked if (other == name and number < status) != reverse else unmarked).append(level)
        state = self.before.subset(marked, unmarked).pick()
        assert state is not None, "before the entry hardware may be in any state"
        return self._local(state)

    def _local(self, state: Sequence[int]) -> frozenset[int]:
        return frozenset(level for level in state if level < self.layout.first_slot)

    @remembered
    def _ways(self, own: Sequence[str]) -> list[list[tuple[int, int]]]:
        """By own hardware and status: the event that moves the status to its slots, and the one back."""
        found = []
        for name, states in zip(own, self._patterns, strict=True):
            slots, levels, ways = self.layout.slots[name], frozenset().union(*states), []
            for status, marked in enumerate(states):
                lost, gained = marked - states[0], [*states[0] - marked, *slots[:status]]
                read, zero = marked & states[0], [*levels - marked - states[0], *slots[status:]]
                event = self.layout.store.event
                ways.append((event([*lost], gained, [*read], zero), event(gained, [*lost], [*read], zero)))
            found.append(ways)
        return found

    def check_premise(self, section: str, explored: SymbolicSpace) -> None:
        """Checks that a section hands on the status of its hardware and nothing else.

        Args:
            section: The section's name, for the error.
            explored: The markings of its local net, on a store of their own.

        Raises:
            PremiseError: Some place differs at an end of the section, or before it, from the idle marking.
        """
        any_status = self.layout.opened(self.layout.store.singleton([]), self.layout.all_slots)
        for exit_, states in ((None, self.before), *self.ended.items()):
            state = (states - self.from_slots(any_status, self.faulty, exit_)).pick()
            if state is not None:
                levels = self._local(state) ^ frozenset(self._idle(exit_))
                hardware = frozenset[int]().union(*(marked for known in self._patterns for marked in known))
                first = min(self.encoding.places[level] for level in (levels - hardware) or levels)
                space = DiagramAlternatives(explored)
                run = space.run(space.initial.pick() or (), space.single(sorted(self._local(state))))
                events = [str(self.net.net.transitions[edge.transition].event) for edge in run or ()]
                raise PremiseError(section, self.net.net.places[first].name, events)

    # --- listed one by one ---

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
