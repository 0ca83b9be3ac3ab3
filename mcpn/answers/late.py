"""Losses that nobody notices: what goes on and can only fail, and what succeeds only if they are found.

Hardware that is detected late fails unseen. With just this lost, and not known to be lost, an objective that
uses it can no more succeed in its present run, or it can because some activity may still find the loss out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from mcpn.answers.causes.prospects import Prospects
from mcpn.drawing.compose import MissionNet
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.nets.events import What
from mcpn.sentences import shortened
from mcpn.spaces.algebra import S, Space, Without


@dataclass(frozen=True)
class LateLoss:
    """Hardware whose loss is noticed late, and what that costs.

    Args:
        hardware: Its name.
        unnoticed: Objectives that go on after its loss, and can only fail, while nothing that runs can tell,
            in document order.
        in_time: Those that can succeed after its loss only if it is found out while they run, likewise.
        sentences: The same for a reader: copies of one objective are said together.
    """

    hardware: str
    unnoticed: tuple[str, ...]
    in_time: tuple[str, ...]
    sentences: tuple[str, ...]


def late_losses(mission_net: MissionNet, space: Space[S]) -> Iterator[LateLoss]:
    """The hardware whose unnoticed loss some objective does not survive, or only if it is found in time.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph.
    """
    late = [h.name for h in mission_net.mission.late if ("known", h.name) in mission_net.by_role]
    if not late:
        return
    prospects = Prospects(mission_net, space)
    goals, copies = prospects.objectives, mission_net.graph.copies
    every = names_of_objectives(mission_net.graph)
    for name in late:
        oos, known = (list(mission_net.by_role[role, name]) for role in ("oos", "known"))
        others = [place for place in prospects.places("oos", prospects.hardware) if place not in oos]
        # Nothing else has failed on the way either: what a loss has done may outlast it.
        beside = prospects.failing - prospects.carrying(What.OUT_OF_SERVICE, name)
        alone = space.reached(space.initial, None, Without(prospects.everything, beside))
        lost = space.restricted(alone, oos, [*others, *known])
        finding = prospects.carrying(What.DETECTED, name)
        unseen = lost - space.enabling(finding) if finding else lost
        unnoticed, in_time = list[str](), list[str]()
        for objective, goal in goals.items():
            if not goal.won or not (lost & goal.running):
                continue
            hopeful = prospects.hopeful(goal, repairs=False)
            if (unseen & goal.running) - hopeful:
                unnoticed.append(objective)
            if finding:
                blind = replace(goal, ends=goal.ends | finding)
                if (lost & hopeful & goal.running) - prospects.hopeful(blind, repairs=False):
                    in_time.append(objective)
        said = list[str]()
        if unnoticed:
            told = copies.told(unnoticed, every)
            runs = "runs and" if len(told) == 1 else "run and"
            said.append(f"nobody notices the loss of {name} while {shortened(told)} {runs} can only fail")
        if in_time:
            objectives = shortened(copies.told(in_time, every))
            said.append(f"{objectives} can succeed after the loss of {name} only if it is found in time")
        if said:
            yield LateLoss(name, tuple(unnoticed), tuple(in_time), tuple(said))
