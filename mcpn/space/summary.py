"""The sizes of a state space, from whichever engine counts them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mcpn.errors import LimitError
from mcpn.net.petri import PetriNet
from mcpn.space.markings.explicit import MAX_MARKINGS, Progress

if TYPE_CHECKING:
    from mcpn.space.diagrams.symbolic import SymbolicSpace

ENGINES = ("explicit", "symbolic", "pyeda")
"""The engines that count: marking by marking, by decision diagrams, and the small independent reference."""


MOST_PLACES_FOR_PYEDA = 24
"""Beyond, pyeda's BDDs may take hours."""


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
        engine: One of :data:`ENGINES`, or ``local``.
        seconds: Wall-clock time of the engine.
        order: Name of the diagram's order of places; ``None`` where there is none.
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


def summarise(
    net: PetriNet, engine: str, *, max_states: int | None = None, progress: Progress | None = None
) -> SpaceSummary:
    """Explores a net and says its sizes.

    Args:
        net: The net.
        engine: One of :data:`ENGINES`.
        max_states: Limit for the explicit engine.
        progress: Called now and then by the explicit engine.

    Returns:
        The sizes.

    Raises:
        UnsafeError: The net is not 1-safe, and has priorities or the engine is pyeda.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit, or the engine is not installed.
    """
    started = time.perf_counter()
    if engine == "symbolic":
        from mcpn.space.diagrams.bounded import reach_markings

        return summary_of(reach_markings(net), started)
    counts = _explicit(net, max_states or MAX_MARKINGS, progress) if engine == "explicit" else _pyeda(net)
    states, edges, stable, dead, tokens, in_place = counts
    seconds = time.perf_counter() - started
    sizes = len(net.places), len(net.transitions)
    return SpaceSummary(*sizes, states, edges, stable, dead, tokens, in_place, None, engine, seconds)


def summary_of(space: SymbolicSpace, started: float) -> SpaceSummary:
    """The sizes of markings reached as a diagram.

    Args:
        space: The reachable markings.
        started: When reaching them began, by :func:`time.perf_counter`.
    """
    net = space.encoding.net
    stable = None if space.stable is None else space.stable.count()
    return SpaceSummary(
        len(net.places),
        len(net.transitions),
        space.states,
        space.edges,
        stable,
        space.dead_states,
        space.max_tokens,
        space.max_tokens_in_place,
        space.nodes,
        "symbolic",
        time.perf_counter() - started,
        space.order,
    )


_Counts = tuple[int, int, int | None, int, int, int]


def _explicit(net: PetriNet, max_states: int, progress: Callable[[int, int], None] | None) -> _Counts:
    from mcpn.space.markings.counted import TokenCounts, count_markings

    found = count_markings(net, max_states=max_states, progress=progress)
    stable = found.stable if net.priorities else None
    in_place = min(found.max_tokens, 1)
    if isinstance(found, TokenCounts):
        in_place = max(found.bounds, default=0)
    return found.states, found.edges, stable, found.dead, found.max_tokens, in_place


def _pyeda(net: PetriNet) -> _Counts:
    if len(net.places) > MOST_PLACES_FOR_PYEDA:
        raise LimitError(f"more than {MOST_PLACES_FOR_PYEDA} places, the limit of the reference engine")
    try:
        from mcpn.space.pyeda_reference import count

        found = count(net)
    except ImportError as error:
        raise LimitError("the reference engine needs pyeda: pip install 'mcpn[pyeda]'") from error
    sizes = found.states, found.edges, found.stable_states, found.dead_states, found.max_tokens
    return *sizes, min(found.max_tokens, 1)
