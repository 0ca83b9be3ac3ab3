"""Slices of CPU time for several kinds of work that take turns: how long each is, and who is next.

Work is a generator: it yields where it may pause, and returns what comes of it. Who needs that at once calls
:func:`finished`; several kinds of work share the processor by :func:`in_turns`. Slices are of CPU time of
this process, so that what else the machine does changes nothing; work does not know how long they are.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Iterator
from typing import TypeAlias, TypeVar

Made = TypeVar("Made")
Told = TypeVar("Told")
Pausing: TypeAlias = Generator[None, None, Made]
"""Work that yields nothing but its pauses."""

FIRST_SLICE, SHARE = 0.2, 0.5
"""Seconds of a first slice, and the share of what work has had so far that its later slices have."""


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
    share: Callable[[Iterator[Told | None]], float] = lambda way: 1,
) -> Iterator[Told | None]:
    """What several kinds of work tell and when they pause, until all have ended.

    Whoever has had the least CPU time so far is next: each gets as much as every other, however coarse its
    pauses are. What is told ends no slice, since more may follow from it at once; a slice in which something
    was told counts less, so that who has answers has more time.

    Args:
        ways: Kinds of work, in the order of their first turns. ``None`` is a pause: something else may go on.
        over: Whether nothing is left to do.
        first: Seconds of a first slice; later ones are longer.
        share: How many times as much as others a way gets.

    >>> list(filter(None, in_turns([iter([1, None, 2, None, 3]), iter("ab")], lambda: False, first=1e9)))
    [1, 2, 3, 'a', 'b']
    """
    spent = dict.fromkeys(map(iter, ways), 0.0)
    while spent and not over():
        way = min(spent, key=spent.__getitem__)
        begun = time.process_time()
        until, answers = begun + max(first, SHARE * spent[way]), 0
        for told in way:
            answers += told is not None
            yield told
            if over() or (told is None and time.process_time() >= until):
                spent[way] += (time.process_time() - begun) / (share(way) * (1 + answers))
                break
        else:
            del spent[way]
