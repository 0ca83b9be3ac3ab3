"""The composite: local spaces glued at their interface states, in place of the graph of the whole mission.

A state of the whole is a section, a state of its local space, and which of the *other* hardware is out of
service. That other hardware evolves freely beside the section: from any of its states any other is reached by
events of its own, so it is a factor of two for each resource, and never enumerated. Sizes are sums over
sections of such products, exact at any size.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.mission.usage import Usage
from mcpn.net.events import START, Event, What
from mcpn.space.local.interface import HardwareStates
from mcpn.space.local.junction import Junction
from mcpn.space.local.placing import PlacedSection
from mcpn.space.local.protocol import OUTCOMES, Outcome, TornHere

ENDS: Mapping[str, Outcome] = {SUCCEED: "success", FAIL: "failure"}


class Tear(NamedTuple):
    """Where a mission comes to what is not confluent or need not end.

    Attributes:
        section: The section in which it is.
        onward: The section into which the event leads, where it is of the junction of both.
        here: The state and the event.
    """

    section: PlacedSection
    onward: PlacedSection | None
    here: TornHere


@dataclass(frozen=True, eq=False)
class Composite:
    """A mission as its sections' local spaces.

    Args:
        usage: Static facts of the mission.
        graph: Its objectives graph.
        sections: Every section with its local space.
        junctions: Those that are not confluent for all states of their hardware.
    """

    usage: Usage
    graph: ObjectivesGraph
    sections: tuple[PlacedSection, ...]
    junctions: tuple[Junction, ...] = ()
    _leading: dict[frozenset[Outcome], dict[str, Any]] = field(default_factory=dict)

    @cached_property
    def by_name(self) -> dict[str, PlacedSection]:
        """Sections by name."""
        return {placed.section.name: placed for placed in self.sections}

    @property
    def first(self) -> PlacedSection:
        """The section that the mission begins with."""
        return self.by_name[self.graph.entry]

    @cached_property
    def faulty(self) -> tuple[str, ...]:
        """All hardware of the mission that can fail, in document order."""
        return self.first.space.names

    def route(self, name: str, outcome: Outcome) -> str:
        """Where a section leads: another's name, or one of the mission's ends."""
        section = self.by_name[name].section
        return section.success if outcome == "success" else section.failure

    # --- forward ---

    @cached_property
    def entered(self) -> dict[str, HardwareStates]:
        """By section that the mission comes to, with which states of its hardware."""
        found = {self.graph.entry: self.first.frame.everything}
        waiting = deque([self.graph.entry])
        while waiting:
            name = waiting.popleft()
            reached = self._reached_from(name, found[name])
            for outcome in OUTCOMES:
                target = self.route(name, outcome)
                if target in ENDS:
                    continue
                # Hardware that only the next one uses has been free, so it comes in both states.
                arriving = self.by_name[name].exits(outcome, reached).seen_by(self.by_name[target].frame)
                known = found.get(target, self.by_name[target].frame.nothing)
                if arriving - known:
                    found[target] = known | arriving
                    if target not in waiting:
                        waiting.append(target)
        return found

    def _reached_from(self, name: str, entered: HardwareStates) -> Any:
        placed = self.by_name[name]
        return placed.local.reached(placed.entered(entered))

    @cached_property
    def reached(self) -> dict[str, Any]:
        """By section that the mission comes to, which states of its local space."""
        return {name: self._reached_from(name, entered) for name, entered in self.entered.items()}

    @cached_property
    def ends(self) -> frozenset[Outcome]:
        """Ends of the mission that are reached."""
        return frozenset(
            ENDS[route]
            for name, reached in self.reached.items()
            for outcome in OUTCOMES
            if (route := self.route(name, outcome)) in ENDS and self.by_name[name].exits(outcome, reached)
        )

    def torn(self) -> Iterator[Tear]:
        """Where the mission comes to what is not confluent or need not end.

        States beyond such an event are not reached here, so that nothing else is told of a mission with one.
        """
        for name, reached in self.reached.items():
            placed = self.by_name[name]
            before = placed.local.with_hardware(placed.local.before, self.entered[name])
            for here in placed.local.torn(reached, before):
                yield Tear(placed, None, here)
        for junction in self.junctions:
            reached = self.reached.get(junction.first.section.name)
            if reached is not None:
                for here in junction.torn(reached):
                    yield Tear(junction.first, junction.second, here)

    @cached_property
    def tear(self) -> Tear | None:
        """The first of them, or ``None`` where all that the mission comes to is confluent and ends."""
        return next(self.torn(), None)

    # --- sizes ---

    @cached_property
    def states(self) -> int:
        """Number of stable states of the whole mission, exact."""
        count = len(self.faulty)
        inside: int = sum(
            reached.count() << count - len(self.by_name[name].faulty)
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
            total += (local.edges(reached) << free) + (reached.count() * free << free)
        return total

    @cached_property
    def events(self) -> frozenset[Event]:
        """All events that happen in the mission."""
        found = {
            START,
            *(Event(what, h) for h in self.faulty for what in (What.OUT_OF_SERVICE, What.REPAIRED)),
        }
        for name, reached in self.reached.items():
            placed = self.by_name[name]
            own = placed.renaming.objectives
            for label in placed.local.fired(reached):
                event = placed.local.net.net.transitions[label].event
                if event and event.what in (What.SUCCESS, What.FAILURE):
                    found.add(Event(event.what, own[event.element]))
        return frozenset(found)

    @cached_property
    def local_states(self) -> int:
        """States of all local spaces, each type once: what was explored."""
        return sum(local.size for local in {id(p.local): p.local for p in self.sections}.values())

    # --- backward ---

    def hopeful(self, goals: Iterable[Outcome]) -> dict[str, HardwareStates]:
        """By section that the mission comes to, entered with which hardware some run leads to an end.

        Whatever is out of service of the other hardware makes no difference: it can change before the section
        is left.

        Args:
            goals: The ends that will do.
        """
        wanted = frozenset(goals)
        found = {name: self.by_name[name].frame.nothing for name in self.reached}
        before: dict[str, set[str]] = {}
        for name in self.reached:
            for outcome in OUTCOMES:
                before.setdefault(self.route(name, outcome), set()).add(name)
        into_ends = [before.get(route, set()) for route, end in ENDS.items() if end in wanted]
        waiting = deque(sorted(set[str]().union(*into_ends)))
        queued = set(waiting)
        while waiting:
            name = waiting.popleft()
            queued.remove(name)
            wider = self.by_name[name].entries(self._leading_on(name, wanted, found))
            if wider - found[name]:
                found[name] |= wider
                waiting.extend(sorted(before.get(name, set()) - queued))
                queued |= before.get(name, set())
        return found

    def leading_to(self, goals: Iterable[Outcome]) -> dict[str, Any]:
        """By section that the mission comes to, states reached from which some run leads to an end.

        Args:
            goals: The ends that will do.
        """
        wanted = frozenset(goals)
        if wanted not in self._leading:
            hopeful = self.hopeful(wanted)
            self._leading[wanted] = {
                name: self._leading_on(name, wanted, hopeful) & reached
                for name, reached in self.reached.items()
            }
        return self._leading[wanted]

    def _leading_on(
        self, name: str, wanted: frozenset[Outcome], hopeful: Mapping[str, HardwareStates]
    ) -> Any:
        """States inside a section from which runs lead to a wanted end, or to a hopeful entry."""
        placed = self.by_name[name]
        ends: dict[Outcome, HardwareStates] = {}
        for outcome in OUTCOMES:
            route = self.route(name, outcome)
            if route not in ENDS:
                ends[outcome] = (
                    hopeful[route].seen_by(placed.frame) if route in hopeful else placed.frame.nothing
                )
            elif ENDS[route] in wanted:
                ends[outcome] = placed.frame.everything
        return placed.local.reaching(placed.ending(ends))

    def losing(self, goals: Iterable[Outcome] = ("success",)) -> dict[str, Any]:
        """By section, the reached states of its local space from which no run leads to a goal."""
        good = self.leading_to(goals)
        return {name: reached - good[name] for name, reached in self.reached.items()}
