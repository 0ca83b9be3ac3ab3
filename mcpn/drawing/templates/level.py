"""One level of the objectives graph in the net: the places of its sections, and where its routes lead."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Self

from mcpn.drawing.templates.canvas import Canvas
from mcpn.drawing.templates.facts import FactArcs, ways
from mcpn.drawing.templates.interrupt_positions import Surroundings, events_of, may_halt
from mcpn.drawing.templates.leaving import Leaving
from mcpn.mission.core.objectives_graph import (
    Branch,
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    Section,
)
from mcpn.mission.core.routes import GO_ON
from mcpn.mission.fact_cases import FactCase
from mcpn.mission.model import ABORT, FAIL, SUCCEED


class Level:
    """A level of the objectives graph, that of the mission or of a branch.

    Args:
        canvas: Where to draw.
        graph: The mission's graph, or that of a branch of a parallel block.
        exits: Places to mark at the graph's own exits.
        around: What stands around it.
    """

    def __init__(
        self,
        canvas: Canvas,
        graph: ObjectivesGraph,
        exits: Mapping[str, list[str]],
        around: Surroundings | None = None,
    ) -> None:
        self.canvas = canvas
        self.graph = graph
        self.exits = exits
        self.around = around or Surroundings()
        self._inside: dict[tuple[str, str], Self] = {}
        self._meanwhile: dict[tuple[str, int], Self] = {}
        self._entered: dict[str, list[str]] = {}

    def inside(self, section: ParallelSection, branch: Branch) -> Self:
        """The level of a branch of a section of this graph; one for all who ask."""
        known = section.name, branch.name
        if known not in self._inside:
            self._inside[known] = self._inside_of(section, branch)
        return self._inside[known]

    def meanwhile(self, section: ParallelSection, number: int) -> Self:
        """The level of what runs while a block of this graph pauses; one for all who ask.

        Args:
            section: The block.
            number: That of the pause, from 1.
        """
        known = section.name, number
        if known not in self._meanwhile:
            pause_graph, running = section.pause_graphs[number - 1], self.active(section, number)
            exits = {
                exit_: [self.of(section, *exit_.split(), f"{number}")] for exit_, _ in section.pause_exits
            }
            exits[GO_ON] = [self.of(section, f"over{number}")]
            around = Surroundings(
                in_branch=True,
                eventful=True,
                running=(*self.around.running, running),
                halted=self.of(section, f"halted_meanwhile{number}"),
                pauses=self.around.pauses or any(i.pauses is not None for i in pause_graph.interruptions),
            )
            self._meanwhile[known] = type(self)(self.canvas, pause_graph.graph, exits, around)
        return self._meanwhile[known]

    def active(self, section: ParallelSection, phase: int) -> str:
        """The place that says that the branches of a block run (phase 0), or what runs as it pauses."""
        return self.of(section, f"meanwhile{phase}" if phase else "running")

    def _inside_of(self, section: ParallelSection, branch: Branch) -> Self:
        around = Surroundings(in_branch=True, eventful=self.eventful(section))
        if self.halted(section):
            running = (*self.around.running, self.of(section, "running"))
            pauses = self.around.pauses or bool(section.pause_graphs)
            halted = self.of_branch(branch, "halted")
            around = around._replace(running=running, halted=halted, pauses=pauses)
        well, badly = map(list, Leaving(self.canvas, section).ends(branch))
        exits = {SUCCEED: well, FAIL: badly}
        if branch.graph.aborts:
            exits[ABORT] = [self.of_branch(branch, "abort")]
        return type(self)(self.canvas, branch.graph, exits, around)

    def eventful(self, section: Section) -> bool:
        """Whether a place must say that the block runs."""
        return self.around.eventful or any(events_of(section)) or may_halt(section)

    def halted(self, section: ParallelSection) -> bool:
        """Whether an event, its time, facts, or a branch that ends, may interrupt the block as a whole."""
        return bool(self.around.running or section.interruptions or section.early or section.stopped)

    def enter(self, target: str) -> list[str]:
        """Places to mark so as to enter a section, or to leave the graph."""
        if target in self.exits:
            return self.exits[target]
        if target not in self._entered:
            self._entered[target] = self._entering(self.graph.section(target))
        return self._entered[target]

    def _entering(self, section: Section) -> list[str]:
        if self.around.in_branch and self.starting(section):
            return [self.of(section, "starts")]
        return self.come_to(section)

    @staticmethod
    def starting(section: Section) -> bool:
        """Whether the section is an objective that changes facts when it is entered.

        In a branch it does so before it waits at its gate, and before the branches beside it look. Elsewhere
        nothing runs beside: it does so behind its gate, when what stops before it has stopped, so that the
        run of the section before is over.
        """
        return isinstance(section, ElementarySection) and bool(section.setting("start"))

    def come_to(self, section: Section) -> list[str]:
        """Places to mark so that a section begins, or waits at its gate until it may."""
        if self.gated(section):
            return [self.of(section, "enter")]
        return self.begun(section) if self.around.in_branch else self.begin(section)

    def led(
        self, section: Section, outcome: str, changes: Mapping[str, str] | None = None
    ) -> Iterator[tuple[str, FactArcs, list[str]]]:
        """Where an outcome leads: a number, empty if there is one way alone, the way, places to mark."""
        (route,) = (route for said, route in section.outcomes if said == outcome)
        yield from self.ways(section, route, section.cases_of(outcome), changes or {})

    def ways(
        self, section: Section, route: str, cases: Sequence[FactCase], changes: Mapping[str, str]
    ) -> Iterator[tuple[str, FactArcs, list[str]]]:
        """Where a route of a section leads by facts, after some have changed."""
        leads = ways(self.canvas, route, cases, changes, f"{element_of(section)[0]} {section.name}")
        for number, way in enumerate(leads, 1):
            yield str(number) if len(leads) > 1 else "", way, self.enter(way.target)

    def begin(self, section: Section) -> list[str]:
        """Places to mark behind the gate of a section."""
        if not self.around.in_branch and self.starting(section):
            return [self.of(section, "starts")]
        return self.begun(section)

    def begun(self, section: Section) -> list[str]:
        """Places to mark so that a section begins at once."""
        if isinstance(section, ElementarySection):
            starts = self.of_activities(section.activities, "Start")
            return [self.canvas.place_of(*element_of(section)), *starts]
        inner = [self.inside(section, branch) for branch in section.branches]
        entered = [place for control in inner for place in control.enter(control.graph.entry)]
        return [self.of(section, "running"), *entered] if self.eventful(section) else entered

    def gated(self, section: Section) -> bool:
        """Whether the section waits at its entry until what stops has stopped, or its activities are idle."""
        handover = self.canvas.usage.handover
        if section.name in handover.gated:
            return True
        return isinstance(section, ElementarySection) and any(
            a in handover.with_idle for a in section.activities
        )

    def of_activities(self, activities: Iterable[str], part: str) -> list[str]:
        """Of each of some activities the place that its template calls ``part``."""
        return [self.canvas.place_of("activity", a, part) for a in activities]

    def of_branch(self, branch: Branch, part: str) -> str:
        """A place of a branch of a parallel block."""
        return self.canvas.place_of("objective", branch.name, part)

    def of(self, section: Section, *part: str) -> str:
        """A place of a section."""
        return self.canvas.place_of(*element_of(section), *part)

    def stops(self, section: ElementarySection) -> list[str]:
        """Places to mark so that the activities of an objective stop."""
        return self.of_activities(section.activities, "Stop")

    @property
    def first(self) -> int:
        """The rank of what goes on in control: before activities react, where something may abort."""
        return self.canvas.ranks.control


def element_of(section: Section) -> tuple[str, str]:
    """The kind and the name of a section."""
    return "objective" if isinstance(section, ElementarySection) else "parallel", section.name
