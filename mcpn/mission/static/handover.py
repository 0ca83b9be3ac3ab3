"""From one objective to the next: what the next one waits for before it begins.

An event that ends an objective stops its activities, and they release their resources while the next
objective already begins. Mostly the two do not conflict: a release only gives back, and whoever demands a
resource waits until it is available. They may conflict in two cases:

- an activity may still be choosing its alternative when its objective ends, because it waits for a release;
- both objectives need a producer that is running, which would otherwise keep its present alternative.

In these cases the next objective begins by a *gate*: an internal transition of the last rank, which fires
when every activity that is to stop has stopped. An activity that the next objective starts again waits until
it is idle. ``papers/composition.md`` has the argument.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, cached_property
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED

if TYPE_CHECKING:
    from mcpn.mission.static.demands import ConcurrentDemands
    from mcpn.mission.static.sharing import Sharing


class Handover:
    """What must be over before a section begins.

    Args:
         usage: What activities demand.
        sharing: Which resources they share.
    """

    def __init__(self, usage: ConcurrentDemands, sharing: Sharing) -> None:
        self.usage = usage
        self.sharing = sharing

    @cached_property
    def with_idle(self) -> frozenset[str]:
        """Activities that need a place that says that they are idle.

        They are those that one edge of the objectives graph stops and starts again (a retry, a protocol used
        twice in a row), and those that two branches of a parallel block start.
        """
        return self._along_edges[0].union(activity for *_, activity in self.usage.started_twice())

    @cached_property
    def gated(self) -> frozenset[str]:
        """The sections, at any depth, that begin only when what stops before them has stopped."""
        if any(section.becomes for section in self.usage.graph.all_sections()):
            # What begins waits for facts to be asked, which may stop it, or what is beside it.
            return frozenset(section.name for section in self.usage.graph.all_sections())
        names = set(self._along_edges[1])
        names.update(section.name for graph in self.usage.graphs() for section in _stopped_at_once(graph))
        # An objective that changes facts at its start waits until all before it has stopped: its change must
        # not affect alternatives of activities that are still stopping.
        for section in self.usage.graph.sections:
            if any(first.setting("start") for first in entries(section)):
                names.add(section.name)
        return frozenset(names)

    @cached_property
    def _along_edges(self) -> tuple[frozenset[str], frozenset[str]]:
        """Activities that one edge of the graph stops and starts; sections that need a gate after an edge."""
        activities, names, may_compete = set[str](), set[str](), cache(self._may_compete)
        for ending, target in _onward(self.usage.graph, {}):
            beginning = _activities(entries(target))
            activities |= ending & beginning
            if may_compete(ending, beginning):
                names.add(target.name)
        return frozenset(activities), frozenset(names)

    def _may_compete(self, ending: frozenset[str], beginning: frozenset[str]) -> bool:
        """Whether activities that stop may compete for a resource or a producer with those that begin."""
        usage, before, after = self.usage, self._reached(ending), self._reached(beginning)
        if not any(usage.may_wait(a) or self.sharing.serves(a) for a in before):
            return False
        shared = usage.resources_of(before) & usage.resources_of(after)
        return bool(shared) or not before.isdisjoint(after)

    def _reached(self, activities: Iterable[str]) -> frozenset[str]:
        return frozenset[str]().union(*(self.usage.closure(a) for a in activities))


def entries(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that start when a section is entered."""
    if isinstance(section, ElementarySection):
        return (section,)
    return tuple(
        first for branch in section.branches for first in entries(branch.graph.section(branch.graph.entry))
    )


Running: TypeAlias = Mapping[str, frozenset[str]]
"""By declared event, the activities that it may stop."""


