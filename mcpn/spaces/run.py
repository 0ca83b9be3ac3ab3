"""Runs of a net, completed with internal firings when they are read, and shortened.

A run through the alternatives graph names events only. What the net does between two events is completed by
the net's own rule, along one interleaving, since internal evolution is confluent there.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from functools import cached_property
from itertools import takewhile
from typing import TypeAlias

from mcpn.events import Event
from mcpn.nets.petri import Arcs, Marking, PetriNet
from mcpn.records import record
from mcpn.spaces.algebra import Edge, S, Space
from mcpn.spaces.memoized import ByKey

Concerned: TypeAlias = tuple[Sequence[tuple[int, int]], Sequence[int], Sequence[int]]

MOST_REPLAYS = 1_000
MOST_BESIDE = 50
"""A place that more internal transitions need is *crowded*: not all are tried when it receives a token."""


class Completion:
    """How a net evolves by itself: internal transitions fire until none is enabled, lowest ranks first.

    Only transitions that need a place which has just received a token are tried. Where many need it, as the
    gates of all sections that wait for one activity do, only those are tried whose rarest place is marked.

    Args:
        net: The net.
        once: Whether one run is completed, in which hardly anything happens twice: nothing is kept of it.
    """

    def __init__(self, net: PetriNet, *, once: bool = False) -> None:
        self.net = net
        # What each transition consumes or reads, and may have enabled, put together when first asked for.
        self.needs: Callable[[int], Arcs] = net.needs if once else ByKey(net.needs).__getitem__
        self.concerned: Callable[[int], Concerned] = (
            self._concerned if once else ByKey(self._concerned).__getitem__
        )
        self._queue = {
            net.ranks[transitions[0]]: number for number, transitions in enumerate(net.internal_ranks)
        }

    def settle(self, marking: list[int], fired: Iterable[int] | None = None) -> Iterator[int]:
        """The internal transitions fired until the marking is stable; it is changed in place.

        Args:
            marking: Where internal evolution begins; the caller knows that it ends.
            fired: The transitions that have led there from a stable marking, where some have.
        """
        return Evolution(self, marking, fired).settle()

    def after(self, marking: Marking, event: int) -> tuple[tuple[int, ...], Marking]:
        """What follows an event in a stable marking: the internal transitions fired, and the stable end."""
        changing = list(marking)
        self.net.fire_in_place(changing, event)
        return tuple(self.settle(changing, [event])), tuple(changing)

    def of_event(self, marking: Sequence[int], event: Event) -> int | None:
        """The first transition of an event that is enabled in a stable marking; ``None`` where none is."""
        return next((t for t in self.net.events.of(event) if self.net.covers(marking, t)), None)

    def _concerned(self, fired: int) -> Concerned:
        """What a firing may have enabled.

        Returns:
            Internal transitions, each after the number of its rank; crowded places that receive a token; and
            rarest places (:attr:`crowds`) whose tokens the firing changes.
        """
        users, (consume, produce, _) = self.net.internal_users, self.net.arcs(fired)
        places = {place for place, _ in produce}
        crowded = [place for place in places if place in self.crowds]
        few = {t for place in places.difference(crowded) for t in users.get(place, ())}
        touched = {place for place, _ in (*consume, *produce)}
        return self.queued(few), crowded, sorted(touched & self.rarer)

    def queued(self, transitions: Iterable[int]) -> list[tuple[int, int]]:
        """Internal transitions in their order, each after the number of its rank."""
        return [(self._queue[self.net.ranks[t]], t) for t in sorted(transitions)]

    @cached_property
    def crowds(self) -> Mapping[int, Mapping[int, Sequence[int]]]:
        """By crowded place, the internal transitions that need it, by their rarest place.

        It is mostly unmarked: of the objectives that start an activity, all of which wait for it to be idle,
        few run.
        """
        return self.net.crowds(MOST_BESIDE)

    @cached_property
    def rarer(self) -> Set[int]:
        """The rarest places of all transitions that need a crowded one."""
        return {place for by_rarest in self.crowds.values() for place in by_rarest}


class Evolution:
    """A marking that changes in place: by firings, and by run to completion after them.

    Args:
        completion: Of the net.
        marking: The marking.
        fired: The transitions that have led there from a stable marking, where some have.
    """

    def __init__(
        self, completion: Completion, marking: list[int], fired: Iterable[int] | None = None
    ) -> None:
        self.completion, self.marking = completion, marking
        self._since = None if fired is None else [completion.concerned(t) for t in fired]
        self._rarer = {place for place in completion.rarer if marking[place]}

    def fire(self, t: int) -> None:
        """Fires a transition; the caller has seen that it is enabled."""
        concerned = self._fire(t)
        if self._since is not None:
            self._since.append(concerned)

    def settle(self) -> Iterator[int]:
        """The internal transitions fired until the marking is stable; the caller knows that this ends."""
        ranks = self.completion.net.internal_ranks
        # Those that may be enabled, by rank.
        queues: list[deque[int]] = [deque() for _ in ranks]
        if self._since is None:
            for queue, transitions in zip(queues, ranks, strict=True):
                queue.extend(transitions)
        else:
            for concerned in self._since:
                for number, u in self._enabled_by(concerned):
                    queues[number].append(u)
        needs, marking = self.completion.needs, self.marking
        while True:
            for queue in queues:
                if queue:
                    break
            else:
                break
            t = queue.popleft()
            for place, weight in needs(t):
                if marking[place] < weight:
                    break
            else:
                concerned = self._fire(t)
                yield t
                queue.append(t)
                for number, u in self._enabled_by(concerned):
                    queues[number].append(u)
        self._since = []

    def _fire(self, t: int) -> Concerned:
        """Fires a transition; what that may have enabled, which is put together once for each firing."""
        marking = self.marking
        self.completion.net.fire_in_place(marking, t)
        concerned = self.completion.concerned(t)
        for place in concerned[2]:
            (self._rarer.add if marking[place] else self._rarer.discard)(place)
        return concerned

    def _enabled_by(self, concerned: Concerned) -> Sequence[tuple[int, int]]:
        """Internal transitions that a firing may have enabled, each after the number of its rank."""
        few, crowded, _ = concerned
        if not crowded:
            return few
        crowds = [self.completion.crowds[place] for place in crowded]
        waiting = (t for crowd in crowds for place in self._rarer & crowd.keys() for t in crowd[place])
        return self.completion.queued({*(t for _, t in few), *waiting})


@record(frozen=True)
class Run:
    """A run of a net from its initial marking.

    Args:
        net: The net.
        transitions: Events, with all internal firings between them or with none.
        settles: Whether internal evolution goes on to its end after the last of them.
        detailed: Whether the internal firings after the last event are what the run shows.
    """

    net: PetriNet
    transitions: tuple[int, ...] = ()
    settles: bool = False
    detailed: bool = False

    @property
    def events(self) -> list[Event]:
        """The events of the run."""
        return [event for t in self.transitions if (event := self.net.event(t)) is not None]

    @property
    def of_events(self) -> Run:
        """The run without the internal firings that it shows."""
        left = len(self.transitions) - len(self.tail)
        return replace(self, transitions=self.transitions[:left]) if self.detailed else self

    @property
    def tail(self) -> list[str]:
        """The names of the internal transitions after the last event, where the run shows them."""
        internal = takewhile(lambda t: self.net.event(t) is None, reversed(self.transitions))
        return [self.net.transitions[t].name for t in internal][::-1] if self.detailed else []

    @cached_property
    def firings(self) -> Sequence[int]:
        """Its transitions, internal ones completed."""
        net = self.net
        evolution, firings = Evolution(Completion(net, once=True), list(net.initial)), list[int]()
        for t in self.transitions:
            if net.priorities and net.event(t) is not None:
                firings.extend(evolution.settle())
            evolution.fire(t)
            firings.append(t)
        if self.settles:
            firings.extend(evolution.settle())
        return firings

    def steps(self) -> Iterator[tuple[int, list[int]]]:
        """Each firing, internal ones completed, with the marking after it: one list, changed in place."""
        marking = list(self.net.initial)
        for t in self.firings:
            self.net.fire_in_place(marking, t)
            yield t, marking


def transitions_of(edges: Iterable[Edge]) -> tuple[int, ...]:
    """The transitions of some edges, one after the other, with the internal ones that they name."""
    return tuple(t for edge in edges for t in (edge.transition, *edge.internal))


def without_detours(net: PetriNet, run: Sequence[int], reached: Callable[[Marking], bool]) -> tuple[int, ...]:
    """A run of a net with priorities without events that it can do without.

    Args:
        net: The net.
        run: Transitions from the initial marking on, internal ones included, to where it ends.
        reached: Whether a marking may be its end.

    Returns:
        A run to such a marking, left without each event that the rest does without, alone or with a later one
        of the same element, as a failure with its repair. It takes a replay for each of these, no more than
        :data:`MOST_REPLAYS`.
    """
    completion = Completion(net)

    def replayed(events: Sequence[Event]) -> tuple[int, ...] | None:
        marking, fired = list(net.initial), list[int]()
        for t in completion.settle(marking):
            fired.append(t)
        for event in events:
            carrying = completion.of_event(marking, event)
            if carrying is None:
                return None
            net.fire_in_place(marking, carrying)
            fired.append(carrying)
            for u in completion.settle(marking, [carrying]):
                fired.append(u)
                if event is events[-1] and reached(tuple(marking)):
                    return tuple(fired)
        return tuple(fired) if reached(tuple(marking)) else None

    events = [event for t in run if (event := net.event(t)) is not None]
    best, at, replays = tuple(run), 0, 0
    while at < len(events) and replays < MOST_REPLAYS:
        later = (o for o in range(at + 1, len(events)) if events[o].element == events[at].element)
        for other in (at, *later):
            left = [event for place, event in enumerate(events) if place not in (at, other)]
            replays += 1
            if (shorter := replayed(left)) is not None:
                best, events = shorter, left
                break
        else:
            at += 1
    return best


def run_of_fewest_events(space: Space[S], goal: S) -> list[Edge] | None:
    """A run of a markings graph into a goal with as few events as any, internal firings not counted.

    Args:
        space: The markings graph of a net with priorities.
        goal: Where the run leads.

    Returns:
        The run from the initial marking; ``None`` where there is none.
    """
    transitions = space.net.transitions
    internal = [t for t, transition in enumerate(transitions) if transition.internal]
    events = [t for t, transition in enumerate(transitions) if not transition.internal]
    # By the number of events so far: the markings just after the last one, and all from there to the next.
    layers: list[tuple[S, S]] = []
    entered, seen = space.initial, space.nothing
    while entered:
        layers.append((entered, space.reached(entered, transitions=internal) - seen))
        seen = seen | layers[-1][1]
        if layers[-1][1] & goal:
            break
        entered = space.after(layers[-1][1], events) - seen
    else:
        return None
    goals = [layers[-1][1] & goal]
    for (begun, _), (_, before) in zip(layers[:0:-1], layers[-2::-1], strict=True):
        goals.append(before & space.before(begun & space.reaching(goals[-1], transitions=internal), events))
    run: list[Edge] = []
    state = space.initial.pick()
    for number, wanted in enumerate(reversed(goals)):
        ways = [(wanted, internal)]
        if number:
            ways.insert(0, (layers[number][0] & space.reaching(wanted, transitions=internal), events))
        for target, carrying in ways:
            part = space.run(state, target, transitions=carrying)
            assert part is not None, "each layer leads to the next"
            run += part
            state = run[-1].target if run else state
    return run
