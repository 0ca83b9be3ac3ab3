"""Evidence for minimal cut sets: the largest sets that are survived, each with a run that shows it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from operator import and_
from typing import Any

import numpy as np

from mcpn.certificates import evidence
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.spaces.markings.graph import Mask
from mcpn.spaces.stable.alternatives import AlternativesGraph

MOST_SURVIVED = 20_000
"""Sets that are survived up to which each gets a run."""


def certified_cut_sets(
    graph: AlternativesGraph, mission_net: MissionNet, cut_sets: Iterable[Iterable[str]], ends: Sequence[str]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What is stated of all minimal cut sets at the start, and the evidence.

    Args:
        graph: The listed states.
        mission_net: The mission's net.
        cut_sets: The minimal cut sets.
        ends: The ends that they leave no way to.

    Raises:
        LimitError: There are too many sets that are survived.
    """
    cuts = sorted(sorted(names) for names in cut_sets)
    hardware = [h.name for h in mission_net.mission.hardware if ("oos", h.name) in mission_net.by_role]
    runs = _Runs(graph, mission_net, ends)
    survived = [runs.surviving([hardware[i] for i in sorted(lost)]) for lost in _survived(cuts, hardware)]
    return {"ends": list(ends), "hardware": hardware, "cuts": cuts}, {"survived": survived}


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
    """Runs on which what is lost before the start stays lost."""

    def __init__(self, graph: AlternativesGraph, mission_net: MissionNet, ends: Sequence[str]) -> None:
        self.graph, self.net = graph, mission_net
        known = mission_net.ends
        self.goal = evidence.marking(graph, [known[end] for end in ends if end in known])
        self.before = evidence.marking(graph, [mission_net.beginning])
        events = enumerate(transition.event for transition in mission_net.net.transitions)
        self.repairs = {t: e.element for t, e in events if e is not None and e.what is What.REPAIRED}
        # One search without any repair shows most sets; the others get one of their own.
        self.unrepaired = ~evidence.carrying(graph, list(self.repairs))
        self.far = evidence.distances(graph, self.goal, self.unrepaired)

    def surviving(self, lost: list[str]) -> dict[str, Any]:
        """A set of hardware with a run to an end, and after how many events all of it is lost."""
        graph = self.graph
        out = [evidence.marking(graph, self.net.by_role["oos", name]) for name in lost]
        starts: Mask = reduce(and_, out, self.before)
        edges, far = self.unrepaired, self.far
        if not (starts & (far >= 0)).any():
            edges = ~evidence.carrying(graph, [t for t, name in self.repairs.items() if name in lost])
            far = evidence.distances(graph, self.goal, edges)
        start = int(np.flatnonzero(starts & (far >= 0))[0])
        there = np.zeros(graph.states, np.bool_)
        there[start] = True
        first = evidence.run(graph, there)
        assert first is not None, "all states are reached"
        return {"lost": lost, "by": len(first), "run": first + evidence.nearer(graph, far, start, edges)}
