"""What the robot does in a stable marking: objectives, functioning mode, hardware out of service.

Source: the paper, 4.3 (functioning modes) and 7.1 ("the stable states of the markings graph give the robot's
functioning modes throughout the mission with the resources state and the alternatives selected").
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import compress
from typing import TypeAlias

from mcpn.net.compose import MissionNet

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
        outcome: ``success``, ``failure``, or ``None`` while the mission runs; in the net of a section also
            the exit by which an event has left it.
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
    return said_by(mission_net, compress(range(len(marking)), marking))


def said_by(mission_net: MissionNet, marked: Iterable[int]) -> Situation:
    """The same of a marking given as its marked places, in ascending order."""
    said: dict[str, list[str]] = {}
    roles = mission_net.roles
    for place in marked:
        if place in roles:
            kind, name = roles[place]
            said.setdefault(kind, []).append(name)
    ends = (*(kind for kind in ("success", "failure") if kind in said), *said.get("exit", ()))
    return Situation(
        objectives=tuple(said.get("objective", ())),
        pending=tuple(said.get("pending", ())),
        done=tuple(said.get("done", ())),
        mode=dict(name.split(".", 1) for name in said.get("active", ())),
        waiting=dict(name.split(".", 1) for name in said.get("wait", ())),
        refused=tuple(said.get("refused", ())),
        out_of_service=tuple(said.get("oos", ())),
        outcome=next(iter(ends), None),
    )
