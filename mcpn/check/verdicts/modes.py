"""Functioning modes: the combinations of alternatives in which an objective can succeed (the paper, 4.3)."""

from __future__ import annotations

from mcpn._kernel import Zdd
from mcpn.check.modes import Mode
from mcpn.net.compose import MissionNet
from mcpn.space.algebra import S, Space
from mcpn.space.images import ImageStore


def functioning_modes(mission_net: MissionNet, space: Space[S]) -> dict[str, list[Mode]]:
    """The functioning modes of each objective, in its stable states.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph or its markings graph.

    Returns:
        By objective, in the mission's order, its modes, first alternatives first; a mode names the
        alternatives of the objective's own activities and of those that serve them, and is there if all of
        the objective's activities run.
    """
    found: dict[str, list[Mode]] = {}
    by_activity: dict[str, list[int]] = {}
    active = mission_net.saying("active")
    for place, name in active.items():
        by_activity.setdefault(name.split(".", 1)[0], []).append(place)
    places_of: dict[tuple[str, ...], tuple[int, ...]] = {}
    images: dict[int, ImageStore] = {}
    listed: dict[tuple[tuple[str, ...], Zdd], list[Mode]] = {}
    for section in mission_net.graph.walk():
        activities = section.activities
        if activities not in places_of:  # many objectives may run the same
            closure = frozenset[str]().union(*(mission_net.usage.closure(a) for a in activities))
            ours = sorted(place for activity in closure for place in by_activity.get(activity, ()))
            places_of[activities] = tuple(ours)
            if len(ours) not in images:
                images[len(ours)] = ImageStore(len(ours))
        places = places_of[activities]
        running = space.marked(mission_net.by_role["objective", section.name]) & space.stable
        family = space.image(running, places, images[len(places)])
        key = activities, family
        if key not in listed:
            rows = sorted(([i in row for i in range(len(places))] for row in map(set, family)), reverse=True)
            modes = [
                dict(active[p].split(".", 1) for p, on in zip(places, row, strict=True) if on) for row in rows
            ]
            listed[key] = [mode for mode in modes if all(a in mode for a in activities)]
        found[section.name] = [*listed[key]]
    return found
