"""Runs that show failure causes: the shortest to each failure, and the one that survives most.

In these runs nothing is repaired, and objectives fail only where they cannot succeed any more
(:attr:`mcpn.check.losing.Outlook.forced`): what happens in them is what the lost hardware makes happen.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mcpn.check.cutsets import Losses
from mcpn.check.losing import Goal
from mcpn.net.events import Event, What
from mcpn.space.graph import Mask

Run = list[int]
"""Edges of the graph from its initial state."""


class Scenarios:
    """Runs of a mission's graph that show what its losses say.

    Args:
        losses: The loss functions of the mission.
    """

    def __init__(self, losses: Losses) -> None:
        self.losses = losses
        self.outlook = losses.outlook
        self.graph = losses.outlook.graph

    def to_failure(self, goal: Goal, cut_set: Iterable[str]) -> Run | None:
        """A shortest run in which a goal fails because of a cut set, and no other hardware fails.

        Args:
            goal: The mission, or an objective.
            cut_set: Names of hardware; all of it is out of service at the end.

        Returns:
            Up to the mission's failure or the objective's failure; where the mission need not end,
            up to where it can no longer succeed. ``None`` where no run without repairs leads there.
        """
        outlook, graph = self.outlook, self.graph
        members = [outlook.index[name] for name in cut_set]
        mine = np.isin(outlook.failing, [-1, *members])
        out = outlook.out[:, members].all(axis=1)
        ways = (outlook.forced & mine, outlook.allowed(False) & mine)
        if goal.kind == "objective":
            lost = outlook.losing(goal, repairs=False) & out
            fails = outlook.fired(Event(What.FAILURE, goal.name))
            for along in ways:
                run = graph.run_to(lost, along=along)
                if run is not None:
                    end = int(graph.targets[run[-1]]) if run else 0
                    return [*run, int(np.flatnonzero(fails & (graph.sources == end))[0])]
            return None
        failed = graph.marked(outlook.mission_net.failure)
        for ends in (failed & out, outlook.losing(goal, repairs=False) & out):
            for along in ways:
                run = graph.run_to(ends, along=along)
                if run is not None:
                    return run
        return None

    def most_failures(self, section: str | None = None) -> Run | None:
        """A run to success in which, from one moment on, as many resources fail as in any.

        Args:
            section: The run enters this section with all hardware in service; ``None`` for any run.

        Returns:
            A shortest such run, or ``None`` where no run leads to success.
        """
        begin = self._begin(section)
        run = self._most_failures(begin[1]) if begin else None
        return None if begin is None or run is None else [*begin[0], *run]

    def _begin(self, section: str | None) -> tuple[Run, int] | None:
        """A run to the entry of a section with all hardware in service, and where it ends."""
        if section is None:
            return [], 0
        entry = self.losses.entry(section) & ~self.outlook.out.any(axis=1)
        prefix = self.graph.run_to(entry)
        if prefix is None:
            return None
        return prefix, int(self.graph.targets[prefix[-1]]) if prefix else 0

    def _most_failures(self, start: int) -> Run | None:
        graph, outlook = self.graph, self.outlook
        success: Mask = outlook.mission.won
        along = outlook.forced & ~success[graph.sources]
        ends = graph.reached(along, start) & success
        if not ends.any():
            return None
        failures = outlook.out.sum(axis=1)
        return graph.run_to(ends & (failures == failures[ends].max()), start, along)