def _onward(graph: ObjectivesGraph, beside: Running) -> Iterator[tuple[frozenset[str], Section]]:
    """Sections that others lead to, at any depth, each with activities that may be stopped as it is entered.

    The end of a section stops its last objectives. An interruption stops all that run. What the same event
    interrupts in other branches comes as a set of its own.

    Args:
        graph: The mission's graph, or that of a branch.
        beside: By event, the activities that it may stop in other branches.
    """
    for section in graph.sections:
        running = _activities(section.walk())
        ending = _activities(_endings(section))
        yield from ((ending, target) for target in graph.targets(section))
        yield from ((running, target) for target in graph.interrupted(section))
        if isinstance(section, ParallelSection):
            events = _joined(*(_interrupted(branch.graph) for branch in section.branches))
            stopping = [running, *(beside.get(event, frozenset()) for event in events)]
            yield from ((ending, target) for ending in stopping for target in graph.aborted(section))
            yield from _pausing(section)
            for pause_graph in section.pause_graphs:
                yield from _onward(pause_graph.graph, beside)
        for event, stopped in beside.items():
            yield from ((stopped, target) for target in graph.interrupted(section, event))
        branches = section.branches if isinstance(section, ParallelSection) else ()
        for branch in branches:
            if _leads_nowhere(branch.graph):
                continue
            others = (_interrupted(other.graph) for other in branches if other is not branch)
            yield from _onward(branch.graph, _joined(beside, *others))


def _leads_nowhere(graph: ObjectivesGraph) -> bool:
    """Whether a branch is one objective that does not lead to itself, as most branches are."""
    first = graph.sections[0]
    alone = len(graph.sections) == 1 and isinstance(first, ElementarySection)
    return alone and first.name not in first.routes


def _pausing(block: ParallelSection) -> Iterator[tuple[frozenset[str], Section]]:
    """What runs while a block pauses, and what goes on after it, each with activities that stop before it."""
    for pause_graph in block.pause_graphs:
        others = [graph for graph in block.graphs if graph is not pause_graph.graph]
        yield (
            _activities(o for graph in others for o in graph.walk()),
            pause_graph.graph.section(pause_graph.graph.entry),
        )
        ending = _activities(pause_graph.graph.walk())
        yield from ((ending, objective) for graph in others for objective in graph.walk())


def _interrupted(graph: ObjectivesGraph) -> Running:
    """By declared event, the activities of a graph that it may stop, by any handler at any depth."""
    found: Running = {}
    for section in graph.sections:
        running = _activities(section.walk())
        found = _joined(found, dict.fromkeys((i.event for i in section.interruptions), running))
        if not isinstance(section, ParallelSection):
            continue
        for branch in section.branches:
            inside = _interrupted(branch.graph)
            if section.early:  # an event that ends a branch may so end the block, and stop all its branches
                inside = dict.fromkeys(inside, running)
            found = _joined(found, inside)
        found = _joined(found, *(_interrupted(pause_graph.graph) for pause_graph in section.pause_graphs))
    return found


def _stopped_at_once(graph: ObjectivesGraph) -> Iterator[Section]:
    """Sections that an event may lead to, and stop in the same moment as another branch ends the block."""
    for block in graph.sections:
        branches = block.branches if isinstance(block, ParallelSection) else ()
        for branch in branches:
            events = _interrupted(branch.graph).keys()
            deciding = (
                {other.name for _, other in block.deciding} if isinstance(block, ParallelSection) else ()
            )
            others = (other.graph for other in branches if other is not branch and other.name in deciding)
            if any(not events.isdisjoint(_interrupted(other)) for other in others):
                yield from branch.graph.all_sections()


def _joined(*all_: Running) -> Running:
    return {event: frozenset().union(*(each.get(event, ()) for each in all_)) for event in chain(*all_)}


def _activities(sections: Iterable[ElementarySection]) -> frozenset[str]:
    return frozenset(activity for section in sections for activity in section.activities)


def _endings(section: Section) -> tuple[ElementarySection, ...]:
    """The elementary objectives that may run when a section ends; of a parallel block, those of each branch.

    Where the end of a block, or its time, may stop branches that still run, they are all of its objectives.
    """
    if isinstance(section, ElementarySection) or section.early or section.pause_graphs or section.stopped:
        return tuple(section.walk())
    return tuple(
        last
        for branch in section.branches
        for inner in branch.graph.sections
        if any(route in (SUCCEED, FAIL) for route in inner.routes)
        for last in _endings(inner)
    )
