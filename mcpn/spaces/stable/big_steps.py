"""Big steps: an event with the internal evolution after it, as one event of the store on stable states.

A big step applies to every stable marking that marks certain places and leaves certain others empty. It is
computed from one such marking, by running the event to completion; the places that were read on the way are
its condition, and all markings that agree on them behave alike. So few big steps cover many states, and no
transient marking is kept. Each is tried in enough orders of internal transitions to prove that the event has
one outcome in all of these markings (:mod:`mcpn.spaces.stable.run_to_completion`).

An event that concerns all branches of a mission has a product of big steps. It is run to completion from
whole sets of states, and what it makes of them is one function (``kernel/src/markings/set_evolution.cpp``).

Big steps of an event that fit one state make the same of it. Together they are a decision diagram over what
they do to each level of the store (``kernel/src/diagrams/choices.cpp``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from functools import cached_property, partial
from itertools import chain
from typing import Literal, TypeAlias

from mcpn._kernel import BigSteps as KernelSteps
from mcpn._kernel import BudgetExceeded, Firings, MemoryLimit, StateLimit, Zdd, choices
from mcpn.spaces.algebra import Guards
from mcpn.spaces.diagrams.closing import chained
from mcpn.spaces.diagrams.encoding import Encoding, distinct
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, Step
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY
from mcpn.spaces.markings.explicit import KernelNet

Steps: TypeAlias = Mapping[int, bytes | None]
"""By transition its big steps, on the levels of a store; ``None`` where its firing is all that happens."""

FUNCTION = b"\xff\xff\xff\xff"
"""The first number of big steps that are one function of states: no list of them has so many entries."""
MOST_STEPS = 200_000
"""Big steps of all events together."""
MOST_SINGLY = 20_000
"""Those that are found one by one before all markings are tried, which may be reached far sooner."""
FEW_STEPS = 8
"""Big steps of one event that are found one by one, and that saturation fires: of more, which may tell all
branches apart, it is run from whole sets of states."""
FEW_CASES = 100
"""Cases that may tell where a transition may fire alone, before it is asked of whole sets of states."""
MANY_EVENTS = 30
"""Events that are run together; fewer mostly lead to different states, and each has a smaller diagram."""
MOST_KEPT = 100_000
"""Transient markings that the proof may keep behind one event."""


def is_function(steps: bytes) -> bool:
    """Whether big steps are encoded as one function of states, and not as a list."""
    return steps[:4] == FUNCTION


def has_many(steps: bytes) -> bool:
    """Whether big steps are more than saturation fires, or one function."""
    if is_function(steps):
        return True
    numbers = memoryview(steps).cast("I")
    at = count = 0
    while at < len(numbers) and count <= FEW_STEPS:
        at += 1 + numbers[at]
        count += 1
    return count > FEW_STEPS


def reach_in_big_steps(
    prepared: KernelNet, encoding: Encoding, few: int | None = None, most: int | None = None
) -> tuple[Zdd, dict[int, bytes]] | None:
    """The stable states of a net, and the big steps between them.

    Args:
        prepared: A net with priorities.
        encoding: It, or the same with more places, which are empty, on the levels of a store.
        few: Big steps of one event that are found one by one before it is run from whole sets of states; by
            default :data:`FEW_STEPS`.
        most: Big steps of all events that are found one by one; by default :data:`MOST_SINGLY`.

    Returns:
        The states, and the big steps by transition; ``None`` where there are too many big steps, or some
        event has no outcome or may have two.
    """
    try:
        return _reach(
            prepared,
            encoding,
            FEW_STEPS if few is None else few,
            MOST_SINGLY if most is None else most,
        )
    except (MemoryLimit, StateLimit):
        return None


def _reach(
    prepared: KernelNet, encoding: Encoding, few: int, most: int
) -> tuple[Zdd, dict[int, bytes]] | None:
    """As :func:`reach_in_big_steps`, but a limit of the kernel that is hit is an error."""
    count = len(prepared.net.places)
    kernel = KernelSteps(
        prepared.kernel,
        prepared.initial,
        [place if place < count else -1 for place in encoding.places],
        [(place, encoding.level[kept]) for place, kept in encoding.partner.items() if place < count],
        DEFAULT_MEMORY,
        MOST_KEPT,
        FEW_CASES,
    )
    return _Reaching(prepared, encoding, kernel, few, most).search()


class _Reaching:
    """A search for all stable states.

    The big steps of an event are found one by one, until they are many. From then on it is run to completion
    from whole sets of states, and what it makes of each set is one function of its states. States from which
    it cannot be run so are told apart, and its big steps from these are found one by one.

    Args:
        prepared: A net with priorities.
        encoding: It on the levels of a store.
        kernel: The same in the kernel.
        few: Big steps of an event that are not yet many.
        most: Big steps of all events that are found one by one.
    """

    def __init__(
        self, prepared: KernelNet, encoding: Encoding, kernel: KernelSteps, few: int, most: int
    ) -> None:
        self._few = few
        net = prepared.net
        self._events = [
            (label, t) for label, t in enumerate(prepared.transitions) if not net.transitions[t].internal
        ]
        self._safe = net.safe_transitions
        self._encoding, self._kernel = encoding, kernel
        self._steps: dict[int, bytes] = {}
        self._known: dict[int, list[int]] = {t: [] for _, t in self._events}
        """By transition, the conditions under which its big steps are known."""
        self._ahead: dict[int, list[int]] = {}
        self._found: dict[int, int] = {}
        """By transition, how many big steps were found one by one."""
        self._left = most
        self._covered: dict[int, Zdd] = {}
        """By transition whose big steps are found one by one, the states of which they are found."""
        self._done: dict[int, Zdd] = {}
        """By transition that is run from whole sets of states, the last one."""
        self._fired: dict[int, tuple[Zdd, Firings, int]] = {}
        """By transition that is run so, where it was run from, what fired, and in which evolution."""
        self._evolutions = 0
        self._alone = 0
        """Steps of the store that the last event took that was run from a whole set alone."""
        self._together = True
        """Whether events are run together, which is quicker where they lead to the same."""

    def search(self) -> tuple[Zdd, dict[int, bytes]] | None:
        """All stable states and the big steps between them, as :func:`reach_in_big_steps` finds them.

        An event is asked of what the events before it have just led to: so one round follows a row of
        objectives to its end. Those that are run from whole sets come when the others lead to nothing more.
        """
        reached = self._kernel.start(self._encoding.store)
        if reached is None:
            return None
        begun = reached - reached
        while reached != begun:
            begun = reached
            for label, t in self._events:
                if t not in self._done:
                    after = self._after(label, t, reached)
                    if after is None:
                        return None
                    reached |= after
            all_ = self._after_all(self._closed(reached))
            if all_ is None:
                return None
            reached = self._closed(all_)
        return (reached, self._steps) if self._made_functions() else None

    def _after(self, label: int, t: int, states: Zdd) -> Zdd | None:
        """The states after an event from those not asked yet; ``None`` where it has no outcome."""
        fresh = states - self._covered[t] if t in self._covered else states
        if not fresh:
            return fresh
        if not self._cover_few(label, t, fresh):
            return None
        if t in self._done:
            return states - states
        self._covered[t] = states
        return fresh.images(self._ahead.get(t, []))

    def _closed(self, states: Zdd) -> Zdd:
        """Some states, and those to which the big steps that were found one by one lead from them."""

        def images(states: Zdd, events: list[int]) -> Zdd:
            return states.images(events)

        many = [t for t, found in self._found.items() if found > FEW_STEPS]
        few = [*chain.from_iterable(ahead for t, ahead in self._ahead.items() if t not in many)]
        each = (partial(images, events=self._ahead[t]) for t in many)
        return chained(states, [lambda some: some.saturate(few), *each])

    def _enabling(self, states: Zdd, t: int) -> Zdd:
        """Those of some states in which an event may happen and no big step of it is known."""
        enabling = self._encoding.restricted(states, (*self._safe[t].consume, *self._safe[t].read))
        return enabling.without(self._known[t])

    def _cover_few(self, label: int, t: int, states: Zdd) -> bool:
        """Finds big steps one by one; where they are too many, the event is run from whole sets from now on.

        Returns:
            False where they tell of no outcome, or no more may be found.
        """
        asked = self._enabling(states, t)
        most = min(self._few, self._left)
        covering = self._kernel.cover(asked, label, most) if asked else (b"", 0, True)
        if covering is None:
            return False
        ways, count, complete = covering
        if complete:
            self._keep(t, ways, count)
        elif most < self._left:
            self._done[t] = self._encoding.store.empty()
            self._known[t] = []
            self._steps.pop(t, None), self._ahead.pop(t, None), self._found.pop(t, None)
            complete = True
        return complete

    def _cover(self, label: int, t: int, asked: Zdd) -> bool:
        """Finds the big steps from some states one by one; false where there are too many, or no outcome."""
        covering = self._kernel.cover(asked, label, self._left)
        if covering is None:
            return False
        ways, count, complete = covering
        if complete:
            self._keep(t, ways, count)
        return complete

    def _keep(self, t: int, ways: bytes, count: int) -> None:
        if not count:
            return
        store = self._encoding.store
        self._left -= count
        self._found[t] = self._found.get(t, 0) + count
        self._steps[t] = self._steps.get(t, b"") + ways
        self._ahead.setdefault(t, []).extend(choices(store, ways, "ahead", ()))
        self._known[t] += choices(store, ways, "where", ())

    def _after_all(self, reached: Zdd) -> Zdd | None:
        """Some states and those after all events that are run from whole sets, but for big steps.

        When one has been run, all are run together, unless that takes long beside it.

        Returns:
            ``None`` where one has no outcome.
        """
        done = [(label, t) for label, t in self._events if t in self._done]
        for number, (label, t) in enumerate(done):
            if not (asked := self._asked(reached, t)):
                continue
            states = reached
            after = self._after_alone(label, t, asked)
            if after is None:
                return None
            reached |= after
            self._done[t] = states
            rest = [(other, u, where) for other, u in done[number + 1 :] if (where := self._asked(states, u))]
            if self._together and len(rest) >= MANY_EVENTS:
                more = self._after_together([(label, t, asked), *rest], states)
                if more is not None:
                    return reached | more
                self._together = False
        return reached

    def _asked(self, states: Zdd, t: int) -> Zdd:
        """States from which an event is run, none where it has been run from all.

        They are not the fresh ones alone: whole sets have smaller diagrams.
        """
        fresh = self._enabling(states - self._done[t], t)
        return self._enabling(states, t) if fresh else fresh

    def _after_alone(self, label: int, t: int, asked: Zdd) -> Zdd | None:
        """The states after an event from some; ``None`` where it has no outcome."""
        found = self._kernel.after(asked, label)
        self._alone = self._encoding.store.steps
        if found is None:
            return None
        after, left, firings = found
        if left and not self._cover(label, t, left):
            return None
        self._evolutions += 1
        self._fired[t] = (asked - left, firings, self._evolutions)
        return after

    def _after_together(self, events: list[tuple[int, int, Zdd]], states: Zdd) -> Zdd | None:
        """The states after some events, whose internal evolution is run once behind all of them.

        Args:
            events: The events, and from which states each is run.
            states: All states that are reached.

        Returns:
            ``None`` where it takes more than half of what all might alone, as the last one did, or an
            event cannot be run so from some states.
        """
        try:
            starts = [(where, label) for label, _, where in events]
            found = self._kernel.after_together(starts, max(self._alone * len(events) // 2, 1))
        except BudgetExceeded:
            return None
        if found is None or any(left for left, _ in found[1]):
            return None
        self._evolutions += 1
        for (_, t, where), (_, firings) in zip(events, found[1], strict=True):
            self._done[t], self._fired[t] = states, (where, firings, self._evolutions)
        return found[0]

    def _made_functions(self) -> bool:
        """Makes functions of what fired from whole sets; false where even big steps are too many."""
        labels = {t: label for label, t in self._events if t in self._fired}
        together = Counter(number for *_, number in self._fired.values())
        for t in sorted(labels, key=lambda t: self._fired[t][2]):  # those of one evolution in a row
            asked, firings, number = self._fired[t]
            if not asked:
                continue
            # What is made of many sets at once has few parts of these sets, and rarely of all that are wider.
            wide = not self._known[t] and together[number] == 1
            function = self._kernel.function(asked, firings, wide=wide)
            if function is not None:
                self._steps[t] = function + self._steps.get(t, b"")
            elif not self._cover(labels[t], t, asked):
                return False
        return True


class BigStepSpace(DiagramAlternatives):
    """The alternatives graph of a net by the big steps of its events.

    Args:
        space: Its stable states.
        steps: The big steps, on the levels of its store.
        also: By transition, levels that must be marked besides the conditions of its big steps.
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
            t: [alone[t]] if steps is None else choices(store, steps, way, sorted(also.get(t, ())))
            for t, steps in self._steps.items()
        }

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        free, guarded = self._asked(self._ahead, transitions, guards)
        states &= self.everything  # functions may be of more
        targets = states.images(distinct(chain.from_iterable(free.values())))
        for events, where in guarded:
            targets |= (states & where).images(events)
        return targets

    def leading_into(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """All states with an edge into some states."""
        free, guarded = self._asked(self._back, transitions, guards)
        sources = states.images(distinct(chain.from_iterable(free.values())), within=self.everything)
        for events, where in guarded:
            sources |= states.images(events, within=where)
        return sources

    def ahead(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """Steps on along a set: any number of unguarded events of few big steps, one of each other event."""

        def step(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return (states & where).images(events, within=along)

        free, guarded = self._asked(self._ahead, transitions, guards)
        some = [partial(step, events=events, where=where) for events, where in guarded]
        few, many = self._saturated(free)
        each = [partial(Zdd.images, events=events, within=along) for events in many]
        return [lambda states: states.saturate(few, within=along), *each, *some]

    def back(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """Steps back along a set, as :meth:`ahead` takes them on; what comes late in the mission first."""

        def step(states: Zdd, events: list[int], where: Zdd) -> Zdd:
            return states.images(events, within=where & along)

        free, guarded = self._asked(self._back, transitions, guards)
        some = [partial(step, events=events, where=where) for events, where in guarded]
        few, many = self._saturated(free)
        each = [partial(Zdd.images, events=events, within=along) for events in reversed(many)]
        return [lambda states: states.saturate(few, within=along | states), *each, *some]

    def _saturated(self, free: Mapping[int, list[int]]) -> tuple[list[int], list[list[int]]]:
        """Events that are saturated together; and those of each transition that has many big steps."""
        few = chain.from_iterable(events for t, events in free.items() if t not in self._many)
        return distinct(few), [events for t, events in free.items() if t in self._many]

    @cached_property
    def _many(self) -> frozenset[int]:
        return frozenset(t for t, steps in self._steps.items() if steps is not None and has_many(steps))

    def _asked(
        self, events: Mapping[int, list[int]], transitions: Collection[int] | None, guards: Guards[Zdd]
    ) -> tuple[Mapping[int, list[int]], list[tuple[list[int], Zdd]]]:
        """Events by transition of those asked for that have no guard, and of those that have one, with it."""
        asked = [t for t in events if transitions is None or t in transitions]
        free = {t: events[t] for t in asked if not guards or t not in guards}
        guarded = [(events[t], guards[t] & self.everything) for t in asked if guards and t in guards]
        return free, guarded
