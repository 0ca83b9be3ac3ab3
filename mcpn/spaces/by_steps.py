"""What every space can do that knows single steps: closures, what stays in a set, shortest runs.

A space that derives from :class:`BySteps` brings its sets, what its states say, and one step each way;
it overrides what it does more quickly.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cached_property
from typing import Any, Generic

from mcpn.spaces.algebra import Edge, Guards, Piece, S, Space


class BySteps(Generic[S]):
    """The base of spaces that know single steps.

    Who derives from it has ``net``, ``initial``, ``everything``, ``dead``, ``single``,
    ``enabling``, ``before``, ``after`` and ``edges`` of :class:`Space`.
    """

    @cached_property
    def regions(self: Space[S]) -> Sequence[S]:
        """One region: cycles may be anywhere."""
        return (self.everything,)

    @cached_property
    def stable(self: Space[S]) -> S:
        """States that enable no internal transition; all where the net has no priorities."""
        if not self.net.priorities:
            return self.everything
        return self.everything - self.enabling(self.net.events.internal)

    def varying(self: Space[S], states: S) -> Collection[int]:
        """All places."""
        return range(len(self.net.places))

    def pieces(self: Space[S], states: S) -> Iterator[Piece[S]]:
        """One piece, unless there is none."""
        return iter((Piece(states),) if states else ())

    def reaching(
        self: Space[S],
        goal: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> S:
        """States from which some run through ``along`` leads into a goal, the goal's own included."""
        found = new = goal
        while new:
            new = self.before(new, transitions, guards, along) - found
            found = found | new
        return found

    def reached(
        self: Space[S],
        begin: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> S:
        """States of ``along`` to which some run through it leads, those it begins from included."""
        found = new = begin if along is None else begin & along
        while new:
            after = self.after(new, transitions, guards)
            new = (after if along is None else after & along) - found
            found = found | new
        return found

    def crossing(self: Space[S], among: S, into: S) -> Iterator[tuple[int, S]]:
        """Transitions with edges from some states into others, each with the states before it."""
        candidates = self.before(into, among=among)
        for t in sorted(self.firings(candidates)) if candidates else ():
            if states := self.before(into, [t], among=candidates):
                yield t, states

    def staying(
        self: Space[S], along: S, asked: S | None = None, transitions: Collection[int] | None = None
    ) -> S:
        """States from which some maximal run stays in a set; see :meth:`Space.staying`."""
        stays, ends = along, self.dead if transitions is None else along - self.enabling(transitions)
        while lost := stays - (self.before(stays, transitions) | ends):
            stays = stays - lost
        return stays

    def reaches_without(self: Space[S], goal: S, left_out: Sequence[frozenset[int]]) -> Sequence[bool]:
        """Whether the initial state reaches a goal without some transitions, for each of several sets."""
        every = frozenset(range(len(self.net.transitions)))
        return [bool(self.reaching(goal, transitions=every - few) & self.initial) for few in left_out]

    def run(
        self: Space[S],
        begin: Any,
        goal: S,
        along: S | None = None,
        transitions: Collection[int] | None = None,
        guards: Guards[S] = None,
    ) -> list[Edge] | None:
        """A shortest run from a member into a goal: by layers back, then forward by the first edge."""
        layers = layers_back(
            self.single(begin), goal, lambda states: self.before(states, transitions, guards, along)
        )
        if layers is None:
            return None
        found, wanted = list[Edge](), None if transitions is None else frozenset(transitions)
        for layer in reversed(layers[:-1]):
            here = self.single(begin)
            found.append(
                next(
                    edge
                    for edge in self.edges(begin)
                    if (wanted is None or edge.transition in wanted)
                    and self.single(edge.target) & layer
                    and (not guards or here & guards.get(edge.transition, here))
                )
            )
            begin = found[-1].target
        return found


def layers_back(start: S, goal: S, back: Callable[[S], S]) -> list[S] | None:
    """Backward breadth-first layers, by length of shortest runs to a goal, until one meets some states."""
    layers, seen = [goal], goal
    while not layers[-1] & start:
        earlier = back(layers[-1]) - seen
        if not earlier:
            return None
        seen = seen | earlier
        layers.append(earlier)
    return layers
