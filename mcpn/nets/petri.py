"""Petri nets with read arcs and priorities, their markings and the one definition of firing.

A transition carries an *event* or is *internal*. Where a net has priorities, internal transitions come
first: an event transition may fire only in a marking that enables no internal transition (paper, 7.1).
Internal transitions have *ranks*: one may fire only where none of a lower rank is enabled.

>>> builder = NetBuilder("toggle")
>>> builder.place("off", initial=1)
'off'
>>> builder.place("on")
'on'
>>> builder.transition("switch", consume=["off"], produce=["on"], event=Event.parse("SWITCH"))
>>> net = builder.build()
>>> net.fire(net.initial, 0)
(0, 1)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import chain
from typing import NamedTuple, TypeAlias

from mcpn.errors import InputError
from mcpn.events import Event
from mcpn.nets.event_index import EventIndex
from mcpn.nets.provenance import COMPLEMENT, Provenance
from mcpn.notebook import Drawn
from mcpn.records import record

Marking: TypeAlias = tuple[int, ...]
"""Tokens of each place, in the order of the net's places."""

EVENTS = 0xFFFF
"""The rank of events, after that of any internal transition."""

Arcs: TypeAlias = tuple[tuple[int, int], ...]
"""Pairs (index of a place, weight of at least 1), in the order of the places, each place once."""


@record(frozen=True, slots=True)
class Place:
    """A place.

    Args:
        name: Unique among the places of its net; any characters.
        initial: Tokens of the initial marking.
        provenance: What made it, for nets composed from missions.
        label: What people call it, where a file says that beside the name.
    """

    name: str
    initial: int = 0
    provenance: Provenance | None = field(default=None, compare=False)
    label: str | None = field(default=None, compare=False)


@record(frozen=True, slots=True)
class Transition:
    """A transition: enabled where each place holds as many tokens as it consumes and as it reads.

    Args:
        name: Unique among the transitions of its net; any characters.
        consume: Tokens that firing takes.
        produce: Tokens that firing puts.
        read: Tokens that must be there and stay.
        event: The event that fires it, or ``None`` for an internal transition.
        rank: Of an internal transition: in nets with priorities those of a lower rank fire before it. From 0
            to 65,534; events come after all ranks, and have none of their own.
        provenance: What made it, for nets composed from missions.
        label: What people call it, where a file says that beside the name.
    """

    name: str
    consume: Arcs = ()
    produce: Arcs = ()
    read: Arcs = ()
    event: Event | None = None
    rank: int = 0
    provenance: Provenance | None = field(default=None, compare=False)
    label: str | None = field(default=None, compare=False)

    @property
    def internal(self) -> bool:
        """Whether no event is needed to fire it."""
        return self.event is None


class SafeTransition(NamedTuple):
    """What a transition does to a 1-safe marking, seen as the set of its marked places.

    The four sets of places are disjoint but for ``overflow``.

    Args:
        consume: Places that go from marked to unmarked.
        produce: Places that go from unmarked to marked; if one is marked already, the firing is unsafe.
        read: Places that must be marked and stay so.
        overflow: Places that receive more than one token at each firing: unsafe whatever the marking.
        blocked: Whether it needs more than one token of a place, so that no safe marking enables it.
    """

    consume: tuple[int, ...]
    produce: tuple[int, ...]
    read: tuple[int, ...]
    overflow: tuple[int, ...]
    blocked: bool


