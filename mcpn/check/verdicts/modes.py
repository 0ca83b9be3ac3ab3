"""Functioning modes: the combinations of alternatives in which an objective can succeed (the paper, 4.3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mcpn._kernel import Zdd
from mcpn.check.modes import Mode
from mcpn.mission.facts.usage import Usage
from mcpn.net.compose import MissionNet
from mcpn.space.algebra import S, Space
from mcpn.space.images import ImageStore


def functioning_modes(mission_net: MissionNet, space: Space[S]) -> dict[str, list[Mode]]:
    """The functioning modes of each objective, in its stable states.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph or its markings graph.

    Returns:
        By objective, in the mission's order, its modes, the preferred ones first; a mode names the
        alternatives of the objective's own activities and of those that serve them, and is there if all of
        the objective's activities run.
    """
    found: dict[str, list[Mode]] = {}
    preference = _Preference(mission_net.usage)
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
            modes = [dict(active[places[i]].split(".", 1) for i in sorted(row)) for row in map(set, family)]
            modes.sort(key=preference(activities))
            listed[key] = [mode for mode in modes if all(a in mode for a in activities)]
        found[section.name] = [*listed[key]]
    return found


class _Preference:
    """Orders modes by the document's priorities: those of an activity before those of what serves it."""

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self.place = {name: -i for i, name in enumerate(usage.suppliers_first())}
        self.rank = {
            name: {alternative.name: i for i, alternative in enumerate(activity.alternatives)}
            for name, activity in usage.activities.items()
        }

    def __call__(self, activities: Sequence[str]) -> Callable[[Mode], list[int]]:
        """The key by which modes of an objective that runs some activities are sorted."""
        below = frozenset[str]().union(*(self.usage.closure(a) for a in activities)) - {*activities}
        order = [*activities, *sorted(below, key=self.place.__getitem__)]

        def key(mode: Mode) -> list[int]:
            ranks = ((self.rank[name], mode.get(name)) for name in order)
            return [len(rank) if way is None else rank[way] for rank, way in ranks]

        return key
