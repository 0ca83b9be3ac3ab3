"""Runs of errors replayed on the net by its own rule."""

from __future__ import annotations

from collections import deque

from mcpn.nets.petri import Marking, PetriNet


def stable_ends(net: PetriNet, start: Marking) -> set[Marking]:
    """By plain search over internal transitions."""
    seen, queue, ends = {start}, deque([start]), set()
    while queue:
        marking = queue.popleft()
        internal = [t for t in net.enabled(marking) if net.transitions[t].internal]
        if not internal:
            ends.add(marking)
        for after in (net.fire(marking, t) for t in internal):
            if after not in seen:
                seen.add(after)
                queue.append(after)
    return ends


def markings_of(net: PetriNet, run: tuple[str, ...]) -> list[Marking]:
    """The markings that a run passes; each of its transitions must be enabled, priorities respected."""
    passed = [net.initial]
    for name in run:
        t = net.transition_index[name]
        assert t in net.enabled(passed[-1]), f"{name} is not enabled"
        passed.append(net.fire(passed[-1], t))
    return passed


def assert_parts(net: PetriNet, first: tuple[str, ...], second: tuple[str, ...]) -> None:
    """Two runs part at two internal transitions, each of which decides the stable marking at the end."""
    one, other = markings_of(net, first), markings_of(net, second)
    assert one[-1] != other[-1]
    parted = next(i for i, (a, b) in enumerate(zip(first, second, strict=False)) if a != b)
    assert all(net.transitions[net.transition_index[run[parted]]].internal for run in (first, second))
    assert stable_ends(net, one[parted + 1]) == {one[-1]}
    assert stable_ends(net, other[parted + 1]) == {other[-1]}
