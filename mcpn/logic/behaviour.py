"""The behaviour of a net that is of no mission: deadlocks, liveness, bounds, home markings.

Behaviour follows from the *bottom components*: strongly connected sets of markings that no firing leaves.
From every marking some run ends in one of them. So a transition is live (L4) if it fires in each of them, a
home marking is one that lies in the only bottom component, and the net is reversible if every marking is a
home marking.

Reference: T. Murata, Petri nets: properties, analysis and applications, Proc. IEEE 77(4), 1989, section IV.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from typing import Any, Generic

from mcpn.errors import UnboundedError, UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import incidence
from mcpn.records import record
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.markings.boundedness import REPEATED, Boundedness, boundedness
from mcpn.spaces.registry import Spaces, spaces_of
from mcpn.spaces.search.goal import DEADLOCK
from mcpn.spaces.search.portfolio import Portfolio

MOST_LISTED = 1_000_000
"""Markings listed at most, of a net with priorities that is not 1-safe, or in a coverability tree."""


class Behaviour(Generic[S]):
    """What a bounded net does; each property is decided when it is first asked for.

    Args:
        space: Its reachable markings.

    Attributes:
        transitions: All its transitions, as indices.
    """

    def __init__(self, space: Space[S]) -> None:
        self.space = space
        self.transitions = frozenset(range(len(space.net.transitions)))

    @cached_property
    def deadlock(self) -> bool:
        """Whether some reachable marking enables nothing."""
        return bool(self.space.dead)

    @cached_property
    def quasi_live(self) -> frozenset[int]:
        """Transitions that fire somewhere."""
        return frozenset(t for t, count in self.space.firings(self.space.everything).items() if count)

    @property
    def live(self) -> frozenset[int]:
        """Transitions that, whatever has happened, can fire again (L4)."""
        return self._at_bottom[0]

    @property
    def home_markings(self) -> int:
        """Number of markings that every reachable marking leads to."""
        return self._at_bottom[1]

    @property
    def reversible(self) -> bool:
        """Whether every reachable marking leads back to the initial one."""
        return self.home_markings == self.space.everything.count()

    @cached_property
    def constant_places(self) -> frozenset[int]:
        """Places whose tokens no transition that fires changes."""
        rows = enumerate(incidence(self.space.net))
        return frozenset(place for place, changes in rows if self.quasi_live.isdisjoint(changes))

    @property
    def all_live(self) -> bool:
        """Whether every transition is live; a deadlock or a transition that never fires soon refutes it."""
        fires = not self.deadlock and self.quasi_live == self.transitions
        # The first component in which some transition never fires refutes it: others are not looked for.
        fire = (self.transitions <= {*self.space.firings(bottom)} for bottom in self._bottoms())
        return not self.transitions or (fires and all(fire))

    @cached_property
    def _at_bottom(self) -> tuple[frozenset[int], int]:
        """Transitions that fire in each bottom component, and the markings of the only one.

        One forward and one backward closure for each component; a net with a deadlock needs no more of them
        than tell whether there is a second.
        """
        live, home = frozenset() if self.deadlock else self.transitions, 0
        for number, bottom in enumerate(self._bottoms()):
            home = 0 if number else bottom.count()
            # In a component that is no deadlock every transition fires that is enabled somewhere in it.
            live = live.intersection(self.space.firings(bottom))
            if number and not live:
                break
        return live, home

    def _bottoms(self) -> Iterator[S]:
        """The bottom components, one after the other."""
        left = self.space.everything
        while left:
            bottom = self._bottom(left)
            yield bottom
            left = left - self.space.reaching(bottom)

    def _bottom(self, within: S) -> S:
        """A bottom component that some marking of a non-empty set leads to.

        The markings that a marking reaches and that do not lead back to it lie in components further down:
        the search goes on from one of them (Xie, Beerel, *Efficient state classification of finite state
        Markov chains*, DAC 1998).
        """
        while True:
            here = self.space.single(within.pick())
            ahead = self.space.reached(here)
            beyond = ahead - self.space.reaching(here, ahead)
            if not beyond:
                return ahead
            within = beyond


EXAMINATIONS: Mapping[str, Callable[[Behaviour[Any]], bool]] = {
    "ReachabilityDeadlock": lambda does: does.deadlock,
    "QuasiLiveness": lambda does: does.quasi_live == does.transitions,
    "Liveness": lambda does: does.all_live,
    "StableMarking": lambda does: bool(does.constant_places),
}
"""By names of the Model Checking Contest, the properties that need no formula, but for ``OneSafe``."""


@record(frozen=True)
class NetCheck:
    """The behaviour of a net, by names; ``None`` where it is not known.

    Args:
        net: The net.
        safe: Whether no place ever holds two tokens.
        bounded: Whether it is bounded, with runs that show that it is not.
        bound: Most tokens that a place holds.
        states: Reachable markings.
        deadlock: A run to a dead marking, a shortest one where the net is bounded.
        deadlock_free: Whether there is none.
        dead_transitions: Transitions that never fire.
        not_live: Transitions that are not live: from some reachable marking they can never fire again.
        reversible: See :class:`Behaviour`.
        home_markings: The same.
    """

    net: PetriNet
    safe: bool
    bounded: Boundedness
    bound: int | None = None
    states: int | None = None
    deadlock: tuple[str, ...] | None = None
    deadlock_free: bool | None = None
    dead_transitions: tuple[str, ...] | None = None
    not_live: tuple[str, ...] | None = None
    reversible: bool | None = None
    home_markings: int | None = None


def check_net(subject: Spaces | PetriNet) -> NetCheck:
    """Decides the behavioural properties of a net; those that need all of infinitely many markings stay open.

    Args:
        subject: Any net, or its spaces. Its markings are reached as a diagram; those of a net with priorities
            that is not 1-safe are listed one by one, and its coverability tree is made, within the limit that
            spaces are bound to.

    Raises:
        LimitError: A limit was hit.

    Examples:
        >>> from mcpn.testing.nets import philosophers
        >>> found = check_net(philosophers(2))
        >>> found.states, found.safe, found.deadlock
        (18, True, ('wake0', 'left0', 'wake1', 'left1'))
    """
    spaces = spaces_of(subject)
    net, (space, bounded, most) = spaces.net, _reached(spaces)
    if space is None or most is None:
        # A search may still find a deadlock, or that there is none.
        for _, found in () if net.priorities else Portfolio(net).decide([DEADLOCK]):
            run = None if found.run is None else _names(net, found.run)
            return NetCheck(net, False, bounded, deadlock=run, deadlock_free=not found.reachable)
        return NetCheck(net, False, bounded)
    does = Behaviour(space)
    to_death = space.run(space.initial.pick(), space.dead)
    return NetCheck(
        net=net,
        safe=most <= 1,
        bounded=bounded,
        bound=most,
        states=space.everything.count(),
        deadlock=None if to_death is None else _names(net, [edge.transition for edge in to_death]),
        deadlock_free=not does.deadlock,
        dead_transitions=_names(net, sorted(does.transitions - does.quasi_live)),
        not_live=_names(net, sorted(does.transitions - does.live)),
        reversible=does.reversible,
        home_markings=does.home_markings,
    )


def _reached(spaces: Spaces) -> tuple[Space[Any] | None, Boundedness, int | None]:
    """The markings of a bounded net, whether it is bounded, and the most tokens in a place."""
    try:
        space = spaces.diagram
    except UnsafeError:
        limit = MOST_LISTED if spaces.max_states is None else spaces.max_states
        bounded = boundedness(spaces.net, max_states=limit)
        if not bounded.bounded:
            return None, bounded, None
        return spaces.with_tokens(limit), bounded, _own_most(spaces.net, bounded.bounds, bounded.bound)
    except UnboundedError as error:
        return None, Boundedness(False, error.bounds, error.run, error.pump, REPEATED), None
    most = space.space.max_tokens_in_place
    if most <= 1:
        return space, Boundedness(True, None, reason="a 1-safe net is bounded"), most
    bounds = tuple(space.encoding.most(space.everything))
    found = Boundedness(True, bounds, reason="all its markings were reached")
    return space, found, _own_most(spaces.net, bounds, most)


def _own_most(net: PetriNet, bounds: tuple[int, ...] | None, most: int | None) -> int | None:
    """The most tokens in a place that stands for no inhibitor arcs, by the bounds of all."""
    if not net.complements or bounds is None:
        return most
    return max((bound for place, bound in enumerate(bounds) if place not in net.complements), default=0)


def _names(net: PetriNet, transitions: Iterable[int]) -> tuple[str, ...]:
    return tuple(net.transitions[t].name for t in transitions)
