"""The markings graph, explored one marking at a time, breadth first, priorities respected.

1-safety is not assumed: each firing is checked, and the first one that would put a second token in a place
ends the exploration with that firing and a shortest run to it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from mcpn.errors import LimitError, UnsafeError
from mcpn.net.petri import PetriNet
from mcpn.space.firing import MaskedNet
from mcpn.space.graph import StateGraph, pack

Progress: TypeAlias = Callable[[int, int], None]
"""Called about once a second with the states found and the edges fired so far."""

DEFAULT_MAX_STATES = 20_000_000
BYTES_PER_STATE = 260
BYTES_PER_EDGE = 16


def explore(
    net: PetriNet,
    *,
    max_states: int = DEFAULT_MAX_STATES,
    max_memory: int = 16 << 30,
    progress: Progress | None = None,
) -> StateGraph:
    """Builds the markings graph of a 1-safe net.

    Args:
        net: The net.
        max_states: How many states it may have.
        max_memory: Bytes that states and edges may take, by estimate.
        progress: Called now and then.

    Returns:
        The reachable markings in breadth-first order, and every firing between them.

    Raises:
        UnsafeError: The net is not 1-safe; a shortest run to the unsafe firing is given.
        LimitError: A limit was hit.
    """
    masked = MaskedNet(net)
    initial = masked.initial()
    index = {initial: 0}
    markings = [initial]
    enabled = [masked.covered(initial)]
    parents: list[tuple[int, int]] = [(-1, -1)]
    offsets, targets, labels = [0], list[int](), list[int]()
    due = time.monotonic() + 1
    for state, marking in enumerate(markings):  # grows while it is walked: a queue
        covered = enabled[state]
        enabled[state] = 0
        for t in masked.allowed(covered):
            after, doubled = masked.fire(marking, t)
            if doubled:
                raise _unsafe(net, marking, t, doubled, _run(net, parents, state))
            target = index.setdefault(after, len(markings))
            if target == len(markings):
                markings.append(after)
                enabled.append(masked.covered_after(covered, after, t))
                parents.append((state, t))
            targets.append(target)
            labels.append(t)
        offsets.append(len(targets))
        if len(markings) > max_states:
            raise LimitError(f"more than {max_states} states: the limit on states was hit")
        if len(markings) * BYTES_PER_STATE + len(targets) * BYTES_PER_EDGE > max_memory:
            raise LimitError(f"more than {max_memory} bytes: the limit on memory was hit at {state} states")
        if progress and time.monotonic() > due:
            progress(len(markings), len(targets))
            due = time.monotonic() + 1
    return StateGraph(
        net,
        pack(markings, len(net.places)),
        np.array(offsets, np.int64),
        np.array(targets, np.int64),
        np.array(labels, np.int64),
    )


def _run(net: PetriNet, parents: list[tuple[int, int]], state: int) -> list[str]:
    run = []
    while state:
        state, transition = parents[state]
        run.append(net.transitions[transition].name)
    return run[::-1]


def _unsafe(net: PetriNet, marking: int, transition: int, doubled: int, run: list[str]) -> UnsafeError:
    place = net.places[(doubled & -doubled).bit_length() - 1].name
    marked = (p.name for i, p in enumerate(net.places) if marking >> i & 1)
    return UnsafeError(place, net.transitions[transition].name, marked, run)
