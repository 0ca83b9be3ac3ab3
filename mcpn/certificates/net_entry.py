"""The entry ``net.json`` of a certificate: a mission's net, with what its places and events mean."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from mcpn.certificates.certcheck import VERSION
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import Event
from mcpn.nets.petri import Arcs

ALWAYS, NEVER = "always marked", "never marked"
"""Places that stand for weights of arcs; names of a mission's net have no spaces."""


def net_entry(mission_net: MissionNet, *, diagrams: bool = False) -> dict[str, Any]:
    """The net of a mission as the certificate holds it.

    Its arcs have no weights. In a net with one token in a place, at most, a transition that puts several into
    one does as one that puts one where one is always; one that needs several never fires.

    Args:
        mission_net: The net, with what its places mean.
        diagrams: Whether diagrams say which of its places are marked, and so of no others.

    Raises:
        LimitError: An arc has a weight, and diagrams are asked for.
    """
    net, roles = mission_net.net, defaultdict[int, list[list[str]]](list)
    weighted = [t.name for t in net.transitions if _several(t.consume, t.read, t.produce)]
    if diagrams and weighted:
        raise LimitError(f"no certificate by diagrams: {weighted[0]} has an arc with a weight")
    beyond = [{"name": ALWAYS, "initial": 1, "roles": []}, {"name": NEVER, "initial": 0, "roles": []}]
    always = len(net.places)
    roles[mission_net.beginning].append(["begin", ""])
    for place, role in mission_net.roles.items():
        roles[place].append([*role])
    return {
        "format": "mcpn-certificate",
        "version": VERSION,
        "places": [
            {"name": place.name, "initial": place.initial, "roles": roles[number]}
            for number, place in enumerate(net.places)
        ]
        + (beyond if weighted else []),
        "transitions": [
            {
                "name": t.name,
                "event": [] if t.event is None else event_entry(t.event),
                "rank": t.rank,
                "consume": _places(t.consume),
                "produce": _places(t.produce) + [always] * _several(t.produce),
                "read": _places(t.read) + [always + 1] * _several(t.consume, t.read),
            }
            for t in net.transitions
        ],
    }


def event_entry(event: Event) -> list[str]:
    """An event: what happens, to which element, and where a failure has one its reason."""
    return [event.what.value, event.element, *([event.reason] if event.reason else [])]


def _places(arcs: Arcs) -> list[int]:
    return [place for place, _ in arcs]


def _several(*sides: Arcs) -> bool:
    """Whether some arc carries several tokens."""
    return any(weight > 1 for arcs in sides for _, weight in arcs)
