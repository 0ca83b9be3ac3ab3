"""The run that shows that a mission can succeed, and what it skips on the way."""

from __future__ import annotations

import re

from mcpn.drawing.compose import MissionNet
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import SUCCEED
from mcpn.nets.events import What
from mcpn.spaces.algebra import Edge, S, Space
from mcpn.spaces.run import Run

MOST_READ = 200
"""Most objectives of a mission whose success is shown by a nominal run, where one succeeds."""

_TRY = re.compile(r"_run[0-9]+(?=[._]|$)|_try[0-9]+(?=[.]|$)")


def without_skipping(mission_net: MissionNet, space: Space[S], goal: S) -> list[Edge] | None:
    """A shortest run to success on which nothing fails or interrupts, where the mission is not long.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph.
        goal: The states in which it has succeeded.
    """
    if sum(1 for _ in mission_net.graph.walk()) > MOST_READ:
        return None
    return space.run(space.initial.pick(), goal, transitions=_nominal(mission_net))


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


def _nominal(mission_net: MissionNet) -> list[int]:
    """The transitions of nominal runs: internal ones, the start, and successes."""
    good = (None, What.START, What.SUCCESS)
    events = ((t, transition.event) for t, transition in enumerate(mission_net.net.transitions))
    return [t for t, event in events if (event.what if event else None) in good]


def no_way_to_success(graph: ObjectivesGraph) -> str:
    """Why no run succeeds, where the text alone says so."""
    if any(SUCCEED in section.routes for section in graph.sections):
        return ""
    return (
        ': no route of the mission leads to succeed; a block after which all is done says success="succeed", '
        "by default success leads to the next block"
    )
