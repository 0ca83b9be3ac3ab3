"""Runs of a net as they are found: transitions one after the other, completed when they are read.

A run through the alternatives graph names events only. What the net does between two events is completed by
the net's own rule, along one interleaving, since internal evolution is confluent there.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, takewhile

from mcpn.net.events import Event
from mcpn.net.petri import Arcs, Marking, PetriNet
from mcpn.space.algebra import Edge, S, Space

MOST_REPLAYS = 1_000
MOST_BESIDE = 50
"""Internal transitions that need one place, of which each is looked at when it receives a token."""


class Completion:
    """Fires internal transitions of a net until none is enabled, those of the lowest rank first.

    Only the transitions beside a place that has just received a token are looked at; where these are many, as
    the gates of all sections that wait for one activity, only those of which a rarer place is marked.

    Args:
        net: The net.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self._number = {net.ranks[of[0]]: number for number, of in enumerate(net.internal_ranks)}
        self._needs: dict[int, Arcs] = {}
        self._known: dict[int, tuple[list[int], list[int]]] = {}

    def settle(
        self, marking: list[int], fired: Iterable[int] | None = None, marked: set[int] | None = None
    ) -> Iterator[int]:
        """The internal transitions fired until the marking is stable; it is changed in place.

        Args:
            marking: Where internal evolution begins; the caller knows that it ends.
            fired: The transitions that have led there from a stable marking, where some have.
            marked: The marked places, where somebody keeps them; they are changed in place, too.
        """
        # Those that may be enabled, by rank.
        queues: list[deque[int]] = [deque() for _ in self.net.internal_ranks]
        number, ranks = self._number, self.net.ranks
        begin: Iterable[Iterable[int]] = self.net.internal_ranks
        if fired is not None:
            begin = [self._beside(t, marking, marked) for t in fired]
        for t in chain.from_iterable(begin):
            queues[number[ranks[t]]].append(t)
        while queue := next((queue for queue in queues if queue), None):
            t = queue.popleft()
            for place, weight in self._needed(t):
                if marking[place] < weight:
                    break
            else:
                self.fire(marking, t, marked)
                yield t
                for u in (t, *self._beside(t, marking, marked)):
                    queues[number[ranks[u]]].append(u)

    def fire(self, marking: list[int], t: int, marked: set[int] | None) -> None:
        """Fires a transition in place; the marked places follow, where somebody keeps them."""
        self.net.fire_in_place(marking, t)
        if marked is not None:
            transition = self.net.transitions[t]
            marked.difference_update(place for place, _ in transition.consume if not marking[place])
            marked.update(place for place, _ in transition.produce)

    def after(self, marking: Marking, event: int) -> tuple[tuple[int, ...], Marking]:
        """What follows an event in a stable marking: the internal transitions fired, and the stable end."""
        at = list(marking)
        self.net.fire_in_place(at, event)
        return tuple(self.settle(at, [event])), tuple(at)

    def _needed(self, t: int) -> Arcs:
        if t not in self._needs:
            transition = self.net.transitions[t]
            self._needs[t] = (*transition.consume, *transition.read)
        return self._needs[t]

    def _beside(self, fired: int, marking: Sequence[int], marked: Collection[int] | None) -> list[int]:
        """Internal transitions that a firing may have enabled."""
        users = self.net.internal_users
        if fired not in self._known:
            into = {place: users.get(place, ()) for place, _ in self.net.transitions[fired].produce}
            few = sorted({t for of in into.values() if len(of) <= MOST_BESIDE for t in of})
            self._known[fired] = few, [place for place, of in into.items() if len(of) > MOST_BESIDE]
        few, crowded = self._known[fired]
        if not crowded:
            return few
        rarest, by_rarest = self._rarest
        if marked is None:
            return sorted({*few, *(t for place in crowded for t in users[place] if marking[rarest[t]])})
        waiting = {t for place in marked for t in by_rarest.get(place, ())}
        return sorted({*few, *(t for t in waiting if any(p in crowded for p, _ in self._needed(t)))})

    @cached_property
    def _rarest(self) -> tuple[Mapping[int, int], Mapping[int, Sequence[int]]]:
        """By internal transition, the place that it needs and the fewest others do; and the reverse.

        It is empty most often: of the objectives that start an activity, which come into question whenever
        that comes to rest, few are run.
        """
        users, rarest, found = self.net.internal_users, dict[int, int](), dict[int, list[int]]()
        for t in chain.from_iterable(self.net.internal_ranks):
            if needed := self._needed(t):
                rarest[t] = min((len(users[place]), place) for place, _ in needed)[1]
                found.setdefault(rarest[t], []).append(t)
        return rarest, found


@dataclass(frozen=True)
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
        return [event for t in self.transitions if (event := self.net.transitions[t].event) is not None]

    @property
    def of_events(self) -> Run:
        """The run without the internal firings that it shows."""
        return replace(self, transitions=self.transitions[: len(self.transitions) - len(self.tail)])

    @property
    def tail(self) -> list[str]:
        """The names of the internal transitions after the last event, where the run shows them."""
        internal = takewhile(lambda t: self.net.transitions[t].internal, reversed(self.transitions))
        return [self.net.transitions[t].name for t in internal][::-1] if self.detailed else []

    def steps(self) -> Iterator[tuple[int, list[int]]]:
        """Each firing, internal ones completed, with the marking after it: one list, changed in place."""
        net, completion, at = self.net, Completion(self.net), list(self.net.initial)
        marked = {place for place, tokens in enumerate(at) if tokens}
        since: list[int] | None = None  # fired since the last stable marking, once there is one
        for t in self.transitions:
            if net.priorities and not net.transitions[t].internal:
                yield from ((u, at) for u in completion.settle(at, since, marked))
                since = []
            completion.fire(at, t, marked)
            yield t, at
            if since is not None:
                since.append(t)
        if self.settles:
            yield from ((u, at) for u in completion.settle(at, since, marked))


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
    by_event: dict[Event, list[int]] = {}
    for t, transition in enumerate(net.transitions):
        if transition.event is not None:
            by_event.setdefault(transition.event, []).append(t)

    def replayed(events: Sequence[Event]) -> tuple[int, ...] | None:
        at, fired = list(net.initial), list[int]()
        for t in completion.settle(at):
            fired.append(t)
        for event in events:
            t = next((t for t in by_event[event] if net.covers(at, t)), -1)
            if t < 0:
                return None
            net.fire_in_place(at, t)
            fired.append(t)
            for u in completion.settle(at, [t]):
                fired.append(u)
                if event is events[-1] and reached(tuple(at)):
                    return tuple(fired)
        return tuple(fired) if reached(tuple(at)) else None

    events = [event for t in run if (event := net.transitions[t].event) is not None]
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
    at = space.initial.pick()
    for number, wanted in enumerate(reversed(goals)):
        ways = [(wanted, internal)]
        if number:
            ways.insert(0, (layers[number][0] & space.reaching(wanted, transitions=internal), events))
        for target, carrying in ways:
            part = space.run(at, target, transitions=carrying)
            assert part is not None, "each layer leads to the next"
            run += part
            at = run[-1].target if run else at
    return run
