"""Runs in mission words, event by event: made when a person reads them, not when a run is found."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mcpn.check.modes import Mode, Situation, said_by
from mcpn.check.runs import changes, what_happens
from mcpn.net.compose import MissionNet
from mcpn.net.events import Event
from mcpn.space.run import Run


def in_words(mission_net: MissionNet, run: Run) -> Iterator[tuple[Event | str, str]]:
    """Each event of a run with what happens and what changes, up to the next event, for a reader.

    Where a run shows the internal firings after its last event, these follow by the names of the transitions.

    Args:
        mission_net: The mission's net.
        run: A run of this net.
    """
    net, roles = mission_net.net, mission_net.roles
    marked = {place for place in roles if net.initial[place]}
    begun: tuple[Event, Situation] | None = None
    shown = run.tail
    events = run.transitions[: len(run.transitions) - len(shown)]
    for t, marking in Run(net, events, settles=not run.detailed).steps():
        transition = net.transitions[t]
        if transition.event is not None:
            settled = said_by(mission_net, sorted(marked))
            if begun is not None:
                yield begun[0], _words(mission_net, *begun, settled)
            begun = transition.event, settled
        for place, _ in (*transition.consume, *transition.produce):
            if place in roles:
                (marked.add if marking[place] else marked.discard)(place)
    if begun is not None:
        last = begun[1] if run.detailed else said_by(mission_net, sorted(marked))
        yield begun[0], _words(mission_net, *begun, last)
    yield from ((name, f"internal: {name}") for name in shown)


def _words(mission_net: MissionNet, event: Event, before: Situation, after: Situation) -> str:
    happens, changed = what_happens(event, mission_net.mission.name), changes(before, after)
    return f"{happens}: {', '.join(changed)}" if changed else happens


def modes_in_words(modes: Iterable[Mode]) -> tuple[str, ...]:
    """Functioning modes as a person tells them apart, in their order.

    Alternatives named like their activity go unsaid; what then reads the same is said once.
    """
    said = (", ".join(f"{a}: {way}" for a, way in mode.items() if a != way) for mode in modes)
    return tuple(dict.fromkeys(said))
