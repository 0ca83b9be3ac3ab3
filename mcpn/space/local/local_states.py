"""The local states of one type of sections on the store of a composite: sets, steps and closures.

A set of local states is a diagram over the places of the local net and the slots of the hardware beside it;
the section's own slots are open in it. What is computed once for a set serves every section of the type.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TypeVar

from mcpn._kernel import Zdd
from mcpn.net.compose import MissionNet
from mcpn.net.petri import Marking
from mcpn.net.sections import LocalPart
from mcpn.space.diagrams.encoding import Encoding, distinct
from mcpn.space.diagrams.symbolic import SymbolicSpace, chained, elements
from mcpn.space.local.layout import Layout
from mcpn.space.run import Completion

Exit = str
"""The role of the place that a section marks when it ends: ``success``, ``failure``, or a handler's."""

Known = TypeVar("Known")


@dataclass(frozen=True, slots=True)
class Allowed:
    """What edges may carry, as a type of sections sees it; hashable, so that results are remembered.

    Args:
        local: Event transitions of the local net; ``None`` for all.
        beside: Events of hardware beside the section, as pairs (resource, kind); ``None`` for all.
        guards: Event transitions of the local net that may be taken from some states only, with these.
    """

    local: frozenset[int] | None = None
    beside: frozenset[tuple[str, str]] | None = None
    guards: tuple[tuple[int, Zdd], ...] = ()


ALL = Allowed()


class LocalStates:
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
        self.completion = Completion(net.net)
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
        return self.net.exits

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

    def _local(
        self, events: Mapping[int, int], allowed: Allowed, groups: list[list[int]]
    ) -> list[tuple[list[int], Zdd]]:
        """Events of the store for groups of transitions that are allowed, with where to take them from."""

        def compute() -> list[tuple[list[int], Zdd]]:
            guarded = dict(allowed.guards)
            found: list[tuple[list[int], Zdd]] = []
            for of in groups:
                wanted = [t for t in of if allowed.local is None or t in allowed.local]
                free = distinct(events[t] for t in wanted if t not in guarded)
                if free:
                    found.append((free, self.inside))
                found += [([events[t]], guarded[t]) for t in wanted if t in guarded]
            return found

        return self.remembered((id(events), allowed, len(groups)), compute)

    def _beside(self, allowed: Allowed, *, undone: bool) -> list[int]:
        """Events of the store for what hardware beside the section does, or what undoes it."""
        return beside(self.layout, allowed, undone=undone)

    def settled(self, after: Zdd) -> Zdd:
        """The stable markings in which internal evolution ends."""
        return after.saturate(self.encoding.internal) & self.stable

    def ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return self.remembered(
            ("ending", goal), lambda: goal.saturate(self.encoding.internal_back, within=self.reachable)
        )

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

    def fired(self, levels: tuple[int, ...]) -> list[tuple[int, Marking, list[int], Exit | None]]:
        """The events of a local state: each with the stable marking after it, its levels, and its exit."""

        def compute() -> list[tuple[int, Marking, list[int], Exit | None]]:
            marking, found = self.encoding.marking(levels), []
            for t in self.net.net.enabled(marking):
                _, after = self.completion.after(marking, t)
                exit_ = next((e for e, place in self.ends.items() if after[place]), None)
                found.append((t, after, self.encoding.marked_levels(after), exit_))
            return found

        return self.remembered(("fired", levels), compute)

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
            begun = self.layout.store.empty()
            for events, where in self._local(self.encoding.events, allowed, [self._every]):
                begun |= (states & where).images(events)
            return self.settled(begun)

        return self.remembered(("after", states, allowed), compute)

    def before_step(self, goal: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States inside with an event of the section that leads to a goal, inside or at the ends."""

        def compute() -> Zdd:
            found = self.layout.store.empty()
            for events, where in self._local(self.encoding.undoing, allowed, [self._every]):
                ending = self.ending(goal)
                found |= ending.images(events, within=where)
            return found & self.inside

        return self.remembered(("before", goal, allowed), compute)

    def crossing(self, among: Zdd, goal: Zdd) -> list[tuple[int, Zdd]]:
        """Event transitions that lead from some states inside to a goal, each with the states before."""

        def compute() -> list[tuple[int, Zdd]]:
            ending, undoing = self.ending(goal), self.encoding.undoing
            ways = ((t, ending.images([undoing[t]], within=among)) for t in sorted(self._every))
            return [(t, states) for t, states in ways if states]

        return self.remembered(("crossing", among, goal), compute)

    def reached(self, begin: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States to which runs through a set of states inside lead from some of them."""

        def ahead(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.settled((states & where).images(events)) & along

        def compute() -> Zdd:
            steps = [
                partial(ahead, events=events, where=where)
                for events, where in self._local(self.encoding.events, allowed, self._by_element)
            ]
            toggles = self._beside(allowed, undone=False)
            return chained(begin & along, [*steps, lambda states: states.saturate(toggles, within=along)])

        return self.remembered(("reached", begin, along, allowed), compute)

    def reaching(self, goal: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States from which runs through a set of states inside lead to a goal, inside or at the ends."""
        within = along | goal

        def back(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return self.ending(states).images(events, within=where & along)

        def compute() -> Zdd:
            steps = [
                partial(back, events=events, where=where)
                for events, where in self._local(self.encoding.undoing, allowed, self._by_element)
            ]
            toggles = self._beside(allowed, undone=True)
            return chained(goal, [*steps, lambda states: states.saturate(toggles, within=within) & within])

        return self.remembered(("reaching", goal, along, allowed), compute)


def beside(layout: Layout, allowed: Allowed, *, undone: bool, but: Collection[str] = ()) -> list[int]:
    """Events of the store for what idle hardware does, or what undoes it.

    Args:
        layout: The store.
        allowed: Which of them are wanted.
        undone: Whether those are wanted that undo it.
        but: Hardware whose events are not wanted.
    """
    key = allowed.beside, undone, tuple(but)
    if key not in layout.known:
        layout.known[key] = [
            pair[undone]
            for name in layout.hardware
            if name not in but
            for kind, pair in layout.toggles(name).items()
            if allowed.beside is None or (name, kind) in allowed.beside
        ]
    return layout.known[key]
