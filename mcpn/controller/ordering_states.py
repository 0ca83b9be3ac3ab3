"""In which states an event orders each action: what :class:`Ordering` says of one state, of all at once.

The order of actions does not depend on the state within one section. So each action that an event may order
has its place in one list, and the states in which it is ordered.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mcpn._kernel import Zdd
from mcpn.controller.machine import Ordering, PlannedAction
from mcpn.controller.reaction import EventReaction
from mcpn.drawing.compose import MissionNet


def conditions(
    net: MissionNet, ordering: Ordering, reaction: EventReaction
) -> list[tuple[PlannedAction, Zdd]] | None:
    """The actions that an event may order, in order, each with the states in which it does.

    Args:
        net: The net of a section.
        ordering: The order of its actions.
        reaction: The event.

    Returns:
        ``None`` where it depends on more than the reaction knows.
    """
    order = ordering.order
    if order is None or not {*order} >= reaction.remembering.active.keys():
        return None
    timers = _timers(net, ordering, reaction)
    if timers is None:
        return None
    disarmed, armed = timers
    found = [*disarmed, *_of_activities(net, ordering, reaction, order), *armed]
    return [(action, states) for action, states in found if states]


def _of_activities(
    net: MissionNet, ordering: Ordering, reaction: EventReaction, order: Sequence[str]
) -> Iterator[tuple[PlannedAction, Zdd]]:
    active = reaction.remembering.active
    order = [a for a in order if a in active]
    was = {a: {w: reaction.before(p) for w, p in active[a].items()} for a in order}
    now = {a: {w: reaction.after(p) for w, p in active[a].items()} for a in order}
    ran = {a: reaction.union(was[a].values()) for a in order}
    runs = {a: reaction.union(now[a].values()) for a in order}
    changed = {
        a: {w: (was[a][w] - now[a][w]) | reaction.left(p) for w, p in active[a].items()} for a in order
    }
    stopped = {a: (ran[a] - runs[a]) | reaction.idled(a) for a in order}
    for a in order:
        yield PlannedAction("stop", a), stopped[a]
    released = dict[str, Zdd]()
    for a in order:
        by_resource = dict[str, list[Zdd]]()
        for w, states in changed[a].items():
            for k in ordering.hardware[a, w]:
                by_resource.setdefault(k, []).append(states)
        for k in ordering.as_declared(by_resource):
            sets = by_resource[k]
            before = released.get(k, reaction.nothing)
            here = reaction.union(sets) - before
            released[k] = before | here
            yield PlannedAction("release", hardware=k), here
    started = {a: (runs[a] - ran[a]) | (runs[a] & stopped[a]) for a in order}
    objectives = [(name, place) for place, name in sorted(net.saying("objective").items())][::-1]
    for a in order[::-1]:
        begun = started[a] | (runs[a] & reaction.union(changed[a].values()))
        for name, states in _named(a, begun, objectives, ordering, reaction):
            for w, here in now[a].items():
                yield PlannedAction("select", a, w, objective=name), states & here
    for a in order[::-1]:
        for name, states in _named(a, started[a], objectives, ordering, reaction):
            yield PlannedAction("start", a, objective=name), states


def _named(
    activity: str,
    states: Zdd,
    objectives: Sequence[tuple[str, int]],
    ordering: Ordering,
    reaction: EventReaction,
) -> Iterator[tuple[str | None, Zdd]]:
    """The states by the objective that names an activity afterwards: the last one that runs."""
    for name, place in objectives:
        if activity in ordering.named[name] and (here := states & reaction.after(place)):
            yield name, here
            states -= here
    yield None, states


def _timers(
    net: MissionNet, ordering: Ordering, reaction: EventReaction
) -> tuple[list[tuple[PlannedAction, Zdd]], list[tuple[PlannedAction, Zdd]]] | None:
    """Where timers are disarmed and armed; ``None`` where one firing may leave an objective and enter it."""
    timed = reaction.remembering.timed
    again = {p for t in net.net.transitions for p, _ in t.consume if p in {p for p, _ in t.produce}}
    if any(not again.isdisjoint(places) for places in timed.values()):
        return None
    running = {name: [place] for place, name in sorted(net.saying("objective").items())}
    here = running.copy()
    for place, name in net.saying("pending").items():
        here[name] = [*here.get(name, ()), place]
    places = {name: running[name] for name in running if name in ordering.timed}
    for block, held in ordering.held.items():
        places[block] = [p for name in here if name in held for p in here[name]]
    disarmed, armed = [], []
    for name, those in places.items():
        was = reaction.union(map(reaction.before, those))
        now = reaction.union(map(reaction.after, those))
        if not was and not now:
            continue
        said = timed.get(name, [])
        if len(said) != 1 or was - reaction.before(said[0]):
            return None
        ended = reaction.left(said[0])
        disarmed.append((PlannedAction("disarm", objective=name), was & ended))
        armed.append((PlannedAction("arm", objective=name), now & ((reaction.states - was) | ended)))
    return disarmed, armed
