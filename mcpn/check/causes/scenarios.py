"""Runs that show failure causes: the shortest to each failure, and the one that survives most.

In these runs nothing is repaired, and objectives fail only where they cannot succeed any more
(:attr:`mcpn.check.causes.prospects.Prospects.forced`): what happens in them is what the lost hardware makes
happen.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any, Generic

from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.mission.flatten import Section
from mcpn.net.events import What
from mcpn.space.algebra import Edge, S
from mcpn.space.images import ImageStore
from mcpn.space.run import Run, transitions_of


class Scenarios(Generic[S]):
    """Runs of a mission that show what its cut sets say.

    Args:
        prospects: The mission in a space of its alternatives graph.
    """

    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects = prospects
        self.space = prospects.space
        self._begin = self.space.initial.pick()

    def _told(self, edges: Iterable[Edge]) -> Run:
        return Run(self.space.net, transitions_of(edges), settles=True)

    def to_failure(self, goal: Goal[S], cut_set: Iterable[str]) -> Run | None:
        """A short run in which a goal fails because of a cut set, and no other hardware fails.

        Args:
            goal: The mission, or an objective.
            cut_set: Names of hardware; all of it is out of service at the end.

        Returns:
            Up to the mission's failure or the objective's failure; where the mission need not end, up to
            where it can no longer succeed. ``None`` where no run without repairs leads there.
        """
        prospects, space, names = self.prospects, self.space, list(cut_set)
        mine = (prospects.carrying(What.OUT_OF_SERVICE, name) for name in names)
        transitions = (prospects.unrepaired - prospects.failing).union(*mine)
        oos = prospects.places("oos", names)
        ends = [space.restricted(prospects.losing(goal, repairs=False), oos, ())]
        if goal is prospects.mission:
            ends.insert(0, space.restricted(space.marked([prospects.mission_net.failure]), oos, ()))
        for wanted, guards in product(ends, (prospects.forced, None)):
            run = space.run(self._begin, wanted, None, transitions, guards)
            if run is not None:
                return self._told(run if goal is prospects.mission else [*run, self._failure(goal, run)])
        return None

    def _failure(self, goal: Goal[S], run: list[Edge]) -> Edge:
        """The edge with which an objective fails at the end of a run."""
        fails = self.prospects.carrying(What.FAILURE, goal.name)
        return next(edge for edge in self.space.edges(run[-1].target) if edge.transition in fails)

    def most_failures(self, section: Section | None = None) -> Run | None:
        """A run to success in which, from one moment on, as many resources fail as in any.

        Args:
            section: The run enters this section with all hardware in service; ``None`` for any run.

        Returns:
            A short such run, or ``None`` where no run leads to success.
        """
        prefix = list[Edge]()
        if section is not None:
            oos = self.prospects.places("oos", self.prospects.hardware)
            entry = self.space.restricted(self.prospects.entered(section), (), oos)
            found = self.space.run(self._begin, entry)
            if found is None:
                return None
            prefix = found
        onward = self._most_failures(prefix[-1].target if prefix else self._begin)
        return None if onward is None else self._told([*prefix, *onward])

    def _most_failures(self, begin: Any) -> list[Edge] | None:
        prospects, space = self.prospects, self.space
        goal, guards = prospects.mission, prospects.forced
        transitions = prospects.unrepaired
        # Success may be followed by failures that cost nothing any more: only edges before it count.
        before = space.reached(space.single(begin), goal.running, transitions, guards)
        ends = space.after(before, transitions, guards) & goal.won
        if not ends:
            return [] if space.single(begin) & goal.won else None
        oos = prospects.places("oos", prospects.hardware)
        images = ImageStore(len(oos))
        most = images.sized(space.image(ends, oos, images))
        widest = ends & space.at_most(dict.fromkeys(oos, -1), -most)
        return space.run(begin, widest, goal.running, transitions, guards)
