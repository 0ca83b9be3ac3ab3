"""What a run skips that shows that a mission can succeed, and why no run does."""

from __future__ import annotations

import re

from mcpn.drawing.compose import MissionNet
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import SUCCEED
from mcpn.nets.events import What
from mcpn.spaces.run import Run

_TRY = re.compile(r"_run[0-9]+(?=[._]|$)|_try[0-9]+(?=[.]|$)")


def skipped(mission_net: MissionNet, run: Run) -> tuple[str, ...]:
    """Objectives that begin on a run and never succeed on it, in the order in which they begin.

    All tries of an objective are one, and all runs of one that recovers.
    """
    objectives, net = mission_net.saying("objective"), mission_net.net
    begun, succeeded = dict[str, None](), set[str]()
    for t in run.firings:
        transition = net.transitions[t]
        begun.update(dict.fromkeys(_untried(objectives[p]) for p, _ in transition.produce if p in objectives))
        if (event := transition.event) is not None and event.what is What.SUCCESS:
            succeeded.add(_untried(event.element))
    return tuple(name for name in begun if name not in succeeded)


def _untried(name: str) -> str:
    """The name of an objective without the numbers of its tries and runs."""
    return _TRY.sub("", name)


def no_way_to_success(graph: ObjectivesGraph) -> str:
    """Why no run succeeds, where the text alone says so."""
    if any(SUCCEED in section.routes for section in graph.sections):
        return ""
    return (
        ': no route of the mission leads to succeed; a block after which all is done says success="succeed", '
        "by default success leads to the next block"
    )
