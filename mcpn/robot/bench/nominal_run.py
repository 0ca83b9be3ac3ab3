"""The run on which nothing fails, played: of several objectives that run, the first succeeds first.

All such runs are decided by :mod:`mcpn.answers.verdicts.nominal`; here one of them is played, of a mission of
any size, in its controller or in its net.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Sequence

from mcpn.events import START, Event, What

MOST_EVENTS = 100_000
"""Most events of one run."""


def nominal_event(possible: Sequence[Event], back: Collection[str]) -> Event | None:
    """What happens next while nothing fails; ``None`` where nothing can succeed.

    Args:
        possible: What may happen.
        back: Hardware that comes back before the start.
    """
    succeeding = None
    for event in possible:
        if event == START:
            repairs = (e for e in possible if e.what is What.REPAIRED and e.element in back)
            return next(repairs, START)
        if event.what is What.SUCCESS and succeeding is None:
            succeeding = event
    return succeeding


def nominal_run(
    possible: Callable[[], Sequence[Event]], take: Callable[[Event], Hashable], back: Collection[str]
) -> list[Event]:
    """Takes the run on which nothing fails, from before the start on.

    Args:
        possible: What may happen now, successes in the order of the document.
        take: Takes an event, and says where it has led: equal only where the same may follow.
        back: Hardware that comes back before the start.

    Returns:
        The events, up to where the mission has ended, nothing can succeed, or the run is where it was before.
    """
    run, seen = list[Event](), set[Hashable]()
    while len(run) < MOST_EVENTS and (event := nominal_event(possible(), back)) is not None:
        run.append(event)
        here = take(event)
        if here in seen:
            break
        seen.add(here)
    return run
