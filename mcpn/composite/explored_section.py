"""What is known of a local net: its stable states and the big steps between them, or all its markings.

Where enough orders of what follows each event are tried for all stable states
(:mod:`mcpn.spaces.stable.big_steps`), that is the proof that each event has one outcome, and no transient
marking is wanted again. Elsewhere, and where these are very many, all markings are reached as a diagram, and
the proof is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.errors import LimitError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.order import clustered
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives
from mcpn.spaces.diagrams.symbolic import DEFAULT_MEMORY, reach
from mcpn.spaces.markings.explicit import KernelNet
from mcpn.spaces.stable.big_steps import MOST_STEPS, BigStepSpace, Steps, reach_in_big_steps
from mcpn.spaces.stable.confluence_by_ranks import open_conflicts


@dataclass
class Explored:
    """What is known of a local net, from every state of its hardware.

    What has been proved in one process is known in another to which this goes.

    Args:
        space: Its reachable markings; where it has big steps, the stable ones alone.
        steps: Its big steps, each proved to be the one outcome of its event; ``None`` where it has none.
        also: By transition, levels that must be marked besides the conditions of its big steps.
    """

    space: SymbolicSpace
    steps: Steps | None = None
    also: Mapping[int, Collection[int]] = field(default_factory=dict)

    @cached_property
    def conflicts(self) -> list[tuple[int, int]]:
        """Pairs of internal transitions in conflict that leave it open whether events have one outcome."""
        return list(open_conflicts(self.space.encoding, self.space.reachable)) if self.steps is None else []

    @cached_property
    def ends(self) -> bool:
        """Whether from each marking some internal run leads to a stable one."""
        return self.steps is not None or not self.space.endless

    def alternatives(self) -> DiagramAlternatives:
        """The alternatives graph."""
        return self._of(self.space)

    def on(self, encoding: Encoding, widened: Callable[[Zdd], Zdd]) -> DiagramAlternatives:
        """The alternatives graph on another store.

        Args:
            encoding: The net on its levels, in the same order.
            widened: Maps each set, copied to that store, to the set that is meant there.
        """

        def put(states: Zdd) -> Zdd:
            return widened(encoding.store.from_bytes(states.to_bytes()))

        space = self.space
        assert space.stable is not None, "nets of missions have priorities"
        stable = put(space.stable)
        reached = stable if self.steps is not None else put(space.reachable)
        return self._of(replace(space, encoding=encoding, reached=reached, stable=stable))

    def _of(self, space: SymbolicSpace) -> DiagramAlternatives:
        return (
            DiagramAlternatives(space) if self.steps is None else BigStepSpace(space, self.steps, self.also)
        )


def explore_local(net: PetriNet, dying: PetriNet | None = None) -> Explored:
    """What is known of a local net.

    Args:
        net: The net.
        dying: Where given, the same net with hardware that may die
            (:func:`mcpn.drawing.permanent_loss.mortal`): then it is this one that is explored.
            Death only disables repairs, so the big steps of ``net`` prove that events have one outcome
            in it, too.

    Raises:
        UnsafeError: The net is not 1-safe.
        LimitError: A limit was hit.
    """
    explored_net = net if dying is None else dying
    name, places = "clusters", clustered(explored_net)
    encoding = Encoding(explored_net, places, DEFAULT_MEMORY)
    big_steps = reach_in_big_steps(KernelNet(net), encoding)
    if big_steps is None:
        try:
            return Explored(reach(explored_net))
        except LimitError:
            encoding = Encoding(explored_net, places, DEFAULT_MEMORY)
            big_steps = reach_in_big_steps(KernelNet(net), encoding, most=MOST_STEPS)
            if big_steps is None:
                raise
    stable, steps, also = (
        (*big_steps, {}) if dying is None else _with_losses(encoding, len(net.places), *big_steps)
    )
    space = SymbolicSpace(encoding, stable, stable, name, places, encoding.store.peak_nodes)
    return Explored(space, steps, also)


def _with_losses(
    encoding: Encoding, first: int, stable: Zdd, steps: Mapping[int, bytes]
) -> tuple[Zdd, Steps, dict[int, list[int]]]:
    """Extends stable states and big steps by losses: what is out of service may be lost, at any moment.

    From a stable state in which some hardware is out of service, any of it may die, and nothing else changes.
    A state with hardware that has died before is one of these, since what has died is not repaired.

    Args:
        encoding: The net with hardware that may die.
        first: The first of its places that say what is alive and what is dead.
        stable: Stable states, as if nothing were dead or alive.
        steps: The big steps between them.

    Returns:
        States, big steps, and by transition the levels that tell that what it repairs is alive.
    """
    safe, events = encoding.net.safe_transitions, encoding.events
    losses = {p: t for t in events for p in safe[t].consume if p >= first}
    all_alive = encoding.store.event([], encoding.levels(losses))
    stable = stable.images([all_alive]).saturate([events[t] for t in losses.values()])
    also = {t: encoding.levels(p for p in safe[t].read if p >= first) for t in steps}
    return stable, {**steps, **dict.fromkeys(losses.values())}, also


def explore_and_prove(net: PetriNet, dying: PetriNet | None = None) -> Explored:
    """What is known of a local net, with all that a worker can prove of it; see :func:`explore_local`."""
    explored = explore_local(net, dying)
    if dying is None:
        _ = explored.conflicts, explored.ends  # asked for here, they are known where this goes
    return explored
