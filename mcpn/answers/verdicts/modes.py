"""What the robot does in a stable marking, and the functioning modes of its objectives.

Source: the paper, 4.3 (functioning modes) and 7.1 ("the stable states of the markings graph give the robot's
functioning modes throughout the mission with the resources state and the alternatives selected").
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable
from dataclasses import field
from functools import cache
from itertools import compress
from typing import TYPE_CHECKING, Any, TypeAlias

from mcpn._kernel import Zdd
from mcpn.records import record
from mcpn.spaces.projections import ImageStore

if TYPE_CHECKING:
    from mcpn.drawing.compose import MissionNet
    from mcpn.spaces.algebra import S, Space

WAITING = ("wait", "want")
"""Roles of places that say of an alternative that it waits: for answers, or for what it has asked for."""
_WAITING = dict.fromkeys(WAITING, "waiting")
_FIELDS = {
    "objective": "objectives",
    "pending": "pending",
    "done": "done",
    "active": "mode",
    "refused": "refused",
    "oos": "out_of_service",
    "fact": "facts",
} | _WAITING
Mode: TypeAlias = dict[str, str]
"""The selected alternative of each running activity, by the activity's name."""


@record(frozen=True)
class Situation:
    """A stable marking in mission words; every list is in the mission's order.

    Args:
        objectives: Objectives that run.
        pending: Objectives about to be entered, which wait until an activity is idle.
        done: Branches of parallel blocks that have ended while others run.
        mode: The functioning mode.
        waiting: Alternatives that wait for a resource, by activity: another activity has it, or its
            producer waits.
        refused: Activities that have no possible alternative.
        out_of_service: Hardware out of service.
        unnoticed: What of it the robot does not know yet.
        facts: The value of each fact; in the net of a section of those that it changes or reads.
        outcome: ``success``, ``failure``, ``abort``, or ``None`` while the mission runs; in the net of a
            section also the exit by which an event has left it.
    """

    objectives: tuple[str, ...] = ()
    pending: tuple[str, ...] = ()
    done: tuple[str, ...] = ()
    mode: Mode = field(default_factory=dict)
    waiting: Mode = field(default_factory=dict)
    refused: tuple[str, ...] = ()
    out_of_service: tuple[str, ...] = ()
    outcome: str | None = None
    facts: Mode = field(default_factory=dict)
    unnoticed: tuple[str, ...] = ()


def in_fields(said: Situation) -> dict[str, Any]:
    """A situation by the names of its fields, for tables and graphs of other libraries."""
    return {name: getattr(said, name) for name in Situation.__dataclass_fields__}


def situation(mission_net: MissionNet, marking: tuple[int, ...]) -> Situation:
    """A marking of the mission's net, given as tokens by place, in mission words."""
    return said_by(mission_net, compress(range(len(marking)), marking))


def said_by(mission_net: MissionNet, marked: Iterable[int]) -> Situation:
    """A marking in mission words, given as its marked places in ascending order."""
    said: dict[str, list[str]] = {}
    roles = mission_net.roles
    for place in marked:
        if place in roles:
            kind, name = roles[place]
            said.setdefault(_WAITING.get(kind, kind), []).append(name)
    ends = (*(kind for kind in ("success", "failure", "abort") if kind in said), *said.get("exit", ()))
    return Situation(
        objectives=tuple(said.get("objective", ())),
        pending=tuple(said.get("pending", ())),
        done=tuple(said.get("done", ())),
        mode=dict(name.split(".", 1) for name in said.get("active", ())),
        waiting=dict(name.split(".", 1) for name in said.get("waiting", ())),
        refused=tuple(said.get("refused", ())),
        out_of_service=tuple(said.get("oos", ())),
        outcome=next(iter(ends), None),
        facts=dict(name.split("=", 1) for name in said.get("fact", ())),
        unnoticed=tuple(
            name
            for name in said.get("oos", ())
            if ("known", name) in mission_net.by_role and name not in said.get("known", ())
        ),
    )


def said_as(role: str) -> str | None:
    """The field of :class:`Situation` that places of a role fill; ``None`` for the roles of outcomes."""
    return _FIELDS.get(role)


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
    usage, active = mission_net.usage, mission_net.saying("active")
    store, places_of = cache(ImageStore), defaultdict[str, list[int]](list)
    for place, name in active.items():
        places_of[name.split(".", 1)[0]].append(place)
    rank = {name: -number for number, name in enumerate(usage.suppliers_first())}
    ways = {name: [way.name for way in activity.alternatives] for name, activity in usage.activities.items()}

    @cache
    def sorted_modes(own: tuple[str, ...], places: tuple[int, ...], family: Zdd) -> list[Mode]:
        pairs = [active[place].split(".", 1) for place in places]
        modes = (dict([pairs[i] for i in sorted(row)]) for row in family)
        # The document's priorities: those of an activity before those of what serves it.
        order = [*own, *sorted(served(own).difference(own), key=rank.__getitem__)]
        ranks = [(name, {way: at for at, way in enumerate(ways[name])}, len(ways[name])) for name in order]
        return sorted(
            (mode for mode in modes if all(name in mode for name in own)),
            key=lambda mode: [at[mode[name]] if name in mode else last for name, at, last in ranks],
        )

    @cache
    def served(own: tuple[str, ...]) -> frozenset[str]:
        return frozenset[str]().union(*map(usage.closure, own))

    @cache
    def places_saying(own: tuple[str, ...]) -> tuple[int, ...]:
        return tuple(sorted(place for name in served(own) for place in places_of[name]))

    activities_of = {section.name: section.activities for section in mission_net.graph.walk()}
    modes_of, known = dict[str, list[Mode]](), dict[Hashable, list[list[Mode]]]()
    for piece in space.pieces(space.stable):
        names = tuple(activities_of) if piece.kind is None else piece.names
        if piece.kind not in known:
            known[piece.kind] = modes = []
            for name in names:
                own = activities_of[name]
                running = space.marked(mission_net.by_role["objective", name]) & piece.states
                places = places_saying(own)
                modes.append(sorted_modes(own, places, space.image(running, places, store(len(places)))))
        modes_of |= zip(names, known[piece.kind], strict=True)
    return {name: modes_of.get(name, []) for name in activities_of}
