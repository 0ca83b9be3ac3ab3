"""The entry ``net.json`` of a certificate: a mission's net, with what its places and events mean."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from mcpn.certificates.certcheck import VERSION
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import Event
from mcpn.nets.petri import Arcs, PetriNet


def net_entry(mission_net: MissionNet) -> dict[str, Any]:
    """The net of a mission as the certificate holds it.

    Args:
        mission_net: The net, with what its places mean.

    Raises:
        InputError: An arc has a weight, or a place several tokens.
    """
    net, roles = mission_net.net, defaultdict[int, list[list[str]]](list)
    roles[mission_net.beginning].append(["begin", ""])
    for place, role in mission_net.roles.items():
        roles[place].append([*role])
    return {
        "format": "mcpn-certificate",
        "version": VERSION,
        "places": [
            {"name": place.name, "initial": place.initial, "roles": roles[number]}
            for number, place in enumerate(net.places)
        ],
        "transitions": [
            {
                "name": t.name,
                "event": [] if t.event is None else event_entry(t.event),
                "rank": t.rank,
                "consume": _places(net, t.consume),
                "produce": _places(net, t.produce),
                "read": _places(net, t.read),
            }
            for t in net.transitions
        ],
    }


def event_entry(event: Event) -> list[str]:
    """An event: what happens, to which element, and where a failure has one its reason."""
    return [event.what.value, event.element, *([event.reason] if event.reason else [])]


def _places(net: PetriNet, arcs: Arcs) -> list[int]:
    for place, weight in arcs:
        if weight != 1:
            name = net.places[place].name
            raise InputError.at(
                None, f"found an arc of weight {weight} at {name}, expected 1: no certificate"
            )
    return [place for place, _ in arcs]
