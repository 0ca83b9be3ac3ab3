"""What can be said of a net that is of no mission: its behaviour, and its structure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from mcpn.check.nets.behaviour import behaviour
from mcpn.errors import LimitError, UnboundedError, UnsafeError
from mcpn.net.petri import PetriNet
from mcpn.net.siphons import (
    Places,
    classes,
    commoner,
    p_semiflows,
    siphons,
    state_machine_components,
    t_semiflows,
    traps,
)
from mcpn.net.structure import Sparse
from mcpn.space.algebra import Space
from mcpn.space.diagrams.bounded import reach_markings
from mcpn.space.diagrams.spaces import DiagramMarkings
from mcpn.space.markings.counted import explore_tokens
from mcpn.space.markings.tokens import REPEATED, Boundedness, boundedness
from mcpn.space.search.goal import DEADLOCK
from mcpn.space.search.portfolio import Portfolio


@dataclass(frozen=True)
class NetCheck:
    """The behaviour of a net; ``None`` where it is not known.

    Args:
        net: The net.
        safe: Whether no place ever holds two tokens.
        bounded: Whether it is bounded, with runs that show that it is not.
        bound: Most tokens that a place holds.
        states: Reachable markings.
        deadlock: A run to a dead marking, a shortest one where the net is bounded; empty where the initial
            one is dead.
        dead_transitions: Names of transitions that never fire.
        not_live: Names of those that some day fire no more.
        reversible: Whether every marking leads back to the initial one.
        home_markings: Number of markings that every marking leads to.
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


def check_net(net: PetriNet, *, max_states: int = 1_000_000) -> NetCheck:
    """Decides the behavioural properties of a net.

    Args:
        net: Any net. Its markings are reached as a diagram; those of a net with priorities that is not 1-safe
            are listed one by one, up to the limit.
        max_states: Limit for those, and for the coverability tree.

    Returns:
        The properties; those that need every marking of an unbounded net are left open.

    Raises:
        LimitError: A limit was hit.
    """
    space, bounded, most = _reached(net, max_states)
    if space is None or most is None:
        # A search may still find a deadlock, or that there is none.
        for _, found in () if net.priorities else Portfolio(net).decide([DEADLOCK]):
            run = None if found.run is None else _names(net, found.run)
            return NetCheck(net, False, bounded, deadlock=run, deadlock_free=not found.reachable)
        return NetCheck(net, False, bounded)
    does = behaviour(space)
    to_death = space.run(space.initial.pick(), space.dead)
    every = frozenset(range(len(net.transitions)))
    return NetCheck(
        net,
        most <= 1,
        bounded,
        most,
        space.everything.count(),
        None if to_death is None else _names(net, [edge.transition for edge in to_death]),
        not does.deadlock,
        _names(net, sorted(every - does.quasi_live)),
        _names(net, sorted(every - does.live)),
        does.reversible,
        does.home_markings,
    )


def _reached(net: PetriNet, max_states: int) -> tuple[Space[Any] | None, Boundedness, int | None]:
    """The markings of a bounded net, whether it is bounded, and the most tokens in a place."""
    try:
        space = DiagramMarkings(reach_markings(net))
    except UnsafeError:
        bounded = boundedness(net, max_states=max_states)
        if not bounded.bounded:
            return None, bounded, None
        from mcpn.space.arrays import ArraySpace

        return ArraySpace(explore_tokens(net, max_states=max_states)), bounded, bounded.bound
    except UnboundedError as error:
        return None, Boundedness(False, error.bounds, error.run, error.pump, REPEATED), None
    most = space.space.max_tokens_in_place
    if most <= 1:
        return space, Boundedness(True, None, reason="a 1-safe net is bounded"), most
    bounds = tuple(space.encoding.most(space.everything))
    return space, Boundedness(True, bounds, reason="all its markings were reached"), most


def _names(net: PetriNet, transitions: Iterable[int]) -> tuple[str, ...]:
    return tuple(net.transitions[t].name for t in transitions)


def marking_after(net: PetriNet, run: tuple[str, ...]) -> dict[str, int]:
    """The tokens of each marked place after a run."""
    marking = net.initial
    for name in run:
        marking = net.fire(marking, net.transition_index[name])
    return {place.name: tokens for place, tokens in zip(net.places, marking, strict=True) if tokens}


@dataclass(frozen=True)
class Structure:
    """What the arcs of a net tell without its markings; a part whose limit was hit is left out and named.

    Args:
        net: The net.
        classes: See :func:`mcpn.net.siphons.classes`.
        p_semiflows: Weights by place whose weighted sum of tokens never changes.
        t_semiflows: Numbers of firings that change nothing.
        siphons: Minimal ones.
        traps: Minimal ones.
        components: State machine components.
        unmarked_siphon: A minimal siphon without a marked trap, if there is one.
        left_out: What was left out, and which limit was hit.
    """

    net: PetriNet
    classes: frozenset[str]
    p_semiflows: tuple[Sparse, ...] | None = None
    t_semiflows: tuple[Sparse, ...] | None = None
    siphons: tuple[Places, ...] | None = None
    traps: tuple[Places, ...] | None = None
    components: tuple[Places, ...] | None = None
    unmarked_siphon: Places | None = None
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def conservative(self) -> bool | None:
        """Whether some positive weighting of all places never changes; then the net is bounded."""
        return None if self.p_semiflows is None else self._every_place(self.p_semiflows)

    @property
    def covered(self) -> bool | None:
        """Whether every place is in some state machine component."""
        return None if self.components is None else self._every_place(self.components)

    def _every_place(self, parts: Iterable[Iterable[int]]) -> bool:
        return set().union(*parts) == set(range(len(self.net.places)))

    @property
    def proves(self) -> list[str]:
        """What follows, whatever the order of firing."""
        found = []
        if self.conservative:
            found.append("bounded, whatever the initial marking: every place is in a P-semiflow")
        if self.components is not None and "ordinary" in self.classes:
            initial = self.net.initial
            if self._every_place(c for c in self.components if sum(initial[p] for p in c) == 1):
                found.append("1-safe: every place is in a state machine component with one token")
        decided = {"ordinary", "free choice"} <= self.classes and not self.net.priorities
        if decided and self.siphons is not None and self.traps is not None:
            live = self.unmarked_siphon is None
            why = "every minimal siphon contains" if live else "a minimal siphon does not contain"
            found.append(f"{'live' if live else 'not live'}: free choice, and {why} a marked trap")
        return found


def examine_structure(net: PetriNet) -> Structure:
    """Looks at the arcs of a net alone.

    Args:
        net: Any net.

    Returns:
        Its structure, as far as the limits go.
    """
    left_out: dict[str, str] = {}
    parts: dict[str, object] = {}
    for name, find in (
        ("p_semiflows", p_semiflows),
        ("t_semiflows", t_semiflows),
        ("siphons", siphons),
        ("traps", traps),
        ("components", state_machine_components),
        ("unmarked_siphon", commoner),
    ):
        try:
            parts[name] = find(net)
        except LimitError as error:
            left_out[name] = str(error)
    return Structure(net, classes(net), left_out=left_out, **parts)  # type: ignore[arg-type]
