"""The stable states of a local net, and the steps between them: listed where they are few, reached where not.

Where the stable states can be listed along enough orders of what follows each event
(:mod:`mcpn.space.stable.settling`), that is the proof that each event has one outcome, and no transient
marking is wanted again: an event is a few *changes*, each with the states in which it makes them. Elsewhere
all markings are reached as a diagram, and the proof is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple, TypeAlias

from mcpn._kernel import Exploration, Zdd
from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Guards
from mcpn.space.diagrams.encoding import Encoding
from mcpn.space.diagrams.order import candidates
from mcpn.space.diagrams.spaces import DiagramAlternatives, Step
from mcpn.space.diagrams.symbolic import DEFAULT_MEMORY, SymbolicSpace, elements, reach
from mcpn.space.markings.explicit import KernelNet
from mcpn.space.stable.ranks import open_conflicts
from mcpn.space.stable.settling import Orders, settled

MOST_LISTED = 200_000
"""Stable states of a local net that are listed."""
MOST_KEPT = 100_000
"""Transient markings that the proof may keep meanwhile."""
MOST_CHANGES = 20_000
"""Changes by all events together; with more of them, steps on diagrams of all markings are quicker."""


class Change(NamedTuple):
    """What an event makes of some stable states, internal evolution included."""

    transition: int
    lost: list[int]
    """Places that lose their token."""
    gained: list[int]
    """Places that gain one."""
    sources: Zdd
    """The states in which it does so."""


Steps: TypeAlias = dict[int, list[tuple[int, Zdd]]]
"""By transition, events of the store, each with the states before it."""


@dataclass
class Explored:
    """What is known of a local net, from every state of its hardware.

    What has been proved in one process is known in another to which this goes.

    Args:
        space: Its reachable markings; where they were listed, the stable ones alone.
        changes: Where they were listed, what events make of them: each event has one outcome.
    """

    space: SymbolicSpace
    changes: list[Change] | None = None

    @cached_property
    def conflicts(self) -> list[tuple[int, int]]:
        """Pairs of internal transitions in conflict that leave it open whether events have one outcome."""
        return list(open_conflicts(self.space.encoding, self.space.reachable)) if self.changes is None else []

    @cached_property
    def ends(self) -> bool:
        """Whether internal evolution may end, whatever has happened."""
        return self.changes is not None or not self.space.endless

    def __getstate__(self) -> dict[str, Any]:
        """Sets go from process to process as tables of their diagrams."""
        told: list[Any] | None = None
        if self.changes is not None:
            told = [(*change[:3], change.sources.to_bytes()) for change in self.changes]
        return {**vars(self), "changes": told}

    def __setstate__(self, told: dict[str, Any]) -> None:
        """The sets are put on the store of the space."""
        vars(self).update(told)
        if self.changes is not None:
            put = self.space.encoding.store.from_bytes
            self.changes = [
                Change(t, lost, gained, put(sources)) for t, lost, gained, sources in told["changes"]
            ]

    def alternatives(self) -> DiagramAlternatives:
        """The alternatives graph."""
        return DiagramAlternatives(self.space) if self.changes is None else BigSteps(self.space, self.changes)

    def on(self, encoding: Encoding, widened: Callable[[Zdd], Zdd]) -> DiagramAlternatives:
        """The alternatives graph on another store.

        Args:
            encoding: The net on its levels, in the same order.
            widened: What becomes of each set there.
        """

        def put(states: Zdd) -> Zdd:
            return widened(encoding.store.from_bytes(states.to_bytes()))

        space = self.space
        assert space.stable is not None, "nets of missions have priorities"
        stable = put(space.stable)
        if self.changes is None:
            return DiagramAlternatives(
                replace(space, encoding=encoding, reached=put(space.reachable), stable=stable)
            )
        changes = [change._replace(sources=put(change.sources)) for change in self.changes]
        return BigSteps(replace(space, encoding=encoding, reached=stable, stable=stable), changes)


def explore_local(net: PetriNet, dying: PetriNet | None = None) -> Explored:
    """What is known of a local net.

    Args:
        net: The net.
        dying: The same net with hardware that may die (:func:`mcpn.net.mortal.mortal`): then what is known of
            this one. Dying changes nothing but what may be repaired, so events are known to have one outcome
            there.

    Raises:
        UnsafeError: The net is not 1-safe.
        LimitError: A limit was hit.
    """
    of = net if dying is None else dying
    found = _listed(net, proved=dying is None)
    if found is None:
        return Explored(reach(of))
    prepared, listing = found
    name, places = next(iter(candidates(of)))
    encoding = Encoding(of, places, DEFAULT_MEMORY)
    bits = [place if place < len(net.places) else -1 for place in encoding.places]
    told = encoding.store.changes(listing, bits, MOST_CHANGES)
    if told is None:
        return Explored(reach(of))
    stable = encoding.store.from_exploration(listing, bits)
    changes = [Change(prepared.transitions[label], lost, up, where) for label, lost, up, where in told]
    if dying is not None:
        stable, changes = _with_losses(encoding, len(net.places), stable, changes)
    space = SymbolicSpace(encoding, stable, stable, name, places, encoding.store.peak_nodes)
    return Explored(space, changes)


def _listed(net: PetriNet, *, proved: bool) -> tuple[KernelNet, Exploration] | None:
    """The stable states of a net, and its events; ``None`` where they are many, or an event has no outcome.

    Events without one outcome may be in states that the mission never comes to: a diagram tells.
    """
    prepared = KernelNet(net)
    orders: Orders = "enough" if proved else "one"
    try:
        found = settled(prepared, orders=orders, max_states=MOST_LISTED, max_transient=MOST_KEPT)
    except LimitError:
        return None
    return None if found.trouble is not None else (prepared, found)


def _with_losses(
    encoding: Encoding, first: int, stable: Zdd, changes: Sequence[Change]
) -> tuple[Zdd, list[Change]]:
    """The same where hardware may die: whatever is out of service may be lost, at any moment.

    From a stable state in which some hardware is out of service, any of it may die, and nothing else changes.
    A state with hardware that has died before is one of these, since what has died is not repaired.

    Args:
        encoding: The net with hardware that may die.
        first: The first of its places that say what is alive and what is dead.
        stable: Stable states, as if nothing were dead or alive.
        changes: What events make of them.
    """
    safe, events = encoding.net.safe_transitions, encoding.events
    alive = {p: t for t in events for p in safe[t].consume if p >= first}  # the loss that takes it
    born = [encoding.store.event([], encoding.levels(alive))]

    def lossy(states: Zdd, but: Collection[int] = ()) -> Zdd:
        return states.images(born).saturate([events[t] for p, t in alive.items() if p not in but])

    stable = lossy(stable)
    with_losses = [c._replace(sources=lossy(c.sources, safe[c.transition].read)) for c in changes]
    for t in alive.values():
        sources = encoding.restricted(stable, (*safe[t].consume, *safe[t].read))
        with_losses.append(Change(t, list(safe[t].consume), list(safe[t].produce), sources))
    return stable, with_losses


def explore_and_prove(net: PetriNet, dying: PetriNet | None = None) -> Explored:
    """What is known of a local net, with all that a worker can prove of it; see :func:`explore_local`."""
    found = explore_local(net, dying)
    if dying is None:
        _ = found.conflicts, found.ends  # asked for here, they are known where this goes
    return found


class BigSteps(DiagramAlternatives):
    """The alternatives graph of a net whose events are told by what they change: no transient marking is met.

    Args:
        space: Its stable states.
        changes: What events make of them, each of their sources on the space's store.
    """

    def __init__(self, space: SymbolicSpace, changes: Sequence[Change]) -> None:
        super().__init__(space)
        self._ahead: Steps = {}
        self._back: Steps = {}
        event, levels = self.encoding.store.event, self.encoding.levels
        for t, lost, gained, sources in changes:
            down, up = levels(lost), levels(gained)
            self._ahead.setdefault(t, []).append((event(down, up), sources))
            self._back.setdefault(t, []).append((event(up, down), sources))

    def after(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States that an edge leads to from some states."""
        found = self.nothing
        for event, where in _asked(self._ahead, transitions, guards):
            found |= (states & where).images([event])
        return found

    def before(
        self, states: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> Zdd:
        """States with an edge into some states."""
        found = self.nothing
        for event, where in _asked(self._back, transitions, guards):
            found |= states.images([event], within=where)
        return found

    def ahead(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """One step on along a set, for each element of the mission."""
        return self._by_element(self.after, along, transitions, guards)

    def back(
        self, along: Zdd, transitions: Collection[int] | None = None, guards: Guards[Zdd] = None
    ) -> list[Step]:
        """One step back along a set, for each element of the mission."""
        return self._by_element(self.before, along, transitions, guards)

    def _by_element(
        self,
        stepped: Callable[[Zdd, Collection[int], Guards[Zdd]], Zdd],
        along: Zdd,
        transitions: Collection[int] | None,
        guards: Guards[Zdd],
    ) -> list[Step]:
        def step(states: Zdd, group: Collection[int]) -> Zdd:
            return stepped(states, group, guards) & along

        asked = (
            [t for t in group if transitions is None or t in transitions] for group in elements(self.encoding)
        )
        return [partial(step, group=group) for group in asked if group]


def _asked(
    steps: Steps, transitions: Collection[int] | None, guards: Guards[Zdd]
) -> Iterator[tuple[int, Zdd]]:
    """Events of the store for the transitions that are asked for, each with the states before it."""
    for t in steps if transitions is None else transitions:
        for event, sources in steps.get(t, ()):
            yield event, sources & guards[t] if guards and t in guards else sources
