"""The composite: local graphs glued at their interface states, in place of the graph of the whole mission.

A state of the whole is a section, a state of its local graph, and which of the *other* hardware is out of
service. That other hardware evolves freely beside the section: from any of its states any other is reached by
events of its own, so it is a factor of two for each resource, and never enumerated. Sizes are sums over
sections of such products, exact at any size.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.mission.usage import Usage
from mcpn.space.graph import Ints, Mask
from mcpn.space.local import OUTCOMES, LocalGraph, Outcome, PlacedSection

ENDS: Mapping[str, Outcome] = {SUCCEED: "success", FAIL: "failure"}


@dataclass(frozen=True, eq=False)
class Composite:
    """A mission as its sections' local graphs.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        sections: Every section with its local graph.
    """

    usage: Usage
    graph: ObjectivesGraph
    sections: tuple[PlacedSection, ...]
    _memo: dict[tuple[int, bytes], Mask] = field(default_factory=dict)

    @cached_property
    def by_name(self) -> dict[str, PlacedSection]:
        """Sections by name."""
        return {placed.section.name: placed for placed in self.sections}

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """All hardware of the mission that can fail, in document order."""
        return tuple(h.name for h in self.usage.mission.hardware if h.faulty)

    def route(self, name: str, outcome: Outcome) -> str:
        """Where a section leads: another's name, or one of the mission's ends."""
        section = self.by_name[name].section
        return section.success if outcome == "success" else section.failure

    # --- forward ---

    @cached_property
    def reached(self) -> dict[str, Mask]:
        """By section, which states of its local graph the mission reaches, shape (states,) each."""
        entered = {self.graph.entry: np.ones(1 << len(self.by_name[self.graph.entry].faulty), np.bool_)}
        found: dict[str, Mask] = {}
        waiting = deque([self.graph.entry])
        while waiting:
            name = waiting.popleft()
            placed = self.by_name[name]
            found[name] = self._inside_from(placed.local, entered[name])
            for outcome in OUTCOMES:
                target = self.route(name, outcome)
                if target in ENDS:
                    continue
                arriving = self.passed_on(placed, outcome, found[name], self.by_name[target])
                known = entered.get(target)
                if known is None or (arriving & ~known).any():
                    entered[target] = arriving if known is None else known | arriving
                    if target not in waiting:
                        waiting.append(target)
        return found

    def _inside_from(self, local: LocalGraph, entered: Mask) -> Mask:
        key = id(local), entered.tobytes()
        if key not in self._memo:
            self._memo[key] = local.graph.reached(local.edges_inside, local.entry[entered])
        return self._memo[key]

    def exits(self, placed: PlacedSection, outcome: Outcome, reached: Mask) -> Mask:
        """With which masks of its own hardware a section ends so, shape (masks,)."""
        local = placed.local
        edges = local.leaving[outcome]
        edges = edges[reached[local.graph.sources[edges]]]
        found = np.zeros(1 << len(local.faulty), np.bool_)
        found[local.out_of_service[local.graph.targets[edges]]] = True
        return found

    def passed_on(
        self, placed: PlacedSection, outcome: Outcome, reached: Mask, target: PlacedSection
    ) -> Mask:
        """With which masks of its hardware the next section is entered, shape (masks,).

        Hardware that only the next one uses has been free, so it comes in both states.
        """
        exits = self.exits(placed, outcome, reached)
        shared = [(i, placed.faulty.index(h)) for i, h in enumerate(target.faulty) if h in placed.faulty]
        arriving = np.zeros(1 << len(shared), np.bool_)
        arriving[gathered(np.flatnonzero(exits), [source for _, source in shared])] = True
        return arriving[gathered(np.arange(1 << len(target.faulty)), [place for place, _ in shared])]

    @cached_property
    def ends(self) -> frozenset[Outcome]:
        """Ends of the mission that are reached."""
        return frozenset(
            ENDS[route]
            for name, reached in self.reached.items()
            for outcome in OUTCOMES
            if (route := self.route(name, outcome)) in ENDS
            and self.exits(self.by_name[name], outcome, reached).any()
        )

    # --- sizes ---

    @cached_property
    def states(self) -> int:
        """Number of stable states of the whole mission, exact."""
        count = len(self.faulty)
        inside = sum(
            int(reached.sum()) << count - len(self.by_name[name].faulty)
            for name, reached in self.reached.items()
        )
        return inside + (1 + len(self.ends) << count)

    @cached_property
    def edges(self) -> int:
        """Number of edges of the whole mission's alternatives graph, exact."""
        count = len(self.faulty)
        total = (1 + len(self.ends)) * count << count  # each resource fails or recovers before and after
        total += 1 << count  # the start
        for name, reached in self.reached.items():
            local, free = self.by_name[name].local, count - len(self.by_name[name].faulty)
            own = int(np.diff(local.graph.offsets)[reached].sum())
            total += (own << free) + (int(reached.sum()) * free << free)
        return total

    @cached_property
    def events(self) -> frozenset[str]:
        """Names of all events that happen in the mission."""
        found = {"MISSION_EV_START", *(f"{h}_EV_{change}" for h in self.faulty for change in ("OOS", "RD"))}
        for name, reached in self.reached.items():
            placed = self.by_name[name]
            graph, own = placed.local.graph, placed.renaming.objectives
            for label in np.unique(graph.labels[reached[graph.sources]]).tolist():
                transition = graph.net.transitions[label]
                origin = transition.provenance
                if transition.event and origin and origin.kind == "objective":
                    found.add(transition.event.replace(f"OBJ_{origin.name}_", f"OBJ_{own[origin.name]}_"))
        return frozenset(found)

    @cached_property
    def local_states(self) -> int:
        """States of all local graphs, each type once: what was explored."""
        return sum(local.graph.states for local in {id(p.local): p.local for p in self.sections}.values())

    # --- backward ---

    def leading_to(self, goals: Iterable[Outcome]) -> dict[str, Mask]:
        """By section, from which states of its local graph some run leads to an end of the mission.

        Whatever is out of service of the other hardware makes no difference: it can change before the section
        is left.

        Args:
            goals: The ends that will do.

        Returns:
            Shape (states,) each, for sections that are reached.
        """
        wanted = {route for route, end in ENDS.items() if end in set(goals)}
        good = {name: np.zeros(self.by_name[name].local.graph.states, np.bool_) for name in self.reached}
        before: dict[str, set[str]] = {}
        for name in self.reached:
            for outcome in OUTCOMES:
                before.setdefault(self.route(name, outcome), set()).add(name)
        waiting = deque(sorted(set[str]().union(*(before.get(route, set()) for route in wanted))))
        while waiting:
            name = waiting.popleft()
            wider = self._good_inside(name, wanted, good)
            if (wider & ~good[name]).any():
                good[name] = wider
                waiting.extend(sorted(before.get(name, set()) - set(waiting)))
        return {name: good[name] & reached for name, reached in self.reached.items()}

    def _good_inside(self, name: str, wanted: set[str], good: Mapping[str, Mask]) -> Mask:
        placed = self.by_name[name]
        local = placed.local
        graph = local.graph
        goal = np.zeros(graph.states, np.bool_)
        for outcome in OUTCOMES:
            edges, route = local.leaving[outcome], self.route(name, outcome)
            if route not in ENDS:
                fitting = self.welcomed(placed, self.by_name[route], good[route])
                edges = edges[fitting[local.out_of_service[graph.targets[edges]]]]
            elif route not in wanted:
                continue
            goal[graph.sources[edges]] = True
        return graph.reaching(goal, local.edges_inside)

    def welcomed(self, placed: PlacedSection, target: PlacedSection, good: Mask) -> Mask:
        """With which masks a section may end so that the next can be entered well, shape (masks,)."""
        entries = np.flatnonzero(good[target.local.entry])
        shared = [(i, placed.faulty.index(h)) for i, h in enumerate(target.faulty) if h in placed.faulty]
        fitting = np.zeros(1 << len(shared), np.bool_)
        fitting[gathered(entries, [place for place, _ in shared])] = True
        return fitting[gathered(np.arange(1 << len(placed.faulty)), [source for _, source in shared])]

    def losing(self, goals: Iterable[Outcome] = ("success",)) -> dict[str, Mask]:
        """By section, the reached states of its local graph from which no run leads to a goal."""
        good = self.leading_to(goals)
        return {name: reached & ~good[name] for name, reached in self.reached.items()}


def gathered(masks: Ints, bits: list[int]) -> Ints:
    """Some bits of masks, packed in the order given."""
    found = np.zeros(len(masks), np.int64)
    for position, bit in enumerate(bits):
        found |= (masks >> bit & 1) << position
    return found
