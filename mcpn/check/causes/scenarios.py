"""Runs that show failure causes: the shortest to each failure, and the one that survives most.

In these runs nothing is repaired, and objectives fail only where they cannot succeed any more
(:attr:`mcpn.check.causes.prospects.Prospects.forced`): what happens in them is what the lost hardware makes
happen.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

from mcpn.check.causes.prospects import Goal, Prospects
from mcpn.mission.flatten import Section
from mcpn.net.events import What
from mcpn.space.algebra import Edge, S, Space
from mcpn.space.images import ImageStore
from mcpn.space.run import Run, transitions_of


def to_failure(prospects: Prospects[S], goal: Goal[S], cut_set: Iterable[str]) -> Run | None:
    """A short run in which a goal fails because of a cut set, and no other hardware fails.

    Args:
        prospects: The mission in a space of its alternatives graph.
        goal: The mission, or an objective.
        cut_set: Names of hardware; all of it is out of service at the end.

    Returns:
        Up to the mission's failure or the objective's failure; where the mission need not end, up to
        where it can no longer succeed. ``None`` where no run without repairs leads there.
    """
    space, names = prospects.space, list(cut_set)
    mine = (prospects.carrying(What.OUT_OF_SERVICE, name) for name in names)
    transitions = (prospects.unrepaired - prospects.failing).union(*mine)
    oos = prospects.places("oos", names)
    ends = [space.restricted(prospects.losing(goal, repairs=False), oos, ())]
    if goal is prospects.mission:
        ends.insert(0, space.restricted(space.marked([prospects.mission_net.failure]), oos, ()))
    for wanted, guards in product(ends, (prospects.forced, None)):
        run = space.run(space.initial.pick(), wanted, None, transitions, guards)
        if run is not None:
            if goal is not prospects.mission:
                fails = prospects.carrying(What.FAILURE, goal.name)
                run.append(next(e for e in space.edges(run[-1].target) if e.transition in fails))
            return _told(space, run)
    return None


def most_failures(prospects: Prospects[S], section: Section | None = None) -> Run | None:
    """A run to success in which, from one moment on, as many resources fail as in any.

    Args:
        prospects: The mission in a space of its alternatives graph.
        section: The run enters this section with all hardware in service; ``None`` for any run.

    Returns:
        A short such run, or ``None`` where no run leads to success.
    """
    space, prefix = prospects.space, list[Edge]()
    if section is not None:
        oos = prospects.places("oos", prospects.hardware)
        entry = space.restricted(prospects.entered(section), (), oos)
        found = space.run(space.initial.pick(), entry)
        if found is None:
            return None
        prefix = found
    onward = _most_failures(prospects, prefix[-1].target if prefix else space.initial.pick())
    return None if onward is None else _told(space, [*prefix, *onward])


def _most_failures(prospects: Prospects[S], begin: Any) -> list[Edge] | None:
    space, goal = prospects.space, prospects.mission
    guards, transitions = prospects.forced, prospects.unrepaired
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


def _told(space: Space[S], edges: Iterable[Edge]) -> Run:
    return Run(space.net, transitions_of(edges), settles=True)
