"""Evidence for minimal cut sets: the largest sets that are survived, each with a run that shows it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import and_
from typing import Any, NamedTuple

import numpy as np

from mcpn.certificates import evidence
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.spaces.markings.graph import Mask
from mcpn.spaces.stable.alternatives import AlternativesGraph

MOST_SURVIVED = 20_000
"""Sets that are survived up to which each gets a run."""


class Losing(NamedTuple):
    """When hardware is lost, and what it may then make impossible.

    Args:
        moments: The states in which it is lost.
        goal: The states that count as survival.
        edges: The edges that a run to the goal may take.
    """

    moments: Mask
    goal: Mask
    edges: Mask


def before_the_start(graph: AlternativesGraph, mission_net: MissionNet, ends: Sequence[str]) -> Losing:
    """Hardware that is lost before the mission starts, and some ends of it."""
    goal = evidence.marking(graph, [known[end] for end in ends if end in (known := mission_net.ends)])
    return Losing(evidence.marking(graph, [mission_net.beginning]), goal, np.ones(graph.edges, np.bool_))


def can_fail(mission_net: MissionNet) -> list[str]:
    """The hardware that may be out of service."""
    return [h.name for h in mission_net.core.hardware if ("oos", h.name) in mission_net.by_role]


def survived(
    graph: AlternativesGraph, mission_net: MissionNet, cut_sets: Iterable[Iterable[str]], losing: Losing
) -> list[dict[str, Any]]:
    """The largest sets of hardware that hold no cut set, with the runs that show that they are survived.

    Args:
        graph: The listed states.
        mission_net: The mission's net.
        cut_sets: The minimal cut sets.
        losing: Of which moment and goal.

    Raises:
        LimitError: There are too many.
    """
    hardware, runs = can_fail(mission_net), _Runs(graph, mission_net, losing)
    return [runs.surviving([hardware[i] for i in sorted(lost)]) for lost in _survived(cut_sets, hardware)]


def _survived(cuts: Iterable[Iterable[str]], hardware: Sequence[str]) -> list[frozenset[int]]:
    """The largest sets that hold no cut: what the smallest sets that meet every cut leave (Berge)."""
    number = {name: i for i, name in enumerate(hardware)}
    meeting = {frozenset[int]()}
    for cut in cuts:
        members = [number[name] for name in cut]
        meets = {each for each in meeting if not each.isdisjoint(members)}
        longer = {each | {i} for each in meeting - meets for i in members}
        meeting = meets | {each for each in longer if not any(other <= each for other in meets)}
        if len(meeting) > MOST_SURVIVED:
            raise LimitError(f"no certificate: more than {MOST_SURVIVED} sets of hardware are survived")
    every = frozenset(range(len(hardware)))
    return sorted((every - each for each in meeting), key=sorted)


class _Runs:
    """Runs on which what is lost stays lost."""

    def __init__(self, graph: AlternativesGraph, mission_net: MissionNet, losing: Losing) -> None:
        self.graph, self.net, self.losing = graph, mission_net, losing
        events = mission_net.net.events
        self.repairs = {t: e.element for t, e in events.pairs if e.what is What.REPAIRED}
        # One search without any repair shows most sets; the others get one of their own.
        self.unrepaired = losing.edges & ~evidence.carrying(graph, list(self.repairs))
        self.far = evidence.distances(graph, losing.goal, self.unrepaired)

    def surviving(self, lost: list[str]) -> dict[str, Any]:
        """A set of hardware with a run to the goal, and after how many events all of it is lost."""
        graph = self.graph
        out = [evidence.marking(graph, self.net.by_role["oos", name]) for name in lost]
        starts: Mask = reduce(and_, out, self.losing.moments)
        edges, far = self.unrepaired, self.far
        if not (starts & (far >= 0)).any():
            repaired = evidence.carrying(graph, [t for t, name in self.repairs.items() if name in lost])
            edges = self.losing.edges & ~repaired
            far = evidence.distances(graph, self.losing.goal, edges)
        start = int(np.flatnonzero(starts & (far >= 0))[0])
        there = np.zeros(graph.states, np.bool_)
        there[start] = True
        first = evidence.run(graph, there)
        assert first is not None, "all states are reached"
        return {"lost": lost, "by": len(first), "run": first + evidence.nearer(graph, far, start, edges)}
