"""What is known of a state space's sizes, as a record, and made of what an engine has built or counted."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mcpn.nets.petri import PetriNet
from mcpn.spaces.engine_names import EXPLICIT, PYEDA, SYMBOLIC
from mcpn.spaces.markings.explicit import Counts

if TYPE_CHECKING:
    from mcpn.spaces.custom_engine import OwnSpace
    from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
    from mcpn.spaces.pyeda_reference import ReferenceCounts


ENGINES = (EXPLICIT, SYMBOLIC, PYEDA)
"""The engines that count: marking by marking, by decision diagrams, and the independent reference."""


@dataclass(frozen=True)
class SpaceSummary:
    """Sizes of a state space, exact integers of any size; ``None`` for what was not counted.

    Args:
        places: Of the net.
        transitions: Of the net.
        states: Reachable markings.
        edges: Firings, priorities respected.
        stable_states: Markings that enable no internal transition; ``None`` for nets without priorities.
        dead_states: Markings that enable no transition.
        max_tokens: Most tokens in a marking.
        max_tokens_in_place: Most tokens in a place.
        nodes: Of the final decision diagram; ``None`` where there is none.
        engine: One of :data:`ENGINES`, ``local``, or the name of an engine of the caller's own.
        seconds: Wall-clock time of the engine.
        order: Name of the diagram's order of places; ``None`` where there is none.
        peak_nodes: Most nodes at once while the diagram was made; ``None`` where there is none.
    """

    places: int
    transitions: int
    states: int | None
    edges: int | None
    stable_states: int | None
    dead_states: int | None
    max_tokens: int | None
    max_tokens_in_place: int | None
    nodes: int | None
    engine: str
    seconds: float
    order: str | None = None
    peak_nodes: int | None = None


def summary_of(space: SymbolicSpace, started: float) -> SpaceSummary:
    """The sizes of markings reached as a diagram.

    Args:
        space: The reachable markings.
        started: When reaching them began, by :func:`time.perf_counter`.
    """
    net = space.encoding.net
    stable = None if space.stable is None else space.stable.count()
    return SpaceSummary(
        places=len(net.places),
        transitions=len(net.transitions),
        states=space.states,
        edges=space.edges,
        stable_states=stable,
        dead_states=space.dead_states,
        max_tokens=space.max_tokens,
        max_tokens_in_place=space.max_tokens_in_place,
        nodes=space.nodes,
        engine=SYMBOLIC,
        seconds=time.perf_counter() - started,
        order=space.order,
        peak_nodes=None if space.nodes is None else space.peak_nodes,
    )


def summary_of_counts(
    net: PetriNet, counts: Counts | ReferenceCounts, engine: str, started: float
) -> SpaceSummary:
    """The sizes of a markings graph whose markings were counted, not kept.

    Args:
        net: The net.
        counts: The counts.
        engine: Who has counted.
        started: When counting began, by :func:`time.perf_counter`.
    """
    nodes = peak_nodes = None
    if isinstance(counts, Counts):
        stable, dead = counts.stable if net.priorities else None, counts.dead
    else:
        stable, dead = counts.stable_states, counts.dead_states
        nodes, peak_nodes = counts.nodes, counts.peak_nodes
    bounds: tuple[int, ...] = getattr(counts, "bounds", (min(counts.max_tokens, 1),))
    return SpaceSummary(
        *(len(net.places), len(net.transitions)),
        *(counts.states, counts.edges, stable, dead, counts.max_tokens, max(bounds, default=0)),
        nodes,
        engine,
        time.perf_counter() - started,
        None if nodes is None else "clustered",
        peak_nodes,
    )


def summary_of_own(space: OwnSpace, engine: str, started: float) -> SpaceSummary:
    """The sizes of a space over an engine of the caller's own.

    Args:
        space: The markings graph.
        engine: The engine's name.
        started: When the space was asked for, by :func:`time.perf_counter`.
    """
    net, reached = space.net, space.everything
    nodes = getattr(space.sets, "nodes", None)
    return SpaceSummary(
        places=len(net.places),
        transitions=len(net.transitions),
        states=reached.count(),
        edges=sum(space.firings(reached).values()),
        stable_states=space.stable.count() if net.priorities else None,
        dead_states=space.dead.count(),
        max_tokens=None,
        max_tokens_in_place=None,
        nodes=None if nodes is None else nodes(reached.raw),
        engine=engine,
        seconds=time.perf_counter() - started,
        order=getattr(space.sets, "order", None),
    )
