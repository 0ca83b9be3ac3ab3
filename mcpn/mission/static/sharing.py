"""Who shares what: which resources several activities may use at a time, and by which interfaces.

Software carries data, so any number of activities may use it at a time, unless it is declared exclusive;
hardware is exclusive, unless it is declared shared. Where no two activities can want a resource at the same
moment, nor one of them ask for it again as soon as it has given it back, there is nothing to share, and the
resource has the one interface of the paper. Elsewhere each activity that consumes it has an interface of its
own.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.mission.static.demands import ConcurrentDemands


class Sharing:
    """The static analysis of sharing.

    Args:
        usage: The static analysis of the mission.
    """

    def __init__(self, usage: ConcurrentDemands) -> None:
        self.usage = usage

    @cached_property
    def consumers(self) -> Mapping[str, tuple[str, ...]]:
        """By resource that is shared, the activities that consume it, in document order."""
        usage = self.usage
        wanted = {r for r in usage.wanted_together | usage.wanted_again if not usage.is_exclusive(r)}
        return {
            resource: tuple(a for a in usage.started if resource in usage.resources_of({a}))
            for resource in wanted
        }

    def owners(self, resource: str) -> tuple[str | None, ...]:
        """Whose interfaces a resource has: its consumers', or one of nobody in particular."""
        return self.consumers.get(resource, (None,))

    def owner(self, resource: str, consumer: str) -> str | None:
        """The owner of the interface by which an activity uses a resource."""
        return consumer if resource in self.consumers else None

    def serves(self, activity: str) -> bool:
        """Whether a producer goes on while somebody needs one of its products at the end of a reaction.

        So it does where it has several products, or one that several ask for, or one again and again, or one
        that may be given back while the producer evaluates.
        """
        usage, produces = self.usage, self.usage.activities[activity].produces
        if len(produces) > 1 or not usage.wanted_again.isdisjoint(produces):
            return True
        return any(usage.released_unasked(s) for s in produces)

    @cached_property
    def anything(self) -> bool:
        """Whether any producer serves; the internal transitions of the net then have several ranks."""
        return any(self.serves(a) for a in self.usage.started)

    def kept(self, activity: str) -> bool:
        """Whether the end of an objective may make a branch give a producer up that another begins to use.

        The end of an objective may change facts, or show that hardware is lost. So a branch beside it may
        give up what it uses in the same reaction in which the next objective begins; a producer that serves
        both must await what begins before it stops.
        """
        return activity in self._kept

    @cached_property
    def anything_kept(self) -> bool:
        """Whether any producer is kept."""
        return bool(self._kept)

    @cached_property
    def _kept(self) -> frozenset[str]:
        usage = self.usage
        sensitive = self._sensitive if self.anything else frozenset[str]()
        found = set[str]()
        for graph in usage.graphs() if sensitive else ():
            for block in graph.sections:
                if not isinstance(block, ParallelSection):
                    continue
                started = [
                    {a for o in branch.graph.walk() for a in o.activities} for branch in block.branches
                ]
                reached = [frozenset[str]().union(*map(usage.closure, producers)) for producers in started]
                for producer in filter(self.serves, usage.started):
                    using = [closure for closure in reached if producer in closure]
                    above = (a for a in frozenset[str]().union(*using) if producer in usage.closure(a))
                    if len(using) > 1 and any((usage.closure(a) - {producer}) & sensitive for a in above):
                        found.add(producer)
        # What it serves for must have stopped before it can: at the same moment.
        return frozenset(
            p for p in usage.started if self.serves(p) and not usage.closure(p).isdisjoint(found)
        )

    @cached_property
    def _sensitive(self) -> frozenset[str]:
        """Activities that the end of an objective may make change their alternative."""
        usage = self.usage
        changed = {change.fact for objective in usage.graph.walk() for change in objective.sets}
        late = {h.name for h in usage.core.late}
        return frozenset(
            a
            for a in usage.started
            if not changed.isdisjoint(usage.world.read_by(a)) or usage.resources_of({a}) & late
        )
