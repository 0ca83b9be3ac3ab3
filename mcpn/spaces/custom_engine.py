"""A state space over sets of one's own: what an engine must bring, and all the rest made of it.

An engine of one's own is a class that is made of a 1-safe net and has the five methods of :class:`Sets`:
the set of one marking, the moving of tokens, union, difference and a count. :class:`OwnSpace` makes of these
the markings graph as :mod:`mcpn.spaces.algebra` describes it, so that every question can be asked of it;
``mcpn compare --engine MODULE:CLASS`` runs it beside the engines that mcpn has.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, Protocol, TypeAlias

from mcpn._kernel import Zdd
from mcpn.errors import InputError, UnsafeError
from mcpn.nets.petri import EVENTS, Marking, PetriNet
from mcpn.spaces.algebra import Edge, Guards
from mcpn.spaces.by_steps import BySteps
from mcpn.spaces.projections import ImageStore

GROUP = "mcpn.engines"
"""Entry points of packages that bring engines: each is a class, under the name that the engine goes by."""

REQUIRED = ("single", "moved", "union", "minus", "count")

Raw: TypeAlias = Any
"""A set as the engine holds it."""

Tokens: TypeAlias = Mapping[int, bool]
"""Whether places are marked, by index; of the others nothing is said."""


class Sets(Protocol):
    """What an engine brings: sets of 1-safe markings in any representation, none of which changes.

    The class is called with the net. It may also have ``order``, the name of its order of places, and
    ``nodes(states)``, the size of its representation of a set; both are shown beside the counts.
    """

    def single(self, marked: Collection[int]) -> Raw:
        """The set of the one marking that marks these places, by index, and no other."""

    def moved(self, states: Raw, before: Tokens, after: Tokens) -> Raw:
        """Those markings of a set that are as ``before`` says, changed to what ``after`` says.

        A firing, its reverse, and a condition are all this: a condition changes nothing.
        """

    def union(self, one: Raw, other: Raw) -> Raw:
        """Markings of either set."""

    def minus(self, one: Raw, other: Raw) -> Raw:
        """Markings of the first set that are not in the second."""

    def count(self, states: Raw) -> int:
        """How many markings, exactly."""


@dataclass(frozen=True, eq=False, slots=True)
class OwnSet:
    """A set of markings of one space.

    Args:
        engine: The engine.
        raw: The set as the engine holds it.
        places: How many places a marking has.
    """

    engine: Sets
    raw: Raw
    places: int

    def _made(self, raw: Raw) -> OwnSet:
        return OwnSet(self.engine, raw, self.places)

    def __and__(self, other: OwnSet) -> OwnSet:
        return self._made(self.engine.minus(self.raw, self.engine.minus(self.raw, other.raw)))

    def __or__(self, other: OwnSet) -> OwnSet:
        return self._made(self.engine.union(self.raw, other.raw))

    def __sub__(self, other: OwnSet) -> OwnSet:
        return self._made(self.engine.minus(self.raw, other.raw))

    def __bool__(self) -> bool:
        return self.count() > 0

    def count(self) -> int:
        """How many members the set has."""
        return self.engine.count(self.raw)

    def moved(self, before: Tokens, after: Tokens | None = None) -> OwnSet:
        """Its markings that are as asked, changed; see :meth:`Sets.moved`."""
        return self._made(self.engine.moved(self.raw, before, after or {}))

    def pick(self) -> Marking | None:
        """The marking that leaves the first places unmarked, where there is one."""
        if not self:
            return None
        left, tokens = self, []
        for place in range(self.places):
            unmarked = left.moved({place: False})
            tokens.append(0 if unmarked else 1)
            left = unmarked or left
        return tuple(tokens)


class OwnSpace(BySteps[OwnSet]):
    """The markings graph of a 1-safe net over an engine of one's own.

    Args:
        net: The net.
        engine: A class that brings :class:`Sets`.

    Raises:
        UnsafeError: The net is not 1-safe.
    """

    def __init__(self, net: PetriNet, engine: Any) -> None:
        self.net = net
        self.sets: Sets = engine(net)
        for place in net.places:
            if place.initial > 1:
                raise UnsafeError(place.name, "", net.marked(net.initial), [])
        self.initial = self.single(net.initial)
        self.nothing = self.initial - self.initial
        safe = net.safe_transitions
        self._before = [
            dict.fromkeys((*t.consume, *t.read), True) | dict.fromkeys(t.produce, False) for t in safe
        ]
        self._after = [dict.fromkeys(t.consume, False) | dict.fromkeys(t.produce, True) for t in safe]
        self._ranks = sorted({*net.ranks, EVENTS}) if net.priorities else [EVENTS]

    def _covering(self, states: OwnSet, transition: int) -> OwnSet:
        """Markings with the tokens that a transition needs, priorities aside.

        Raises:
            UnsafeError: Its firing would put a second token in a place.
        """
        t = self.net.safe_transitions[transition]
        if t.blocked:
            return self.nothing
        covering = states.moved(dict.fromkeys((*t.consume, *t.read), True))
        doubled = covering if t.overflow else covering - covering.moved(dict.fromkeys(t.produce, False))
        if marking := doubled.pick():
            place = next(p for p in (*t.overflow, *t.produce) if p in t.overflow or marking[p])
            names = (self.net.places[place].name, self.net.transitions[transition].name)
            raise UnsafeError(*names, self.net.marked(marking), [])
        return covering

    def _firing(self, states: OwnSet) -> Iterator[tuple[int, OwnSet]]:
        """Each transition with those of some markings in which it fires, priorities respected."""
        for rank in self._ranks:
            rest = states
            for t, own in enumerate(self.net.ranks):
                if own == rank or not self.net.priorities:
                    covering = self._covering(states, t)
                    rest = rest - covering
                    yield t, covering
            states = rest

    @cached_property
    def everything(self) -> OwnSet:
        """All reachable markings; those that are new fire next, until none is."""
        reached = new = self.initial
        while new:
            fresh = self.nothing
            for t, enabled in self._firing(new):
                fresh = fresh | enabled.moved(self._before[t], self._after[t])
            new = fresh - reached
            reached = reached | new
        return reached

    @cached_property
    def _enabling(self) -> Sequence[OwnSet]:
        """By transition, the reachable markings in which it fires."""
        found = dict(self._firing(self.everything))
        return [found[t] for t in range(len(self.net.transitions))]

    @cached_property
    def dead(self) -> OwnSet:
        """Markings that enable no transition."""
        return self.everything - self.enabling(range(len(self.net.transitions)))

    def single(self, state: Marking) -> OwnSet:
        """The set that holds one marking."""
        marked = [place for place, tokens in enumerate(state) if tokens]
        return OwnSet(self.sets, self.sets.single(marked), len(self.net.places))

    def marking(self, state: Marking) -> Marking:
        """The marking of a member: itself."""
        return state

    def marked(self, places: Collection[int]) -> OwnSet:
        """Markings that mark at least one of some places."""
        return self.everything - self.restricted(self.everything, (), places)

    def restricted(self, states: OwnSet, marked: Collection[int], unmarked: Collection[int]) -> OwnSet:
        """Those of some markings that mark all of some places, and none of others."""
        return states.moved(dict.fromkeys(marked, True) | dict.fromkeys(unmarked, False))

    def at_most(self, weights: Mapping[int, int], bound: int) -> OwnSet:
        """Markings whose weighted sum of tokens is at most a bound."""
        places = list(weights)

        def within(states: OwnSet, number: int, left: int) -> OwnSet:
            rest = [weights[p] for p in places[number:]]
            if not states or sum(w for w in rest if w < 0) > left:
                return self.nothing
            if sum(w for w in rest if w > 0) <= left:
                return states
            place = places[number]
            without = within(states.moved({place: False}), number + 1, left)
            return without | within(states.moved({place: True}), number + 1, left - weights[place])

        return within(self.everything, 0, bound)

    def enabling(self, transitions: Collection[int]) -> OwnSet:
        """Markings in which some of these transitions fire."""
        found = self.nothing
        for t in transitions:
            found = found | self._enabling[t]
        return found

    def firings(self, states: OwnSet) -> Mapping[int, int]:
        """In how many of some markings each transition fires."""
        counts = {t: (enabled & states).count() for t, enabled in enumerate(self._enabling)}
        return {t: count for t, count in counts.items() if count}

    def image(self, states: OwnSet, places: Sequence[int], images: ImageStore) -> Zdd:
        """How some markings mark some places; see :meth:`mcpn.spaces.algebra.Space.image`."""

        def rows(states: OwnSet, number: int, row: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
            if not states:
                return
            if number == len(places):
                yield row
                return
            yield from rows(states.moved({places[number]: False}), number + 1, row)
            yield from rows(states.moved({places[number]: True}), number + 1, (*row, number))

        return images.of_rows(rows(states, 0, ()))

    def _chosen(
        self, transitions: Collection[int] | None, guards: Guards[OwnSet]
    ) -> Iterator[tuple[int, OwnSet]]:
        """Transitions, each with the markings from which an edge may be taken."""
        for t in range(len(self.net.transitions)) if transitions is None else transitions:
            guard = (guards or {}).get(t)
            yield t, self._enabling[t] if guard is None else self._enabling[t] & guard

    def before(
        self,
        states: OwnSet,
        transitions: Collection[int] | None = None,
        guards: Guards[OwnSet] = None,
        among: OwnSet | None = None,
    ) -> OwnSet:
        """Markings with an edge into some markings."""
        found = self.nothing
        for t, enabled in self._chosen(transitions, guards):
            reverse = {**self._before[t], **self._after[t]}, {p: self._before[t][p] for p in self._after[t]}
            found = found | (states.moved(*reverse) & enabled)
        return found if among is None else found & among

    def after(
        self, states: OwnSet, transitions: Collection[int] | None = None, guards: Guards[OwnSet] = None
    ) -> OwnSet:
        """Markings that an edge leads to from some markings."""
        found = self.nothing
        for t, enabled in self._chosen(transitions, guards):
            found = found | (states & enabled).moved(self._before[t], self._after[t])
        return found

    def edges(self, state: Marking) -> Iterator[Edge]:
        """The edges of one marking."""
        return (Edge(t, self.net.fire(state, t)) for t in self.net.enabled(state))


def engine_named(name: str) -> Any:
    """The class of an engine of one's own.

    Args:
        name: ``MODULE:CLASS``, of a module that Python finds, also in the current directory; or the name of
            an entry point of :data:`GROUP`.

    Raises:
        InputError: There is no such module, class or entry point, or it lacks a method of :class:`Sets`.
    """
    module, colon, attribute = name.partition(":")
    path = list(sys.path)
    sys.path.append("")  # a command that is installed does not look in the current directory by itself
    try:
        if colon:
            engine = getattr(import_module(module), attribute)
        else:
            points = entry_points(group=GROUP)
            if name not in points.names:
                known = "".join(f", {other}" for other in sorted(points.names))
                raise InputError.at(None, f"found the engine {name!r}, expected MODULE:CLASS{known}")
            engine = points[name].load()
    except InputError:
        raise
    except Exception as error:  # whatever the caller's code raises while it is loaded
        told = f"{type(error).__name__}: {error}"
        raise InputError.at(None, f"the engine {name} cannot be loaded: {told}") from error
    finally:
        sys.path[:] = path
    if missing := [method for method in REQUIRED if not callable(getattr(engine, method, None))]:
        expected = f"expected a class with the methods {', '.join(REQUIRED)}"
        raise InputError.at(None, f"the engine {name}: found no {', '.join(missing)}; {expected}")
    return engine
