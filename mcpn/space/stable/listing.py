"""A space of stable states written out: the alternatives graph in arrays, whichever engine made the space."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcpn.errors import LimitError
from mcpn.space.algebra import Space
from mcpn.space.markings.graph import pack
from mcpn.space.stable.alternatives import DEFAULT_MAX_STATES, AlternativesGraph


def written_out(space: Space[Any], method: str, max_states: int | None = None) -> AlternativesGraph:
    """Lists the states of an alternatives graph one by one.

    Args:
        space: The alternatives graph of a net with priorities.
        method: What the graph is to say of how it was made.
        max_states: How many states it may have.

    Returns:
        The graph, numbered as :func:`mcpn.space.stable.alternatives.direct` numbers it.

    Raises:
        LimitError: It has more states than allowed.
    """
    size, limit = space.everything.count(), DEFAULT_MAX_STATES if max_states is None else max_states
    if size > limit:
        raise LimitError(f"{size} states, more than {limit}: the limit on states was hit")
    queue = [space.initial.pick()]
    numbers = {_key(queue[0]): 0}
    offsets, targets, labels = [0], list[int](), list[int]()
    for state in queue:  # grows while it is walked
        for edge in sorted(space.edges(state), key=lambda edge: edge.transition):
            key = _key(edge.target)
            if numbers.setdefault(key, len(queue)) == len(queue):
                queue.append(edge.target)
            targets.append(numbers[key])
            labels.append(edge.transition)
        offsets.append(len(targets))
    markings = (sum(1 << p for p, tokens in enumerate(space.marking(state)) if tokens) for state in queue)
    words = pack(markings, len(space.net.places))
    starts, ends, fired = (np.array(values, np.int64) for values in (offsets, targets, labels))
    return AlternativesGraph(space.net, words, starts, ends, fired, method, None)


def _key(state: Any) -> Any:
    return tuple(state) if isinstance(state, list) else state
