"""A space of stable states written out: the alternatives graph in arrays, whichever engine made the space."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from mcpn.errors import LimitError
from mcpn.spaces.algebra import Space
from mcpn.spaces.markings.graph import pack
from mcpn.spaces.stable.alternatives import AlternativesGraph, numbered
from mcpn.spaces.stable.run_to_completion import (
    MAX_STABLE_STATES,
)


def written_out(space: Space[Any], method: str, max_states: int | None = None) -> AlternativesGraph:
    """Lists the states of an alternatives graph one by one.

    Args:
        space: The alternatives graph of a net with priorities.
        method: What the graph is to say of how it was made.
        max_states: How many states it may have.

    Returns:
        The graph, numbered as :func:`mcpn.spaces.stable.alternatives.direct` numbers it.

    Raises:
        LimitError: It has more states than allowed.
    """
    size, limit = space.everything.count(), MAX_STABLE_STATES if max_states is None else max_states
    if size > limit:
        raise LimitError(f"{size} states, more than {limit}: the limit on states was hit")

    def edges(state: Any) -> Iterator[tuple[int, Any]]:
        for edge in sorted(space.edges(state), key=lambda edge: edge.transition):
            yield edge.transition, _key(edge.target)

    states, arrays = numbered(_key(space.initial.pick()), edges)
    markings = (sum(1 << p for p, tokens in enumerate(space.marking(state)) if tokens) for state in states)
    return AlternativesGraph(space.net, pack(markings, len(space.net.places)), *arrays, method, None)


def _key(state: Any) -> Any:
    return tuple(state) if isinstance(state, list) else state
