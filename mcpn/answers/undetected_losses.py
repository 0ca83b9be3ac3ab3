"""Losses that nobody notices: what goes on and can only fail, and what succeeds only if they are found.

Hardware that is detected late fails unseen. With this lost, and not known to be lost, an objective that uses
it can no longer succeed in its present run, or it can because some activity may still find the loss out. An
objective that could not succeed without the loss either is not reported.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from mcpn.answers.causes.prospects import Prospects
from mcpn.drawing.compose import MissionNet
from mcpn.events import What
from mcpn.spaces.algebra import S, Space, Without


@dataclass(frozen=True)
class LateLoss:
    """Hardware whose loss is noticed late, and the consequences.

    Args:
        hardware: Its name.
        unnoticed: Objectives that go on after its loss, and can only fail, while nothing that runs can tell,
            in document order. No other hardware has failed.
        unnoticed_later: Other objectives of which the same is so once other hardware has failed too.
        in_time: Those that can succeed after its loss alone only if it is found out while they run.
    """

    hardware: str
    unnoticed: tuple[str, ...]
    unnoticed_later: tuple[str, ...]
    in_time: tuple[str, ...]


def late_losses(mission_net: MissionNet, space: Space[S]) -> Iterator[LateLoss]:
    """The hardware whose unnoticed loss some objective does not survive, or only if it is found in time.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph.
    """
    late = [h.name for h in mission_net.core.late if ("known", h.name) in mission_net.by_role]
    if not late:
        return
    prospects = Prospects(mission_net, space)
    goals = prospects.objectives
    for name in late:
        oos, known = (list(mission_net.by_role[role, name]) for role in ("oos", "known"))
        others = [place for place in prospects.places("oos", prospects.hardware) if place not in oos]
        losing = prospects.carrying(What.OUT_OF_SERVICE, name)
        finding = prospects.carrying(What.DETECTED, name)
        # Nothing else has failed on the way either: what a loss has done may outlast it.
        beside = prospects.failing - losing
        alone = space.reached(space.initial, None, Without(prospects.everything, beside))
        sound = space.restricted(alone, [], [*others, *oos])
        lost = space.restricted(alone, oos, [*others, *known])
        unnoticed, later, in_time = list[str](), list[str](), list[str]()
        for objective, goal in goals.items():
            if not goal.won or not space.restricted(goal.running, oos, known):
                continue
            hopeful = prospects.hopeful(goal, repairs=False)
            running = goal.running & hopeful
            # Where the loss has just ruled out its success, and nobody can know.
            for among, told in ((sound, unnoticed), (space.everything, later)):
                after = space.restricted(space.after(running & among, losing), oos, known)
                in_vain = (after & goal.running) - hopeful
                if in_vain - space.enabling(finding) if finding else in_vain:
                    told.append(objective)
                    break
            if finding:
                blind = replace(goal, ends=goal.ends | finding)
                if (lost & hopeful & goal.running) - prospects.hopeful(blind, repairs=False):
                    in_time.append(objective)
        if unnoticed or later or in_time:
            yield LateLoss(name, tuple(unnoticed), tuple(later), tuple(in_time))