@record(frozen=True)
class PetriNet(Drawn):
    """A place/transition net.

    Args:
        name: Any text.
        places: In the order that markings follow.
        transitions: In a fixed order.
        priorities: Whether internal transitions have priority over events.
        units: Groups of places of which at most one is meant to be marked (a hint for orders of places,
            never an assumption), as indices.
    """

    name: str
    places: Sequence[Place]
    transitions: Sequence[Transition]
    priorities: bool = False
    units: tuple[tuple[int, ...], ...] = field(default=(), compare=False)

    def __hash__(self) -> int:
        # Runs are hashed, each with its net, which may have a hundred thousand transitions.
        return hash((self.name, len(self.places), len(self.transitions)))

    def __repr__(self) -> str:
        return f"<net {self.name}: {len(self.places)} places, {len(self.transitions)} transitions>"

    @cached_property
    def initial(self) -> Marking:
        """The initial marking."""
        return tuple(place.initial for place in self.places)

    @cached_property
    def place_index(self) -> Mapping[str, int]:
        """Index of each place by name."""
        return {place.name: index for index, place in enumerate(self.places)}

    @cached_property
    def transition_index(self) -> Mapping[str, int]:
        """Index of each transition by name."""
        return {transition.name: index for index, transition in enumerate(self.transitions)}

    @cached_property
    def place_labels(self) -> Mapping[str, Sequence[int]]:
        """Indices of the places that have each label."""
        return _labelled(self.places)

    @cached_property
    def transition_labels(self) -> Mapping[str, Sequence[int]]:
        """Indices of the transitions that have each label."""
        return _labelled(self.transitions)

    @cached_property
    def complements(self) -> frozenset[int]:
        """Places that stand for inhibitor arcs: how many tokens they hold says nothing of its own."""
        made = ((number, place.provenance) for number, place in enumerate(self.places))
        return frozenset(number for number, by in made if by is not None and by.kind == COMPLEMENT)

    @cached_property
    def largest(self) -> int:
        """The largest number in the net: the weight of an arc, or the initial tokens of a place."""
        sides = (side for t in self.transitions for side in (t.consume, t.produce, t.read))
        return max(max((w for side in sides for _, w in side), default=0), max(self.initial, default=0))

    @cached_property
    def events(self) -> EventIndex:
        """Which transitions carry which event."""
        return EventIndex(transition.event for transition in self.transitions)

    @cached_property
    def ranks(self) -> tuple[int, ...]:
        """The rank of each transition, :data:`EVENTS` for events."""
        return tuple(t.rank if t.internal else EVENTS for t in self.transitions)

    @cached_property
    def internal_ranks(self) -> tuple[tuple[int, ...], ...]:
        """The internal transitions by rank, those that fire first at first."""
        found: dict[int, list[int]] = {}
        for t, rank in enumerate(self.ranks):
            if rank != EVENTS:
                found.setdefault(rank, []).append(t)
        return tuple(tuple(found[rank]) for rank in sorted(found))

    @cached_property
    def internal_users(self) -> Mapping[int, Sequence[int]]:
        """The internal transitions that consume or read each place, where there are some."""
        users: dict[int, list[int]] = {}
        for number, transition in enumerate(self.transitions):
            if transition.internal:
                for place, _ in (*transition.consume, *transition.read):
                    users.setdefault(place, []).append(number)
        return users

    def crowds(self, most: int) -> Mapping[int, Mapping[int, Sequence[int]]]:
        """By place that more internal transitions need than a number, these by their rarest place.

        The rarest place of a transition is the one that the fewest internal transitions need.
        """
        if most not in self._crowds:
            users, crowds = self.internal_users, dict[int, dict[int, list[int]]]()
            for place in self._crowded(most):
                by_rarest = crowds[place] = {}
                for t in users[place]:
                    by_rarest.setdefault(self._rarest(t), []).append(t)
            self._crowds[most] = crowds
        return self._crowds[most]

    @cached_property
    def _crowds(self) -> dict[int, Mapping[int, Mapping[int, Sequence[int]]]]:
        """By number what was asked for."""
        return {}

    def _crowded(self, most: int) -> list[int]:
        return [place for place, users in self.internal_users.items() if len(users) > most]

    def _rarest(self, transition: int) -> int:
        return min((len(self.internal_users[place]), place) for place, _ in self.needs(transition))[1]

    def event(self, transition: int) -> Event | None:
        """The event of a transition."""
        return self.transitions[transition].event

    def arcs(self, transition: int) -> tuple[Arcs, Arcs, Arcs]:
        """What a transition consumes, produces and reads."""
        drawn = self.transitions[transition]
        return drawn.consume, drawn.produce, drawn.read

    def needs(self, transition: int) -> Arcs:
        """What a transition consumes, and what it reads."""
        drawn = self.transitions[transition]
        return (*drawn.consume, *drawn.read)

    def origin(self, place: int) -> Provenance | None:
        """What has made a place."""
        return self.places[place].provenance

    def consuming(self, places: Collection[int]) -> Mapping[int, Sequence[int]]:
        """By some places, the transitions that consume from them, where there are some."""
        found: dict[int, list[int]] = {}
        for number, transition in enumerate(self.transitions):
            for place, _ in transition.consume:
                if place in places:
                    found.setdefault(place, []).append(number)
        return found

    def extended(
        self,
        changed: Mapping[int, Transition],
        places: Sequence[Place],
        transitions: Sequence[Transition],
        units: Sequence[tuple[int, ...]] = (),
    ) -> PetriNet:
        """The net with some transitions changed, and with more nodes after all that it has."""
        kept = [*self.transitions]
        for number, transition in changed.items():
            kept[number] = transition
        return PetriNet(
            self.name,
            (*self.places, *places),
            (*kept, *transitions),
            self.priorities,
            (*self.units, *units),
        )

    @cached_property
    def safe_transitions(self) -> tuple[SafeTransition, ...]:
        """Each transition as it acts on 1-safe markings, in the net's order."""
        return tuple(_safe(transition) for transition in self.transitions)

    @cached_property
    def _needing(self) -> list[list[int]]:
        """By place, the transitions that need it and no rarer one; at the end, those that need no place."""
        users = Counter(place for t in self.transitions for place, _ in (*t.consume, *t.read))
        found: list[list[int]] = [[] for _ in range(len(self.places) + 1)]
        for number, t in enumerate(self.transitions):
            needed = [place for place, _ in (*t.consume, *t.read)]
            found[min(needed, key=users.__getitem__, default=-1)].append(number)
        return found

    def covers(self, marking: Sequence[int], transition: int) -> bool:
        """Whether the marking has the tokens that the transition needs, priorities aside."""
        consume, _, read = self.arcs(transition)
        for needed in (consume, read):
            for place, weight in needed:
                if marking[place] < weight:
                    return False
        return True

    def enabled(self, marking: Sequence[int]) -> list[int]:
        """Indices of the transitions that may fire in the marking, priorities respected.

        Args:
            marking: Tokens of each place.

        Returns:
            Indices in the net's order; where the net has priorities, those of the lowest rank alone.
        """
        marked = (self._needing[place] for place, tokens in enumerate(marking) if tokens)
        maybe = chain(self._needing[-1], chain.from_iterable(marked))
        covered = sorted(t for t in maybe if self.covers(marking, t))
        if self.priorities and covered:
            least = min(self.ranks[t] for t in covered)
            return [t for t in covered if self.ranks[t] == least]
        return covered

    def fire(self, marking: Sequence[int], transition: int) -> Marking:
        """The marking after firing a transition; the caller has seen that it is enabled.

        Args:
            marking: Tokens of each place.
            transition: Index of an enabled transition.

        Returns:
            The next marking.
        """
        after = list(marking)
        self.fire_in_place(after, transition)
        return tuple(after)

    def fire_in_place(self, marking: list[int], transition: int) -> None:
        """Fires a transition; the caller has seen that it is enabled."""
        consume, produce, _ = self.arcs(transition)
        for place, weight in consume:
            marking[place] -= weight
        for place, weight in produce:
            marking[place] += weight

    def undo_in_place(self, marking: list[int], transition: int) -> None:
        """Takes back the firing of a transition that has led to the marking."""
        consume, produce, _ = self.arcs(transition)
        for place, weight in produce:
            marking[place] -= weight
        for place, weight in consume:
            marking[place] += weight

    def marked(self, marking: Sequence[int]) -> frozenset[str]:
        """Names of the places that hold a token."""
        return frozenset(place.name for place, tokens in zip(self.places, marking, strict=True) if tokens)


