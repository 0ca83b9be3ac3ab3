"""Hardware that fails on demand: edges of a chain split by what fails as it starts to be used.

Whenever an alternative starts to run, each resource that it consumes and that may fail on demand fails at
once with its probability. That takes no time, so that nothing comes between: an edge that starts alternatives
is one edge for each way in which their resources fail or do not, with the product of the probabilities. What
fails is taken out of service by its event, and what starts thereby is asked in turn. Of several resources
those are asked first that the activities of the section come upon first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from mcpn.drawing.compose import MissionNet
from mcpn.drawing.status import Element
from mcpn.events import What
from mcpn.spaces.markings.graph import Ints, Mask, StateGraph
from mcpn.spaces.run import Completion

Asked: TypeAlias = tuple[tuple[int, bool], ...]
"""Resources that were asked, by number, each with whether it failed."""


class Demand(NamedTuple):
    """An alternative that has just started and a resource of it, in the order in which they are asked."""

    rank: tuple[int, ...]
    place: int
    resource: int


class SplitEdges(NamedTuple):
    """Edges that are split by what fails on demand.

    Args:
        graph: The states, with the edges.
        asked: By edge, the index in ``answers`` of the resources asked along it.
        answers: The different sequences of resources asked, each resource with whether it failed.
    """

    graph: StateGraph
    asked: Ints
    answers: Sequence[Asked]

    def weights(self, probabilities: Sequence[float | Fraction], kind: type[np.generic]) -> npt.NDArray[Any]:
        """How probable each edge is, given that its event happens, as floats or as exact fractions."""
        each = [
            math.prod(probabilities[i] if fails else 1 - probabilities[i] for i, fails in answers)
            for answers in self.answers
        ]
        return np.array(each, kind)[self.asked]


def split_edges(
    graph: StateGraph, mission_net: MissionNet, carried: Sequence[Element], demanded: Sequence[int]
) -> SplitEdges:
    """Splits the edges that start alternatives by what fails on demand.

    Args:
        graph: The alternatives graph of a section, or of the whole mission.
        mission_net: Its net.
        carried: What has a status, as of :class:`mcpn.answers.causes.chain.ListedChain`.
        demanded: The numbers of those among them that may fail on demand.
    """
    splitting = _Splitting(graph, mission_net, {carried[i][1]: i for i in demanded})
    known: dict[Asked, int] = {(): 0}
    rows = list[tuple[int, int, int, int]]()
    sources, labels, targets = (at.tolist() for at in (graph.sources, graph.labels, graph.targets))
    for edge in zip(sources, labels, targets, strict=True):
        started = splitting.started(*edge)
        for asked, end in splitting.ends(edge[2], started):
            rows.append((edge[0], edge[1], end, known.setdefault(asked, len(known))))
    return _of_rows(graph, rows, list(known))


class _Splitting:
    """Follows what an edge starts: the resources to be asked, and the states after their failures."""

    def __init__(self, graph: StateGraph, mission_net: MissionNet, demanded: Mapping[str, int]) -> None:
        self.graph = graph
        self.net = mission_net.net
        self.completion = Completion(self.net)
        self.marking = cache(graph.marking)
        self.consuming: dict[int, list[str]] = {}  # by place of an alternative that runs
        self.rank: dict[int, tuple[int, int]] = {}
        usage, active = mission_net.usage, mission_net.saying("active")
        parts = mission_net.section_parts
        for place, name in active.items():
            activity, _, alternative = name.partition(".")
            ways = usage.activities[activity].alternatives
            (number,) = (i for i, way in enumerate(ways) if way.name == alternative)
            needed = [k for k in ways[number].consumes if k in demanded]
            if needed:
                self.consuming[place], self.rank[place] = needed, (0, number)
        self.demanded = demanded
        self.out = {name: mission_net.by_role["oos", name][0] for name in demanded}
        self.activity = {place: name.partition(".")[0] for place, name in active.items()}
        self.running = {
            place: parts.alone(section).used
            for section in mission_net.graph.sections
            for inner in section.walk()
            for place in mission_net.by_role.get(("objective", inner.name), ())
        }
        events, lost = self.net.events, What.OUT_OF_SERVICE
        self.fails = {t: e.element for e in events if e.what is lost for t in events.of(e)}

    @cache  # noqa: B019 - it lives as long as one split
    def started(self, source: int, label: int, target: int) -> tuple[Demand, ...]:
        """What an edge starts that may fail on demand, in order."""
        after = self.marking(target)
        places = [place for place in self.consuming if after[place]]
        used = next((parts for place, parts in self.running.items() if after[place]), None)
        if not places or used is None:
            return ()
        fired, _ = self.completion.after(self.marking(source), label)
        produced = {p for t in (label, *fired) for p, _ in self.net.transitions[t].produce}
        found = (
            Demand((used.number[k], used.task[self.activity[p]], self.rank[p][1]), p, self.demanded[k])
            for p in places
            if p in produced
            for k in self.consuming[p]
            if not after[self.out[k]]  # it may be lost already, where that is detected late
        )
        return tuple(sorted(found))

    def ends(self, state: int, pending: tuple[Demand, ...]) -> Iterator[tuple[Asked, int]]:
        """For each outcome: the resources asked, with whether each failed, and the state reached."""
        if not pending:
            yield (), state
            return
        (_, _, resource), rest = pending[0], pending[1:]
        for asked, end in self.ends(state, rest):
            yield ((resource, False), *asked), end
        label, lost = self._lost(state, resource)
        after = self.marking(lost)
        still = (demand for demand in rest if demand.resource != resource and after[demand.place])
        following = tuple(sorted({*still, *self.started(state, label, lost)}))
        for asked, end in self.ends(lost, following):
            yield ((resource, True), *asked), end

    def _lost(self, state: int, resource: int) -> tuple[int, int]:
        """The edge with which a resource that is used goes out of service."""
        for label, target in self.graph.successors(state):
            if self.demanded.get(self.fails.get(label, "")) == resource:
                return label, target
        raise AssertionError("what is in service may always fail")


def entered_again(split: SplitEdges, returning: Mask, status: Ints, start: Mask) -> tuple[SplitEdges, Mask]:
    """Redirects edges that enter the section again to its first states, split as edges of the start are.

    Args:
        split: The edges.
        returning: Edges to exits after which the section is entered again at once; they ask for nothing.
        status: By state, its status.
        start: The edges with which the section begins.

    Returns:
        The edges, and which of them come back so.
    """
    graph = split.graph
    columns = np.stack(
        [graph.sources, graph.labels, np.asarray(graph.targets, np.int64), split.asked], axis=1
    )
    first: dict[int, list[tuple[int, int]]] = {}
    for source, _, target, asked in columns[start].tolist():
        first.setdefault(int(status[source]), []).append((target, asked))
    rows, came_back = list[Sequence[int]](), list[bool]()
    for row, back in zip(columns.tolist(), returning.tolist(), strict=True):
        ends = first.get(int(status[row[2]]), []) if back else []
        rows += [(row[0], row[1], target, asked) for target, asked in ends] or [row]
        came_back += [bool(ends)] * max(1, len(ends))
    return _of_rows(graph, rows, split.answers), np.array(came_back, np.bool_)


def _of_rows(graph: StateGraph, rows: Sequence[Sequence[int]], answers: Sequence[Asked]) -> SplitEdges:
    found = np.array(rows, np.int64).reshape(-1, 4)
    offsets = np.concatenate([[0], np.cumsum(np.bincount(found[:, 0], minlength=graph.states))])
    split = replace(graph, offsets=offsets, targets=found[:, 2], labelled=found[:, 1])
    return SplitEdges(split, found[:, 3], answers)
