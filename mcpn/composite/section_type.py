"""One type of sections: its local states, their steps and closures, and its interface to other sections.

A set of local states is a diagram over the places of the local net and the slots of the hardware beside it;
the section's own slots are open in it. What is computed once for a set serves every section of the type.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

from mcpn._kernel import Zdd
from mcpn.composite.explored_section import Explored
from mcpn.composite.layout import Layout, idle_places
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.forgetful import Guard, forgetful
from mcpn.drawing.sections import LocalPart
from mcpn.drawing.status import Element
from mcpn.errors import LimitError, PremiseError
from mcpn.nets.relaxed import relaxed
from mcpn.spaces.algebra import Edge
from mcpn.spaces.diagrams.closing import chained
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.memoized import memoized
from mcpn.spaces.stable.run_to_completion import MAX_STABLE_STATES

if TYPE_CHECKING:
    from mcpn.spaces.stable.alternatives import AlternativesGraph

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

    @property
    def own(self) -> tuple[frozenset[int] | None, dict[int, Zdd]]:
        """The transitions of the local net, and their guards, as its alternatives graph is asked."""
        return self.local, dict(self.guards)


ALL = Allowed()


class _Move(NamedTuple):
    """What is done with the slot of one element as a status becomes states, and as states become one.

    Args:
        lost: Levels of an idle state that are marked where the slot is not.
        gained: Levels that are marked where it is.
        slot: The slot, alone.
        taking: The event that makes of a marked slot the levels of the local net, alone.
        handing: Its reverse, alone.
    """

    lost: Sequence[int]
    gained: Sequence[int]
    slot: Sequence[int]
    taking: Sequence[int]
    handing: Sequence[int]


class SectionType:
    """One type of sections.

    Args:
        part: The section that stands for the type.
        net: Its local net.
        explored: What is known of it, on a store of its own.
        layout: The store of the composite.

    Attributes:
        steps: The big steps of the local net; ``None`` where it has none.
        graph: The alternatives graph of the local net, with the hardware beside it in any state.
        size: The number of stable states of the local net, whatever has happened once.
        before: The states before the section is entered.
        ended: By exit, the states after the section.
        inside: The states of the section itself.
    """

    def __init__(self, part: LocalPart, net: MissionNet, explored: Explored, layout: Layout) -> None:
        self.part = part
        self.net = net
        self.layout = layout
        self.carried = layout.carried(part)
        self.steps = explored.steps
        space = explored.space
        self.encoding = Encoding(net.net, space.places, space.encoding.memory_limit, layout.store)
        assert space.stable is not None, "nets of missions have priorities"
        self.size = self._forgetting(space.encoding, space.stable).count()
        self.graph = explored.on(self.encoding, partial(layout.opened, slots=layout.all_slots))
        stable = self.graph.everything
        self.before = self.encoding.restricted(stable, [net.beginning])
        self.ended = {e: self.encoding.restricted(stable, [place]) for e, place in net.exits.items()}
        self.inside = stable - self.before
        for states in self.ended.values():
            self.inside -= states

    def _forgetting(self, encoding: Encoding, stable: Zdd) -> Zdd:
        """Stable states as if what happens once had not happened yet."""
        by_role = self.net.by_role
        for name in self.part.once:
            open_, happened = (by_role[role, name][0] for role in ("open", "happened"))
            after = encoding.restricted(stable, [happened])
            stable = (stable - after) | after.images([encoding.event((happened,), (open_,), ())])
        return stable

    @cached_property
    def carrying(self) -> tuple[int, ...]:
        """The transitions of the local net that carry an event."""
        return tuple(sorted(t for t, _ in self.net.net.events.pairs))

    @memoized
    def fired(self, levels: tuple[int, ...]) -> list[tuple[Edge, Exit | None]]:
        """The edges of a local state by its own events, each with the exit that it leads to if it does."""
        exits, marks, edges = self.net.exits.items(), self.encoding.marks, self.graph.edges(levels)
        return [(edge, next((e for e, p in exits if marks(edge.target, p)), None)) for edge in edges]

    @memoized
    def after(self, states: Zdd, allowed: Allowed) -> Zdd:
        """States, inside or at the ends, one event of the section after some states inside."""
        return self.graph.after(states, *allowed.own)

    @memoized
    def before_step(self, goal: Zdd, allowed: Allowed) -> Zdd:
        """States inside with an event of the section that leads to a goal, inside or at the ends."""
        if not goal or allowed.local == frozenset():
            return self.layout.store.empty()
        return self.inside & self.graph.before(goal, *allowed.own)

    @memoized
    def forth(self, part: Zdd, allowed: Allowed, own: tuple[Element, ...]) -> Zdd:
        """States inside one event after some of them: of the section, or of hardware beside it."""
        toggled = part.images([toggle.event for toggle in self.layout.toggling(allowed.beside, own)])
        return (self.after(part, allowed) & self.inside) | toggled

    @memoized
    def backward(self, part: Zdd, allowed: Allowed, own: tuple[Element, ...]) -> Zdd:
        """States inside one event before some of them: of the section, or of hardware beside it."""
        toggled = part.images([toggle.undo for toggle in self.layout.toggling(allowed.beside, own)])
        return self.before_step(part, allowed) | toggled

    @memoized
    def enabling(self, states: Zdd, allowed: Allowed, own: tuple[Element, ...]) -> Zdd:
        """Those of some states inside with an event: of the section, or of hardware beside it."""
        beside = [toggle.condition for toggle in self.layout.toggling(allowed.beside, own)]
        return (states & self.graph.enabling(allowed.local or ())) | (states - states.without(beside))

    @memoized
    def may_end(self, local: frozenset[int] | None) -> bool:
        """Whether one of some events of the section, of all by default, leads to an end of it."""
        return local is None or any(map(self._ends, local))

    @memoized
    def _ends(self, transition: int) -> bool:
        after = self.graph.after(self.inside, [transition])
        return any(after & ended for ended in self.ended.values())

    @memoized
    def may_lead_to(self, left_out: frozenset[int]) -> frozenset[Exit]:
        """The exits that runs without some events of the section may lead to, and maybe others."""
        transitions = self.net.net.safe_transitions
        at_first = (place for place, tokens in enumerate(self.net.net.initial) if tokens)
        needs = {t: count for t, count in enumerate(self._needed) if t not in left_out}
        marked, _ = relaxed(at_first, needs, self._users, lambda t: transitions[t].produce)
        return frozenset(exit_ for exit_, place in self.net.exits.items() if place in marked)

    @cached_property
    def _needed(self) -> list[int]:
        """By transition of the local net, how many places must be marked for it."""
        return [len(t.consume) + len(t.read) for t in self.net.net.safe_transitions]

    @cached_property
    def _users(self) -> list[list[int]]:
        """By place of the local net, the transitions for which it must be marked."""
        users: list[list[int]] = [[] for _ in self.net.net.places]
        for t, each in enumerate(self.net.net.safe_transitions):
            for place in (*each.consume, *each.read):
                users[place].append(t)
        return users

    @memoized
    def crossing(
        self, among: Zdd, goal: Zdd, own: tuple[Element, ...]
    ) -> tuple[Mapping[int, Zdd], Mapping[int, Zdd]]:
        """The states of some inside from which each event leads to a goal, inside or at the ends.

        Returns:
            Two mappings: by event transition of the local net; and by transition of the whole net, for the
            hardware beside the section (``own`` are its own elements).
        """
        local = {t: self.graph.before(goal, [t]) & among for t in self.graph.waiting}
        beside = {t.transition: goal.images([t.undo], within=among) for t in self.layout.toggling(None, own)}
        return {t: s for t, s in local.items() if s}, {t: s for t, s in beside.items() if s}

    @memoized
    def firings(self, states: Zdd, own: tuple[Element, ...]) -> tuple[Mapping[int, int], Mapping[int, int]]:
        """How many of some states enable each event: the section's own, and those of hardware beside it."""
        beside = self.layout.toggling(None, own)
        counts = states.counts([toggle.condition for toggle in beside])
        return self.graph.firings(states), {t.transition: n for t, n in zip(beside, counts, strict=True)}

    @memoized
    def reached(self, begin: Zdd, along: Zdd, allowed: Allowed) -> Zdd:
        """States to which runs through a set of states inside lead from some of them."""
        steps = self.graph.ahead(along, *allowed.own)
        beside = [toggle.event for toggle in self.layout.toggling(allowed.beside)]
        return chained(begin & along, [*steps, lambda states: states.saturate(beside, within=along)])

    @memoized
    def reaching(self, goal: Zdd, along: Zdd, allowed: Allowed) -> Zdd:
        """States from which runs through a set of states inside lead to a goal, inside or at the ends."""
        if not along:
            return goal
        within = along | goal
        steps = self.graph.back(along, *allowed.own)
        beside = [toggle.undo for toggle in self.layout.toggling(allowed.beside)]
        return chained(goal, [*steps, lambda states: states.saturate(beside, within=within) & within])

    @memoized
    def entered(self, status: Zdd, own: tuple[int, ...]) -> Zdd:
        """First states inside after the section is entered with all elements in some status, in slots."""
        return self.graph.after(self.from_slots(status, own, None), [self.net.start])

    @memoized
    def entries(self, inside: Zdd, own: tuple[int, ...]) -> Zdd:
        """The status of all elements, in slots, with which the section is entered in some states inside."""
        return self.to_slots(self.graph.before(inside, [self.net.start]) & self.before, own, None)

    @memoized
    def leave(self, part: Zdd, own: tuple[int, ...], allowed: Allowed) -> Mapping[Exit, Zdd]:
        """By exit, the status of all elements, in slots, where one event has ended some states inside."""
        after = self.after(part, allowed)
        ended = ((exit_, after & states) for exit_, states in self.ended.items())
        return {exit_: self.to_slots(states, own, exit_) for exit_, states in ended if states}

    @memoized
    def marking(self, part: Zdd, level: int, unmarked: bool) -> Zdd:
        """Those of some states that mark a level, or that do not."""
        return part.subset(*(((), (level,)) if unmarked else ((level,), ())))

    @memoized
    def to_slots(self, states: Zdd, own: tuple[int, ...], exit_: Exit | None) -> Zdd:
        """Projects states before the entry, or after an exit, to the status of all elements, in slots."""
        status = states.subset(unmarked=own)
        for lost, gained, _, _, handing in self._moves(own):
            status = status.images(handing) | status.subset(lost, gained)
        return status.images([self._idle_events(exit_)[0]])

    @memoized
    def from_slots(self, status: Zdd, own: tuple[int, ...], exit_: Exit | None) -> Zdd:
        """The inverse of :meth:`to_slots`: the states before the entry, or after an exit, of a status."""
        states = status.images([self._idle_events(exit_)[1]])
        for _, _, slot, taking, _ in self._moves(own):
            if changed := states.images(taking):  # else no state has the slot marked
                states = changed | states.subset(unmarked=slot)
        return self.layout.opened(states, own)

    @memoized
    def ends(self, status: tuple[tuple[Exit, Zdd], ...], own: tuple[int, ...]) -> Zdd:
        """The states after some exits, each with all elements in some status."""
        states = self.layout.store.empty()
        for exit_, there in status:
            states |= self.from_slots(there, own, exit_)
        return states

    @memoized
    def ending(self, status: tuple[tuple[Exit, Zdd], ...], own: tuple[int, ...], allowed: Allowed) -> Zdd:
        """States inside with an event that leads to some exits, each with all elements in some status."""
        if not self.may_end(allowed.local):
            return self.layout.store.empty()
        return self.before_step(self.ends(status, own), allowed)

    @memoized
    def _moves(self, own: tuple[int, ...]) -> list[_Move]:
        """What is done with each own slot as a status becomes states, and as states become one."""
        event = self.layout.store.event
        return [
            _Move(lost, gained, [slot], [event([slot, *lost], gained)], [event(gained, [slot, *lost])])
            for number, lost, gained in self._changing
            for slot in [own[number]]
        ]

    @memoized
    def _idle_events(self, exit_: Exit | None) -> tuple[int, int]:
        """What unmarks all levels of an idle state, and what marks them."""
        idle, event = self._idle(exit_), self.layout.store.event
        return event(idle, []), event([], idle)

    def _idle(self, exit_: Exit | None) -> list[int]:
        """Marked levels before the entry, or after an exit, with all slots unmarked."""
        marking = list(self.net.net.initial)
        if exit_ is not None:
            marking[self.net.beginning], marking[self.net.exits[exit_]] = 0, 1
        return self.encoding.marked_levels(marking)

    @cached_property
    def _changing(self) -> list[tuple[int, list[int], list[int]]]:
        """Own slots by number, each with levels of an idle state: marked where it is not, and where it is.

        What is said of one resource comes together: where half of it is handed on, sets have large diagrams.
        """
        changes = {flag: (set[int](), set[int]()) for flag in self.carried}
        for place, (flag, reverse) in idle_places(self.net).items():
            level, opposite = self.encoding.bit(place)
            changes[flag][reverse == opposite].add(level)
        return [(i, sorted(lost), sorted(gained)) for i, (lost, gained) in enumerate(changes.values())]

    def check_premise(self, section: str, explored: Explored) -> None:
        """Checks on its local markings that a section hands on the status of its elements and nothing else.

        Raises:
            PremiseError: Some place differs at an end of the section, or before it, from the idle marking.
        """
        any_status = self.layout.opened(self.layout.store.singleton([]), self.layout.all_slots)
        own = self.layout.slots_of(self.carried)
        for exit_, states in ((None, self.before), *self.ended.items()):
            violation = (states - self.from_slots(any_status, own, exit_)).pick()
            if violation is not None:
                state = [level for level in violation if level < self.layout.first_slot]
                levels = {*state} ^ {*self._idle(exit_)}
                status = chain.from_iterable(changing for _, *changing in self._changing)
                levels = levels.difference(*status) or levels
                space = explored.alternatives()
                run = space.run(space.initial.pick() or (), space.single(state)) or []
                events = [str(self.net.net.transitions[edge.transition].event) for edge in run]
                first = min(self.encoding.places[level] for level in levels)
                raise PremiseError(section, self.net.net.places[first].name, events)

    @memoized
    def forgetful(self, kept: tuple[str, ...] = ()) -> tuple[MissionNet, Mapping[int, Guard]]:
        """The local net without what has happened once, some handlers aside, and its transitions' guards."""
        return forgetful(self.net, [handler for handler in self.part.once if handler not in kept])

    def listed(self, kept: tuple[str, ...] = (), max_states: int = MAX_STABLE_STATES) -> AlternativesGraph:
        """The stable states of that net, one by one."""
        from mcpn.spaces.stable.alternatives import direct  # which lists them in arrays

        # The composite has proved what the mission reaches confluent.
        most = max_states if self.part.once else self.size
        return direct(self.forgetful(kept)[0].net, proof=False, max_states=most)

    def refuse_list(self, section: str, max_states: int, why: str, option: str = "--max-states") -> None:
        """Refuses to list more states than a limit, for a reason that the error names.

        Raises:
            LimitError: There are more; the message says how many.
        """
        if self.size > max_states:
            sentence = f"section {section} has {self.size:,} states: {why}"
            raise LimitError(f"{sentence}, the limit is {max_states:,} ({option})")
