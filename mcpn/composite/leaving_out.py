"""Whether a mission reaches a goal without some events, asked of many sets of events at once.

Most events are of one section. Where no cycle leads back to it, a run without one of them either passes the
section by, or passes it without the event: one closure of the whole, and one of the section, answer that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

from mcpn._kernel import Zdd
from mcpn.composite.glued import CompositeSet, Glued
from mcpn.spaces.algebra import Without


class LeavingOut:
    """One goal, asked without several sets of events.

    Regions of the space have positions: 0 is that of the last, and edges never lead to a higher one.

    Args:
        space: The composite.
        goal: Where runs lead.
    """

    def __init__(self, space: Glued, goal: CompositeSet) -> None:
        self.space, self.goal = space, goal
        self.hopeful = space.reaching(goal)
        self.every = space.carrying

    def reaches(self, left_out: frozenset[int]) -> bool:
        """Whether some run from the initial state leads to the goal without some events."""
        space = self.space
        if not self.hopeful & space.initial or space.initial & self.goal:
            return bool(self.hopeful & space.initial)
        if (having := space.having(left_out)) is None:  # hardware fails whatever runs
            return bool(space.reaching(self.goal, transitions=Without(self.every, left_out)) & space.initial)
        at = sorted(self.position[name] for name in having if name in self.position)
        if not at or self._nearest[at[-1]] < at[0]:
            return True
        return self._through(at[0], at[-1], left_out)

    @cached_property
    def position(self) -> Mapping[str, int]:
        """By section, the position of its region."""
        return {name: i for i, region in enumerate(self.space.regions) for name in region.parts}

    @cached_property
    def _entered(self) -> Mapping[str, Mapping[str, Zdd]]:
        """By section, the states in which others before its region enter it, by these."""
        stages, found = self.space.stages, dict[str, dict[str, Zdd]]()
        for name, part in self.space.everything.parts.items():
            for route, status in stages[name].leave(part):
                if self.position[route] < self.position[name]:
                    found.setdefault(route, {})[name] = stages[route].entered(status)
        return found

    @cached_property
    def _nearest(self) -> Sequence[int]:
        """By position, how far some edge leads from before it to where the goal can be reached; -1: to it."""
        space, position, hopeful = self.space, self.position, self.hopeful
        last = len(space.regions)
        nearest = [last] * last
        for route, sources in self._entered.items():
            for name, states in sources.items():
                if states & hopeful.of(route):
                    before = position[name] - 1
                    nearest[before] = min(nearest[before], position[route])
        for name in (self.goal & space.everything).parts:
            if position[name]:
                nearest[position[name] - 1] = -1
        for i in range(last - 2, -1, -1):
            nearest[i] = min(nearest[i], nearest[i + 1])
        return nearest

    def _through(self, low: int, high: int, left_out: frozenset[int]) -> bool:
        """Whether a run that enters regions from one position to another goes on to the goal."""
        space, regions = self.space, self.space.regions[low : high + 1]
        names = [name for region in regions for name in region.parts]
        within = CompositeSet(space, {name: space.everything.of(name) for name in names})
        routes = {route for name in names for route in space.stages[name].routes.values()}
        onward = {r: self.hopeful.of(r) for r in routes if self.position.get(r, low) < low}
        goal = CompositeSet(space, {**onward, **(self.goal & within).parts})
        if len(names) == 1 and self._never_leads_on(names[0], goal, left_out):
            return False
        found = space.reaching(goal, within, Without(self.every, left_out))
        return bool(found & space.initial) or any(
            states & found.of(name) for name in names for states in self._into(name, high)
        )

    def _never_leads_on(self, name: str, goal: CompositeSet, left_out: frozenset[int]) -> bool:
        """Whether it is seen at once that no exit which leads to a goal is reached without some events."""
        stage = self.space.stages[name]
        if goal.of(name):
            return False
        own = frozenset(t for t in stage.type.carrying if stage.transitions[t] in left_out)
        onward = (exit_ for exit_, route in stage.routes.items() if goal.of(route))
        return stage.type.may_lead_to(own).isdisjoint(onward)

    def _into(self, name: str, high: int) -> Iterator[Zdd]:
        """The states in which a section is entered from before some position."""
        entered = self._entered.get(name, {})
        return (states for source, states in entered.items() if self.position[source] > high)
