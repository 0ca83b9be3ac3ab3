"""The local states of one type of sections on the store of a composite: sets, steps and closures.

A set of local states is a diagram over the places of the local net and the slots of the hardware beside it;
the section's own slots are open in it. What is computed once for a set serves every section of the type.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

from mcpn._kernel import Zdd
from mcpn.net.compose import MissionNet
from mcpn.net.sections import LocalPart
from mcpn.space.diagrams.encoding import Encoding, distinct
from mcpn.space.diagrams.spaces import DiagramAlternatives
from mcpn.space.diagrams.symbolic import SymbolicSpace, chained
from mcpn.space.local.layout import Layout

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
        reachable, self._stable = (
            layout.store.from_bytes(states.to_bytes()) for states in (explored.reachable, explored.stable)
        )
        # Hardware beside the section is in any state.
        whole, stable = (layout.opened(states, layout.all_slots) for states in (reachable, self._stable))
        order, peak = (explored.order, explored.places), explored.peak_nodes
        self.graph = DiagramAlternatives(SymbolicSpace(self.encoding, whole, stable, *order, peak))
        self.stable = self.graph.everything
        self._known: dict[Hashable, object] = {}

    def remembered(self, key: Hashable, compute: Callable[[], Known]) -> Known:
        """What was computed for a key before, or is now."""
        if key not in self._known:
            self._known[key] = compute()
        return self._known[key]  # type: ignore[return-value]

    # --- sets ---

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
        return self.inside & self.graph.dead

    # --- events ---

    def enabling(self, allowed: Allowed) -> Zdd:
        """States inside with an event of the section that is allowed."""
        return self.inside & self.graph.enabling(
            self.graph.waiting if allowed.local is None else allowed.local
        )

    def firings(self, states: Zdd) -> Mapping[int, int]:
        """In how many of some states inside each event transition of the local net is enabled."""
        return self.graph.firings(states)

    def fired(self, levels: tuple[int, ...]) -> list[tuple[int, frozenset[int], Exit | None]]:
        """The events of a local state: each with the stable state after it, and its exit if it has one."""

        def compute() -> list[tuple[int, frozenset[int], Exit | None]]:
            found = []
            for edge in self.graph.edges(levels):
                after = frozenset(edge.target)
                exit_ = next((e for e, place in self.ends.items() if self.encoding.marks(after, place)), None)
                found.append((edge.transition, after, exit_))
            return found

        return self.remembered(("fired", levels), compute)

    def begun(self, inside: Zdd, entering: Zdd) -> Zdd:
        """Markings just after an event, before any internal firing.

        Args:
            inside: States inside, for the section's own events.
            entering: States before the entry, for the start.
        """
        events = self.encoding.events
        own = distinct(event for t, event in events.items() if t in self.graph.waiting)
        return inside.images(own) | entering.images([events[self.net.start]])

    # --- steps: inside the section, or from inside to its ends ---

    def after(self, states: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States, inside or at the ends, one event of the section after some states inside."""

        def compute() -> Zdd:
            return self.graph.after(states, allowed.local, dict(allowed.guards))

        return self.remembered(("after", states, allowed), compute)

    def _ending(self, goal: Zdd) -> Zdd:
        """Markings from which internal evolution ends in a goal."""
        return self.remembered(("ending", goal), lambda: self.graph.ending(goal))

    def before_step(self, goal: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States inside with an event of the section that leads to a goal, inside or at the ends."""

        def compute() -> Zdd:
            if not goal or allowed.local == frozenset():
                return self.layout.store.empty()
            found = self.graph.firing_into(self._ending(goal), allowed.local, dict(allowed.guards))
            return found & self.inside

        return self.remembered(("before", goal, allowed), compute)

    def crossing(self, among: Zdd, goal: Zdd) -> list[tuple[int, Zdd]]:
        """Event transitions that lead from some states inside to a goal, each with the states before."""

        def compute() -> list[tuple[int, Zdd]]:
            ending, undoing = self._ending(goal), self.encoding.undoing
            ways = ((t, ending.images([undoing[t]], within=among)) for t in sorted(self.graph.waiting))
            return [(t, states) for t, states in ways if states]

        return self.remembered(("crossing", among, goal), compute)

    def reached(self, begin: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States to which runs through a set of states inside lead from some of them."""

        def compute() -> Zdd:
            steps = self.graph.ahead(along, allowed.local, dict(allowed.guards))
            toggles = self.layout.beside(allowed.beside, undone=False)
            return chained(begin & along, [*steps, lambda states: states.saturate(toggles, within=along)])

        return self.remembered(("reached", begin, along, allowed), compute)

    def reaching(self, goal: Zdd, along: Zdd, allowed: Allowed = ALL) -> Zdd:
        """States from which runs through a set of states inside lead to a goal, inside or at the ends."""
        within = along | goal

        def compute() -> Zdd:
            steps = self.graph.back(along, allowed.local, dict(allowed.guards))
            toggles = self.layout.beside(allowed.beside, undone=True)
            return chained(goal, [*steps, lambda states: states.saturate(toggles, within=within) & within])

        return self.remembered(("reaching", goal, along, allowed), compute)
