"""Slices of CPU time for several kinds of work that take turns: how long each is, and who is next.

Work is a generator: it yields where it may pause, and returns what comes of it. Who needs that at once calls
:func:`finished`; several kinds of work share the processor by :func:`in_turns`. Slices are of CPU time of
this process, so that what else the machine does changes nothing; work does not know how long they are.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from math import inf
from types import MappingProxyType
from typing import TypeAlias, TypeVar

Made = TypeVar("Made")
Told = TypeVar("Told")
Pausing: TypeAlias = Generator[None, None, Made]
"""Work that yields nothing but its pauses."""

FIRST_SLICE, PATIENCE = 0.1, 2
"""Seconds of a first slice, and how many times as long as who is next in turn work may stay silent."""
NEAR = 3
"""How many times as long whatever has all that it needs may stay silent."""
FORGIVEN = 0.5
"""The share of its silence that work keeps when it has told something, but for that of earlier slices."""


def finished(work: Generator[object, None, Made]) -> Made:
    """What comes of work that does not rest."""
    while True:
        try:
            next(work)
        except StopIteration as end:
            made: Made = end.value
            return made


def in_turns(
    ways: Iterable[Iterator[Told | None]],
    over: Callable[[], bool],
    *,
    first: float = FIRST_SLICE,
    whole: Iterator[Told | None] | None = None,
    near: Callable[[], bool] = lambda: False,
    late: Mapping[Iterator[Told | None], float] = MappingProxyType({}),
) -> Iterator[Told | None]:
    """What several kinds of work tell and when they pause, until all have ended.

    Whoever has been silent for the least CPU time is next, and goes on until it has been silent for twice as
    long as any other: who has found nothing for a second seldom finds something in the next tenth. What is
    told makes the silence of a slice half as long, so that who has answers goes on, and others wait.

    Args:
        ways: Kinds of work, in the order of their first turns. ``None`` is a pause: something else may go on.
        over: Whether nothing is left to do.
        first: Seconds of a first slice.
        whole: One of them that tells nothing for long, and then all: it may be silent for as long as all the
            others together, and for twice a first slice at first.
        near: Whether that one has all that it needs to tell: it may then be silent for three times as long.
        late: Seconds that some take to begin with, as to load a library: so long the others go first.

    >>> list(filter(None, in_turns([iter([1, None, 2, None, 3]), iter("ab")], lambda: False, first=1e9)))
    [1, 2, 3, 'a', 'b']
    """
    silent = {way: late.get(way, 0.0) for way in map(iter, ways)}
    others = max(len(silent) - 1, 1)

    def together() -> int:
        return others * (NEAR if near() else 1)

    def counted(way: Iterator[Told | None]) -> float:
        return silent[way] / (together() if way is whole else 1)

    while silent and not over():
        way = min(silent, key=counted)
        least = min((counted(other) for other in silent if other is not way), default=inf)
        until = max(2 * first, together() * least) if way is whole else max(first, PATIENCE * least)
        before = silent[way]
        while not over():
            begun = time.process_time()
            try:
                told = next(way)
            except StopIteration:
                del silent[way]
                break
            silent[way] += time.process_time() - begun
            if told is not None:
                silent[way] = max(before, FORGIVEN * silent[way])
            yield told
            if told is None and silent[way] >= until:
                break
