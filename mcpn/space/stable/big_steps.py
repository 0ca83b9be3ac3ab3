"""Big steps: what events make of stable states, internal evolution included, each an event of the store.

A big step applies to every stable marking that marks certain places and leaves certain others empty. It is
computed from one such marking, by running the event to completion; the places that were read on the way are
its condition, and all markings that agree on them behave alike. So few big steps cover many states, and no
transient marking is kept. Each is tried in enough orders of internal transitions to prove that the event has
one outcome in all of these markings (:mod:`mcpn.space.stable.completion`).

Big steps of an event that fit one state make the same of it. Together they are a decision diagram over what
they do to each level of the store (``kernel/src/diagrams/choices.cpp``).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property, partial
from itertools import chain
from typing import Literal, TypeAlias

from mcpn._kernel import BigSteps as KernelSteps
from mcpn._kernel import MemoryLimit, StateLimit, Zdd, choices
from mcpn.space.algebra import Guards
from mcpn.space.diagrams.encoding import Encoding, distinct
from mcpn.space.diagrams.spaces import DiagramAlternatives, Step
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY, SymbolicSpace
from mcpn.space.markings.explicit import KernelNet

Steps: TypeAlias = Mapping[int, bytes | None]
"""By transition its big steps, on the levels of a store; ``None`` where its firing is all that happens."""

MOST_STEPS = 200_000
"""Big steps of all events together."""
MOST_KEPT = 100_000
"""Transient markings that the proof may keep behind one event."""


def reach_in_big_steps(prepared: KernelNet, encoding: Encoding) -> tuple[Zdd, dict[int, bytes]] | None:
    """The stable states of a net, and the big steps between them.

    Args:
        prepared: A net with priorities.
        encoding: It, or the same with more places, which are empty, on the levels of a store.

    Returns:
        The states, and the big steps by transition; ``None`` where there are too many big steps, or some
        event has no outcome or may have two.
    """
    try:
        return _reach(prepared, encoding)
    except (MemoryLimit, StateLimit):
        return None


def _reach(prepared: KernelNet, encoding: Encoding) -> tuple[Zdd, dict[int, bytes]] | None:
    """As :func:`reach_in_big_steps`, but a limit of the kernel that is hit is an error."""
    net, store, count = prepared.net, encoding.store, len(prepared.net.places)
    kernel = KernelSteps(
        prepared.kernel,
        prepared.initial,
        [place if place < count else -1 for place in encoding.places],
        [(place, encoding.level[kept]) for place, kept in encoding.partner.items() if place < count],
        DEFAULT_MEMORY,
        MOST_KEPT,
    )
    events = [(label, t) for label, t in enumerate(prepared.transitions) if not net.transitions[t].internal]
    steps: dict[int, bytes] = {}
    known: dict[int, list[int]] = {}  # conditions that tell where an event's big steps are known
    ahead: list[int] = []
    reached = fresh = kernel.start(store)
    left = MOST_STEPS
    while fresh:
        for label, t in events:
            safe = net.safe_transitions[t]
            asked = encoding.restricted(fresh, (*safe.consume, *safe.read)).without(known.setdefault(t, []))
            if not asked:
                continue
            covering = kernel.cover(asked, label, left)
            if covering is None:
                return None
            ways, count = covering
            left -= count
            steps[t] = steps.get(t, b"") + ways
            ahead += choices(store, ways, "ahead", ())
            known[t] += choices(store, ways, "where", ())
        assert reached is not None, "there is a fresh state"
        wider = reached.saturate(ahead)
        fresh, reached = wider - reached, wider
    return None if reached is None else (reached, steps)


class BigStepSpace(DiagramAlternatives):
    """The alternatives graph of a net by the big steps of its events.

    Args:
        space: Its stable states.
        steps: The big steps, on the levels of its store.
        also: By transition, levels that must be marked, too.
    """

    def __init__(self, space: SymbolicSpace, steps: Steps, also: Mapping[int, Collection[int]]) -> None:
        super().__init__(space)
        self._steps, self._also = steps, also

    @cached_property
    def _ahead(self) -> Mapping[int, list[int]]:
        """By transition, events of the store."""
        return self._events("ahead", self.encoding.events)

    @cached_property
    def _back(self) -> Mapping[int, list[int]]:
        """By transition, events that undo it."""
        return self._events("back", self.encoding.undoing)

    def _events(self, way: Literal["ahead", "back"], alone: Mapping[int, int]) -> Mapping[int, list[int]]:
        store, also = self.encoding.store, self._also
        return {
            t: [alone[t]] if of is None else choices(store, of, way, sorted(also.get(t, ())))
            for t, of in self._steps.items()
        }

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        free, guarded = self._asked(self._ahead, transitions, guards)
        targets = states.images(free)
        for events, where in guarded:
            targets |= (states & where).images(events)
        return targets

    def before(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States with an edge into some states."""
        free, guarded = self._asked(self._back, transitions, guards)
        found = states.images(free, within=self.everything)
        for events, where in guarded:
            found |= states.images(events, within=where)
        return found

    def ahead(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """Steps on along a set: any number of all unguarded events, and one of each that has a guard."""

        def step(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return (states & where).images(events, within=along)

        free, guarded = self._asked(self._ahead, transitions, guards)
        some = [partial(step, events=events, where=where) for events, where in guarded]
        return [lambda states: states.saturate(free, within=along), *some]

    def back(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """Steps back along a set: any number of all unguarded events, and one of each that has a guard."""

        def step(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return states.images(events, within=where & along)

        free, guarded = self._asked(self._back, transitions, guards)
        some = [partial(step, events=events, where=where) for events, where in guarded]
        return [lambda states: states.saturate(free, within=along | states), *some]

    def _asked(
        self, events: Mapping[int, list[int]], transitions: Collection[int] | None, guards: Guards[Zdd]
    ) -> tuple[list[int], list[tuple[list[int], Zdd]]]:
        """Events of transitions that are asked for and have no guard, and of those that have one, with it."""
        asked = [t for t in events if transitions is None or t in transitions]
        free = chain.from_iterable(events[t] for t in asked if not guards or t not in guards)
        guarded = [(events[t], guards[t] & self.everything) for t in asked if guards and t in guards]
        return distinct(free), guarded