def _labelled(nodes: Iterable[Place | Transition]) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for number, node in enumerate(nodes):
        if node.label is not None:
            found.setdefault(node.label, []).append(number)
    return found


def _safe(transition: Transition) -> SafeTransition:
    consume, produce, read = dict(transition.consume), dict(transition.produce), dict(transition.read)
    needed = consume.keys() | read.keys()
    return SafeTransition(
        consume=tuple(sorted(consume.keys() - produce.keys())),
        produce=tuple(sorted(produce.keys() - consume.keys())),
        read=tuple(sorted(needed - (consume.keys() - produce.keys()))),
        overflow=tuple(
            sorted(p for p, w in produce.items() if w - consume.get(p, 0) + (1 if p in needed else 0) > 1)
        ),
        blocked=any(w > 1 for w in consume.values()) or any(w > 1 for w in read.values()),
    )


Sides: TypeAlias = tuple[Mapping[str, int], Mapping[str, int], Mapping[str, int]]
"""What a transition consumes, produces and reads, as weights by place."""
Draft: TypeAlias = tuple[Sides, Event | None, int, Provenance | None]
"""A transition whose places may be declared later: its arcs, its event, its rank and its provenance."""


class NetBuilder:
    """Collects places and transitions by name and makes a :class:`PetriNet` of them.

    Transitions may name places that are declared later; :meth:`build` checks every name.

    Args:
        name: The net's name.
        priorities: Whether internal transitions have priority over events.
    """

    def __init__(self, name: str, *, priorities: bool = False) -> None:
        self.name = name
        self.priorities = priorities
        self._places: dict[str, Place] = {}
        self._transitions: dict[str, Draft] = {}
        self._labels: dict[str, str] = {}
        self._units: list[list[str]] = []

    def place(
        self,
        name: str,
        *,
        initial: int = 0,
        provenance: Provenance | None = None,
        label: str | None = None,
    ) -> str:
        """Declares a place and returns its name.

        Raises:
            InputError: The name is taken, or the tokens are no whole number.
        """
        self.add_place(Place(name, initial, provenance, label))
        return name

    def add_place(self, place: Place) -> None:
        """Declares a place that is there.

        Raises:
            InputError: Its name is taken, or its tokens are no whole number.
        """
        origin = place.provenance
        if place.name in self._places:
            raise InputError.at(origin.source if origin else None, f"place {place.name} is declared twice")
        _whole(place.initial, f"place {place.name}", origin)
        self._places[place.name] = place

    def transition(
        self,
        name: str,
        *,
        consume: Iterable[str] | Mapping[str, int] = (),
        produce: Iterable[str] | Mapping[str, int] = (),
        read: Iterable[str] | Mapping[str, int] = (),
        event: Event | None = None,
        rank: int = 0,
        provenance: Provenance | None = None,
    ) -> None:
        """Declares a transition; arcs are names of places (weight 1 each, repeats add up) or weights by name.

        Raises:
            InputError: The name is taken, a weight is no whole number, or the rank is out of bounds.
        """
        if not 0 <= rank < EVENTS:
            raise InputError.at(
                provenance.source if provenance else None,
                f"transition {name}: found the rank {rank}, expected 0 to {EVENTS - 1}",
            )
        arcs = _weights(consume), _weights(produce), _weights(read)
        for side in arcs:
            for place, weight in side.items():
                _whole(weight, f"transition {name}, place {place}", provenance)
        self.add_draft(name, (arcs, event, rank, provenance))

    def add_draft(self, name: str, draft: Draft) -> None:
        """Declares a transition by its draft.

        Raises:
            InputError: The name is taken.
        """
        if name in self._transitions:
            origin = draft[-1]
            raise InputError.at(origin.source if origin else None, f"transition {name} is declared twice")
        self._transitions[name] = draft

    @property
    def drawn(self) -> tuple[Collection[Place], Mapping[str, Draft]]:
        """The places and, by name, the transitions that are declared so far."""
        return self._places.values(), self._transitions

    def label(self, transition: str, label: str | None) -> None:
        """Notes what people call a transition."""
        if label is not None:
            self._labels[transition] = label

    def unit(self, places: Iterable[str]) -> None:
        """Notes a group of places of which at most one is meant to be marked."""
        self._units.append(list(places))

    def has_place(self, name: str) -> bool:
        """Whether a place of this name is declared."""
        return name in self._places

    def build(self) -> PetriNet:
        """The net; ranks are numbered from 0 in their order.

        Raises:
            InputError: A transition or a unit names a place that nobody declared.
        """
        index = {name: number for number, name in enumerate(self._places)}
        transitions = tuple(self.transitions_at(index, numbered_ranks(self.internal_ranks)))
        places = tuple(self._places.values())
        return PetriNet(self.name, places, transitions, self.priorities, self.units_at(index))

    @property
    def internal_ranks(self) -> set[int]:
        """The ranks of internal transitions that are declared so far."""
        return {rank for _, event, rank, _ in self._transitions.values() if event is None}

    def transitions_at(self, index: Mapping[str, int], ranks: Mapping[int, int]) -> Iterator[Transition]:
        """The transitions: by place its number, and by rank that of its order."""
        single = _single(index)
        for name, (sides, event, rank, origin) in self._transitions.items():
            consume, produce, read = (_arcs(side, single, f"transition {name}", origin) for side in sides)
            order = ranks[rank] if self.priorities and event is None else 0
            yield Transition(name, consume, produce, read, event, order, origin, self._labels.get(name))

    def units_at(self, index: Mapping[str, int]) -> tuple[tuple[int, ...], ...]:
        """The units: by place its number."""
        single = _single(index)
        every = (_arcs(dict.fromkeys(unit, 1), single, "a unit", None) for unit in self._units)
        return tuple(tuple(place for place, _ in unit) for unit in every)


