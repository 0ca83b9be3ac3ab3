"""Evidence for claims on the listed states of a mission: runs as transitions, and numbers that fall."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from mcpn.spaces.markings.graph import Ints, Mask
from mcpn.spaces.stable.alternatives import AlternativesGraph

NOWHERE = 0
"""The number of states that need none."""


def marking(graph: AlternativesGraph, places: Collection[int]) -> Mask:
    """The states that mark one of some places."""
    found = np.zeros(graph.states, np.bool_)
    for place in places:
        found |= graph.marked(place)
    return found


def carrying(graph: AlternativesGraph, transitions: Collection[int]) -> Mask:
    """The edges that carry some transitions."""
    return np.isin(graph.labels, np.fromiter(transitions, np.int64, len(transitions)))


def run(graph: AlternativesGraph, goal: Mask, start: int = 0, edges: Mask | None = None) -> list[int] | None:
    """A shortest run into a goal, as transitions; ``None`` where there is none."""
    found = graph.run_to(goal, start, edges)
    return None if found is None else [int(graph.labels[edge]) for edge in found]


def distances(graph: AlternativesGraph, goal: Mask, edges: Mask | None = None) -> Ints:
    """How many events each state is away from a goal, along some edges; -1 where no run leads to it."""
    far = np.where(goal, 0, -1).astype(np.int64)
    frontier, step = goal.copy(), 0
    while frontier.any():
        step += 1
        frontier = graph.before(frontier, edges) & (far < 0)
        far[frontier] = step
    return far


def nearer(graph: AlternativesGraph, far: Ints, start: int, edges: Mask) -> list[int]:
    """A shortest run along some edges to where :func:`distances` along them are 0, as transitions."""
    run = list[int]()
    while far[start]:
        here = range(int(graph.offsets[start]), int(graph.offsets[start + 1]))
        edge = next(e for e in here if edges[e] and far[graph.targets[e]] == far[start] - 1)
        run.append(int(graph.labels[edge]))
        start = int(graph.targets[edge])
    return run


def falling(graph: AlternativesGraph, edges: Mask, within: Mask) -> Ints | None:
    """Numbers that fall along some edges between some states: the length of the longest way along them.

    Returns:
        A number for each state, :data:`NOWHERE` outside; ``None`` where the edges have a cycle there.
    """
    kept = np.flatnonzero(edges & within[graph.sources] & within[graph.targets])
    numbers, left = np.full(graph.states, NOWHERE, np.int64), within.copy()
    sources, targets = graph.sources[kept], graph.targets[kept].astype(np.int64)
    step = NOWHERE
    while left.any():
        step += 1
        onward = np.zeros(graph.states, np.bool_)
        onward[sources[left[targets]]] = True
        done = left & ~onward
        if not done.any():
            return None
        numbers[done] = step
        left &= onward
    return numbers
