"""What the robot does in a stable marking: objectives, functioning mode, hardware out of service.

Source: the paper, 4.3 (functioning modes) and 7.1 ("the stable states of the markings graph give the robot's
functioning modes throughout the mission with the resources state and the alternatives selected").
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from mcpn._kernel import Zdd
from mcpn.mission.flatten import ElementarySection
from mcpn.net.compose import MissionNet
from mcpn.space.encoding import Encoding
from mcpn.space.graph import Mask, StateGraph

Mode: TypeAlias = dict[str, str]
"""The selected alternative of each running activity, by the activity's name."""


@dataclass(frozen=True)
class Situation:
    """A stable marking in mission words; every list is in the mission's order.

    Args:
        objectives: Objectives that run.
        pending: Objectives about to be entered, which wait until an activity is idle.
        done: Branches of parallel blocks that have ended while others run.
        mode: The functioning mode.
        waiting: Selected alternatives that wait for a resource, by activity.
        refused: Activities that have no possible alternative.
        out_of_service: Hardware out of service.
        outcome: ``success``, ``failure``, or ``None`` while the mission runs.
    """

    objectives: tuple[str, ...] = ()
    pending: tuple[str, ...] = ()
    done: tuple[str, ...] = ()
    mode: Mode = field(default_factory=dict)
    waiting: Mode = field(default_factory=dict)
    refused: tuple[str, ...] = ()
    out_of_service: tuple[str, ...] = ()
    outcome: str | None = None


def situation(mission_net: MissionNet, marking: tuple[int, ...]) -> Situation:
    """A marking in mission words.

    Args:
        mission_net: The mission's net.
        marking: Tokens by place.

    Returns:
        What it says.
    """
    said: dict[str, list[str]] = {}
    for place, (kind, name) in mission_net.roles.items():
        if marking[place]:
            said.setdefault(kind, []).append(name)
    outcome = next((kind for kind in ("success", "failure") if kind in said), None)
    return Situation(
        objectives=tuple(said.get("objective", ())),
        pending=tuple(said.get("pending", ())),
        done=tuple(said.get("done", ())),
        mode=dict(name.split(".", 1) for name in said.get("active", ())),
        waiting=dict(name.split(".", 1) for name in said.get("wait", ())),
        refused=tuple(said.get("refused", ())),
        out_of_service=tuple(said.get("oos", ())),
        outcome=outcome,
    )


def functioning_modes(
    mission_net: MissionNet, graph: StateGraph, among: Mask | None = None
) -> Mapping[str, list[Mode]]:
    """The functioning modes of each objective: the combinations of alternatives in which it can succeed.

    Args:
        mission_net: The mission's net.
        graph: Its alternatives graph (or its markings graph).
        among: The states to look at, shape (states,); all by default.

    Returns:
        By objective, in the mission's order, its modes; a mode names the alternatives of the objective's own
        activities and of those that serve them, and is there if all of the objective's activities run.
    """
    found: dict[str, list[Mode]] = {}
    for section in mission_net.graph.walk():
        places = places_of_modes(mission_net, section)
        (objective,) = mission_net.by_role["objective", section.name]
        running = graph.marked(objective) if among is None else graph.marked(objective) & among
        columns = np.stack([graph.marked(p) for p in places], axis=1)[running]
        found[section.name] = modes_of(section, places, np.unique(columns, axis=0).tolist())
    return found


def diagram_modes(mission_net: MissionNet, encoding: Encoding, states: Zdd) -> dict[str, list[Mode]]:
    """The functioning modes of each objective, from a diagram of states.

    Args:
        mission_net: The mission's net.
        encoding: The net on the levels of the diagram's store.
        states: The states to look at.

    Returns:
        As :func:`functioning_modes`.
    """
    found: dict[str, list[Mode]] = {}
    for section in mission_net.graph.walk():
        places = places_of_modes(mission_net, section)
        (objective,) = mission_net.by_role["objective", section.name]
        running = encoding.marking_all([objective], states)
        rows = [encoding.marking(levels) for levels in running.onto(encoding.telling(places))]
        found[section.name] = modes_of(section, places, [[bool(row[p]) for p in places] for row in rows])
    return found


def places_of_modes(mission_net: MissionNet, section: ElementarySection) -> dict[int, str]:
    """The places that tell an objective's mode: alternatives of its activities and of their suppliers."""
    closure = frozenset[str]().union(*(mission_net.usage.closure(a) for a in section.activities))
    active = mission_net.saying("active").items()
    return {place: name for place, name in active if name.split(".", 1)[0] in closure}


def modes_of(
    section: ElementarySection, places: dict[int, str], rows: Iterable[Sequence[bool]]
) -> list[Mode]:
    """Functioning modes from which of their places are marked, first alternatives first.

    Args:
        section: The objective.
        places: As :func:`places_of_modes` gives them.
        rows: For each combination that occurs, which of the places are marked.
    """
    names = places.values()
    modes = [
        dict(n.split(".", 1) for n, on in zip(names, row, strict=True) if on)
        for row in sorted(map(tuple, rows), reverse=True)
    ]
    return [mode for mode in modes if all(a in mode for a in section.activities)]
