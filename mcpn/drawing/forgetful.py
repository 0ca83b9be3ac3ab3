"""Nets without the places of handlers that happen once: who explores them keeps that status beside.

Whether a handler has happened changes by declared events alone, and decides only which handler such an
event triggers. So this status need not multiply the states that are listed: a net without it has the
transitions of an event side by side, each with its *guard*.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import NamedTuple

from mcpn.drawing.compose import MissionNet
from mcpn.errors import SemanticsError
from mcpn.events import What
from mcpn.nets.petri import PetriNet, Transition


class Guard(NamedTuple):
    """The condition of a transition on handlers that happen once, each named by where it is written.

    Args:
        open: Those that must not have happened yet, and happen with it.
        happened: Those that must have happened before.
    """

    open: tuple[str, ...] = ()
    happened: tuple[str, ...] = ()


ALWAYS = Guard()
"""The guard of a transition without such a condition."""


def forgetful(
    mission_net: MissionNet, handlers: Collection[str] | None = None
) -> tuple[MissionNet, Mapping[int, Guard]]:
    """The net without the places *open* and *happened* of some handlers.

    Args:
        mission_net: The net of a mission, or of a part of it.
        handlers: Which to forget; all by default.

    Returns:
        The net, and the guards of those of its transitions that have one. Its reachable markings are
        those of the given net, projected to the other places, and those that are reached where a handler
        happens several times. Transitions of one event that a marking enables together have guards that
        exclude each other.

    Raises:
        SemanticsError: A transition takes back that a handler has happened; no template of mcpn draws one.
    """
    forgotten = {
        place: name
        for role in ("open", "happened")
        for place, name in mission_net.saying(role).items()
        if handlers is None or name in handlers
    }
    if not forgotten:
        return mission_net, {}
    net, open_places = mission_net.net, mission_net.saying("open")
    kept = [place for place in range(len(net.places)) if place not in forgotten]
    number = {place: new for new, place in enumerate(kept)}

    def projected(arcs: tuple[tuple[int, int], ...]) -> tuple[tuple[int, int], ...]:
        return tuple((number[place], weight) for place, weight in arcs if place in number)

    transitions, guards = list[Transition](), dict[int, Guard]()
    for t in net.transitions:
        if kept_up := [p for p, _ in t.consume if p in forgotten and p not in open_places]:
            message = f"{t.name} takes the token of {net.places[kept_up[0]].name}, which says for ever that a"
            raise SemanticsError(f"{message} handler has happened: that cannot be kept beside the net")
        taken, read = ([forgotten[p] for p, _ in arcs if p in forgotten] for arcs in (t.consume, t.read))
        if taken and t.event is not None and t.event.what is What.EARLIER:
            continue
        if taken or read:
            guards[len(transitions)] = Guard(tuple(taken), tuple(read))
        consume, produce, reads = projected(t.consume), projected(t.produce), projected(t.read)
        transitions.append(replace(t, consume=consume, produce=produce, read=reads))
    units = (tuple(number[p] for p in unit if p in number) for unit in net.units)
    places = tuple(net.places[place] for place in kept)
    without = PetriNet(
        net.name, places, tuple(transitions), net.priorities, tuple(unit for unit in units if unit)
    )
    roles = {number[place]: role for place, role in mission_net.roles.items() if place in number}
    return replace(mission_net, net=without, roles=roles), guards