def numbered_ranks(ranks: Iterable[int]) -> dict[int, int]:
    """By rank its number from 0, in their order."""
    return {rank: number for number, rank in enumerate(sorted(ranks))}


def _single(index: Mapping[str, int]) -> dict[str, tuple[int, int]]:
    """By place its number with a weight of 1: one for all arcs that are alike."""
    return {name: (number, 1) for name, number in index.items()}


def _arcs(
    weights: Mapping[str, int],
    single: Mapping[str, tuple[int, int]],
    user: str,
    provenance: Provenance | None,
) -> Arcs:
    """Arcs by the numbers of their places."""
    if not weights:
        return ()
    try:
        arcs = [single[place] if w == 1 else (single[place][0], w) for place, w in weights.items()]
    except KeyError as missing:
        raise InputError.at(
            provenance.source if provenance else None,
            f"{user} names the place {missing.args[0]}, which is not declared",
        ) from None
    if 0 in weights.values():
        arcs = [arc for arc in arcs if arc[1]]
    arcs.sort()
    return tuple(arcs)


def _whole(number: object, whose: str, origin: Provenance | None) -> None:
    """Refuses tokens and weights that no file can say, and no engine counts."""
    if type(number) is not int or number < 0:
        source = origin.source if origin else None
        raise InputError.at(source, f"{whose}: found {number!r}, expected a whole number from 0")


def _weights(side: Iterable[str] | Mapping[str, int]) -> dict[str, int]:
    if isinstance(side, dict) or (not isinstance(side, list) and isinstance(side, Mapping)):
        return dict(side)
    weights: dict[str, int] = {}
    for place in side:
        weights[place] = weights.get(place, 0) + 1
    return weights
