"""Shows why evolution is not confluent: the two firings that decide in which stable marking it ends."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

After: TypeAlias = Mapping[int, Mapping[int, int]]
"""By marking, the markings after its internal transitions, by transition; none for a stable marking."""


def parting_runs(after: After, start: int) -> tuple[list[int], list[int]]:
    """Two short runs from a marking with several stable ends.

    They part at two transitions each of which decides the end: neither can follow the other to the same
    marking, so that they are in conflict. (Where runs need not end there may be no such two: then the runs
    are any two to different ends.)

    Args:
        after: Every marking that internal evolution comes to from the start.
        start: The marking with several stable ends.

    Returns:
        Transitions of both runs, equal up to where they part.
    """
    ends = _ends(after)
    order = _breadth_first(after, start)
    for marking, way in order.items():
        deciding: dict[int, int] = {}
        for t, successor in after[marking].items():
            if len(ends[successor]) == 1:
                deciding.setdefault(next(iter(ends[successor])), t)
        if len(deciding) > 1:
            first, second = list(deciding.values())[:2]
            return (
                [*way, first, *_to_end(after, after[marking][first])],
                [*way, second, *_to_end(after, after[marking][second])],
            )
    one, other = [way for marking, way in order.items() if not after[marking]][:2]
    return one, other


def _to_end(after: After, start: int) -> list[int]:
    return next(way for marking, way in _breadth_first(after, start).items() if not after[marking])


def _breadth_first(after: After, start: int) -> dict[int, list[int]]:
    """Transitions of a shortest run to each marking, nearest first."""
    ways: dict[int, list[int]] = {start: []}
    queue = [start]
    for marking in queue:
        for t, successor in after[marking].items():
            if successor not in ways:
                ways[successor] = [*ways[marking], t]
                queue.append(successor)
    return ways


def _ends(after: After) -> dict[int, set[int]]:
    """By marking, the stable markings to which runs from it lead."""
    before: dict[int, list[int]] = {}
    for marking, successors in after.items():
        for successor in successors.values():
            before.setdefault(successor, []).append(marking)
    ends: dict[int, set[int]] = {marking: set() for marking in after}
    for end in (marking for marking, successors in after.items() if not successors):
        waiting = [end]
        while waiting:
            marking = waiting.pop()
            if end not in ends[marking]:
                ends[marking].add(end)
                waiting.extend(before.get(marking, ()))
    return ends
