"""Runs of a mission through its sections, found on the composite and told in mission words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import count

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order

from mcpn.check.runs import Step, replay, what_happens
from mcpn.net.templates import TemplateSet
from mcpn.space.composite import ENDS, Composite
from mcpn.space.graph import Ints, Mask
from mcpn.space.local import OUTCOMES, LocalGraph, PlacedSection


@dataclass(frozen=True)
class Leg:
    """One section of a journey.

    Args:
        placed: The section.
        entry: Mask of its hardware out of service at its entry.
        edges: Edges of its local graph from the first state inside on; the last one leaves the section, but
            for a journey that ends inside.
        toggled: Other hardware that fails or recovers meanwhile, before the section is left: names and
            whether they fail.
    """

    placed: PlacedSection
    entry: int
    edges: list[int]
    toggled: tuple[tuple[str, bool], ...] = ()


@dataclass
class _Node:
    name: str
    entry: int
    whole: int  # hardware out of service, by its bit in the composite's order
    before: _Node | None = None
    edges: list[int] = field(default_factory=list)  # of the section before
    toggled: tuple[tuple[str, bool], ...] = ()


class Journeys:
    """Finds short runs through the sections of a composite.

    A run is shortest among those in which hardware that a section does not use changes only where it must; it
    need not be shortest of all.

    Args:
        composite: The mission's composite.
    """

    def __init__(self, composite: Composite) -> None:
        self.composite = composite
        self.bit = {name: i for i, name in enumerate(composite.faulty)}
        self._walks: dict[tuple[int, int], tuple[Ints, Ints]] = {}

    def find(self, ends: Iterable[str] = (), states: Mapping[str, Mask] | None = None) -> list[Leg] | None:
        """A short run to an end of the mission, or to some state inside a section.

        Args:
            ends: ``succeed`` or ``fail``, where such an end will do.
            states: By section, the states of its local graph that will do.

        Returns:
            The run section by section, or ``None`` where there is none.
        """
        goals = set(ends)
        found = self._search(goals, states or {}, toggling=False)
        return found if found is not None else self._search(goals, states or {}, toggling=True)

    def _search(self, ends: set[str], states: Mapping[str, Mask], *, toggling: bool) -> list[Leg] | None:
        composite, ticket = self.composite, count()
        first = composite.by_name[composite.graph.entry]
        heap: list[tuple[int, int, _Node]] = []
        for entry in range(1 << len(first.faulty)):
            node = _Node(composite.graph.entry, entry, self._whole(first, entry))
            heappush(heap, (entry.bit_count() + 1, next(ticket), node))
        done: set[tuple[str, int]] = set()
        while heap:
            cost, _, node = heappop(heap)
            if node.name in ENDS:
                return self._legs(node, [])
            if (node.name, node.entry) in done:
                continue
            done.add((node.name, node.entry))
            placed = composite.by_name[node.name]
            distance, via = self._walk(placed.local, int(placed.local.entry[node.entry]))
            inside = states.get(node.name)
            if inside is not None and (inside & (distance >= 0)).any():
                reached = np.flatnonzero(inside & (distance >= 0))
                return self._legs(
                    node, self._path(via, placed.local, int(reached[distance[reached].argmin()]))
                )
            for more, after in self._onward(node, placed, distance, via, ends, toggling):
                heappush(heap, (cost + more, next(ticket), after))
        return None

    def _onward(
        self, node: _Node, placed: PlacedSection, distance: Ints, via: Ints, ends: set[str], toggling: bool
    ) -> Iterable[tuple[int, _Node]]:
        local = placed.local
        for outcome in OUTCOMES:
            route = self.composite.route(node.name, outcome)
            if route in ENDS and route not in ends:
                continue
            edges = local.leaving[outcome]
            sources = local.graph.sources[edges]
            edges, lengths = edges[distance[sources] >= 0], distance[sources][distance[sources] >= 0]
            masks = local.out_of_service[local.graph.targets[edges]]
            nearest = np.lexsort((lengths, masks))
            _, firsts = np.unique(masks[nearest], return_index=True)
            for position in nearest[firsts].tolist():
                edge, length = int(edges[position]), int(lengths[position]) + 1
                run = [*self._path(via, local, int(local.graph.sources[edge])), edge]
                whole = node.whole & ~self._whole(placed, -1) | self._whole(placed, int(masks[position]))
                if route in ENDS:
                    yield length, _Node(route, 0, whole, node, run)
                    continue
                for entry, toggled in self._entries(placed, self.composite.by_name[route], whole, toggling):
                    changed = whole
                    for name, _ in toggled:
                        changed ^= 1 << self.bit[name]
                    yield length + len(toggled), _Node(route, entry, changed, node, run, toggled)

    def _entries(
        self, placed: PlacedSection, target: PlacedSection, whole: int, toggling: bool
    ) -> Iterable[tuple[int, tuple[tuple[str, bool], ...]]]:
        """Masks with which the next section may be entered, and the free hardware that changes for it."""
        as_it_is = sum((whole >> self.bit[h] & 1) << i for i, h in enumerate(target.faulty))
        free = [i for i, h in enumerate(target.faulty) if h not in placed.faulty]
        for chosen in range(1 << len(free) if toggling else 1):
            flips = [i for position, i in enumerate(free) if chosen >> position & 1]
            entry = as_it_is
            for i in flips:
                entry ^= 1 << i
            yield entry, tuple((target.faulty[i], bool(entry >> i & 1)) for i in flips)

    def _whole(self, placed: PlacedSection, mask: int) -> int:
        return sum((mask >> i & 1) << self.bit[name] for i, name in enumerate(placed.faulty))

    def _walk(self, local: LocalGraph, start: int) -> tuple[Ints, Ints]:
        """Distances inside a section from a state, -1 where there is no way, and the state before each."""
        key = id(local), start
        if key not in self._walks:
            graph, chosen = local.graph, local.edges_inside
            ends = graph.sources[chosen], graph.targets[chosen]
            size = graph.states, graph.states
            matrix = csr_matrix((np.ones(len(ends[0]), np.int8), ends), size)
            order, before = breadth_first_order(matrix, start)
            distance = np.full(graph.states, -1, np.int64)
            distance[start] = 0
            for state in order[1:].tolist():
                distance[state] = distance[before[state]] + 1
            self._walks[key] = distance, before.astype(np.int64)
        return self._walks[key]

    def _path(self, before: Ints, local: LocalGraph, state: int) -> list[int]:
        edges: list[int] = []
        graph = local.graph
        while before[state] >= 0:
            source = int(before[state])
            first, last = int(graph.offsets[source]), int(graph.offsets[source + 1])
            edges.append(first + int(np.flatnonzero(graph.targets[first:last] == state)[0]))
            state = source
        return edges[::-1]

    def _legs(self, node: _Node, last: list[int]) -> list[Leg]:
        legs: list[Leg] = []
        edges, toggled = last, tuple[tuple[str, bool], ...]()
        at: _Node | None = node
        while at is not None:
            if at.name not in ENDS:
                legs.append(Leg(self.composite.by_name[at.name], at.entry, edges, toggled))
            edges, toggled, at = at.edges, at.toggled, at.before
        return legs[::-1]


def told(legs: list[Leg], templates: TemplateSet | None = None) -> list[Step]:
    """A journey event by event, in mission words.

    Args:
        legs: The journey.
        templates: Those that the mission is composed with.
    """
    steps: list[Step] = []
    for number, leg in enumerate(legs):
        mission_net = leg.placed.net(templates)
        net = mission_net.net
        graph = leg.placed.local.graph
        names = {t.event: t.name for t in reversed(net.transitions) if t.event}
        failed = [h for i, h in enumerate(leg.placed.faulty) if leg.entry >> i & 1]
        begin = [names[f"{h}_EV_OOS"] for h in failed]  # of its two transitions, that of a free resource
        firings = [
            names["MISSION_EV_START"],
            *(net.transitions[int(graph.labels[e])].name for e in leg.edges),
        ]
        local_steps = replay(mission_net, [*begin, *firings])
        if number == 0:
            steps += local_steps[: len(failed) + 1]
        else:
            _, _, changes = local_steps[len(failed)].words.partition(": ")
            steps[-1] = Step(steps[-1].event, f"{steps[-1].words}: {changes}" if changes else steps[-1].words)
        inside = local_steps[len(failed) + 1 :]
        leaves = number + 1 < len(legs)
        steps += inside[: len(inside) - leaves]
        for name, fails in leg.toggled:
            words = f"{name} goes out of service" if fails else f"{name} is ready again"
            steps.append(Step(f"{name}_EV_{'OOS' if fails else 'RD'}", words))
        if leaves:
            steps.append(
                Step(inside[-1].event, what_happens(net.transitions[int(graph.labels[leg.edges[-1]])]))
            )
    return steps
