"""The objectives graph as a net (paper, 6.3 and Fig. 9), and how declared events interrupt it.

An event that interrupts an elementary objective is one more way out of it: like its failure it stops the
activities and enters what follows. One that interrupts a parallel block as a whole halts every branch: the
event's transition takes the place that says that the block runs, so that nothing begins in it any more, and
puts a token into each branch's place *halt*. Internal transitions then stop the objective that the branch is
in, drop one that is about to be entered, or take the branch's outcome; when all branches are halted, what
follows is entered. Branches that decide the block's end halt the others in the same way, one that aborts
among them (:mod:`mcpn.net.templates.leaving`). Of all handlers of an event those of the branches count first:
where some branch is at a place that handles the event itself, these branches do so together and the block
goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from math import prod

from mcpn.errors import LimitError
from mcpn.mission.flatten import (
    Branch,
    ElementarySection,
    Interruption,
    ObjectivesGraph,
    ParallelSection,
    Section,
)
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.net.events import START, Event, What
from mcpn.net.templates.activities import running_place
from mcpn.net.templates.canvas import Canvas, Pen
from mcpn.net.templates.interruption import Around, Position, called, draw_once, events_of, may_halt
from mcpn.net.templates.leaving import Leaving

MAX_POSITIONS = 10_000
"""Combinations of where the branches of a block may be that handle one event, each with a transition."""


def draw_control(canvas: Canvas, graph: ObjectivesGraph) -> None:
    """Draws the mission's start, its objectives and parallel blocks, and its ends.

    Args:
        canvas: Where to draw.
        graph: The objectives graph.
    """
    mission = canvas.usage.mission
    pen = canvas.of("mission", mission.name, mission.source)
    begin = pen.place("begin", initial=1)
    success = canvas.role(pen.place("success"), ("success", mission.name))
    failure = canvas.role(pen.place("failure"), ("failure", mission.name))
    exits = {SUCCEED: [success], FAIL: [failure]}
    if graph.aborts:
        exits[ABORT] = [canvas.role(pen.place("abort"), ("abort", mission.name))]
    known = {*exits, *(section.name for section in graph.sections)}
    for section in graph.sections:  # a part of a mission may be left in other ways
        for target in section.routes:
            if target not in known:
                known.add(target)
                place = canvas.of("exit", target, section.source).place("left")
                exits[target] = [canvas.role(place, ("exit", target))]
    for handler in graph.once():
        draw_once(canvas, pen, handler, begin)
    control = _Control(canvas, graph, exits)
    pen.transition("EV_START", [begin], control.enter(graph.entry), event=START)
    control.draw()


class _Control:
    """Draws one level of the objectives graph.

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
        around: Around | None = None,
    ) -> None:
        self.canvas = canvas
        self.graph = graph
        self.exits = exits
        self.around = around or Around()

    def draw(self) -> None:
        """Draws every section of the graph."""
        for section in self.graph.sections:
            if isinstance(section, ElementarySection):
                self.elementary(section)
            else:
                self.parallel(section)
            if not self.around.in_branch:
                self.interruptions(section)

    def inside(self, section: ParallelSection, branch: Branch) -> _Control:
        """Draws a branch of a section of this graph."""
        around = Around(in_branch=True, eventful=self.eventful(section))
        if self.halted(section):
            running = (*self.around.running, self.of(section, "running"))
            around = replace(around, running=running, halted=self.of_branch(branch, "halted"))
        well, badly = map(list, Leaving(self.canvas, section).ends(branch))
        exits = {SUCCEED: well, FAIL: badly}
        if branch.graph.aborts:
            exits[ABORT] = [self.of_branch(branch, "abort")]
        return _Control(self.canvas, branch.graph, exits, around)

    def eventful(self, section: Section) -> bool:
        """Whether a place must say that the block runs."""
        return self.around.eventful or any(events_of(section)) or may_halt(section)

    def halted(self, section: ParallelSection) -> bool:
        """Whether an event, or a branch that ends, may interrupt the block as a whole."""
        return bool(self.around.running or section.interruptions or section.early)

    def enter(self, target: str) -> list[str]:
        """Places to mark so as to enter a section, or to leave the graph."""
        if target in self.exits:
            return self.exits[target]
        section = self.graph.section(target)
        if self.gated(section):
            return [self.canvas.place_of(*_element(section), "enter")]
        return self.begin(section)

    def begin(self, section: Section) -> list[str]:
        """Places to mark so that a section begins at once."""
        if isinstance(section, ElementarySection):
            starts = self.of_activities(section.activities, "Start")
            return [self.canvas.place_of(*_element(section)), *starts]
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

    def gate(self, pen: Pen, section: Section) -> None:
        """The section's entry: it begins when nothing else is left to fire, and its activities are idle."""
        gate = pen.place("enter")
        own: tuple[str, ...] = ()
        if isinstance(section, ElementarySection):
            self.canvas.role(gate, ("pending", section.name))
            own = tuple(a for a in section.activities if a in self.canvas.usage.handover.with_idle)
        taken, read = self.of_activities(own, "idle"), list(self.around.running)
        rank = self.canvas.ranks.entering
        pen.transition("begin", [gate, *taken], self.begin(section), read=read, rank=rank)

    def of_activities(self, activities: Iterable[str], part: str) -> list[str]:
        """Of each of some activities the place that its template calls ``part``."""
        return [self.canvas.place_of("activity", a, part) for a in activities]

    def elementary(self, section: ElementarySection) -> None:
        """Each end stops the activities and enters what follows; OK only while all of them run."""
        usage, name = self.canvas.usage, section.name
        pen = self.canvas.of("objective", name, section.source)
        place = self.canvas.role(pen.place(), ("objective", name))
        if self.gated(section):
            self.gate(pen, section)
        stops = self.stops(section)
        running = [running_place(self.canvas, usage.activities[a]) for a in section.activities]
        for what, part, route, read in (
            (What.SUCCESS, "EV_OK", section.success, [p for p in running if p is not None]),
            (What.FAILURE, "EV_FAIL", section.failure, []),
            (What.TIMEOUT, "EV_TIMEOUT", section.timed_out, []),
        ):
            if route is None:
                continue
            after = [*stops, *self.enter(route)]
            pen.transition(part, [place], after, read=read, event=Event(what, name))

    def parallel(self, section: ParallelSection) -> None:
        """Each child marks that it is done; when all are, internal transitions leave the block."""
        pen = self.canvas.of("parallel", section.name, section.source)
        if self.gated(section):
            self.gate(pen, section)
        running = [pen.place("running")] if self.eventful(section) else []
        leaving = Leaving(self.canvas, section)
        for branch in section.branches:
            ended = [pen.place(part, of=("objective", branch.name)) for part in ("ok", "fail")]
            if (
                not leaving.combined
            ):  # outcomes are taken note of one by one: another place says that it has ended
                ended = [pen.place("ended", of=("objective", branch.name))]
            for place in ended:
                self.canvas.role(place, ("done", branch.name))
            if branch.graph.aborts:
                pen.place("abort", of=("objective", branch.name))
            self.inside(section, branch).draw()
        leaving.all_ended(pen, running, self.enter, self.halted(section))
        if self.halted(section):
            self.halt(pen, section)

    def of_branch(self, branch: Branch, part: str) -> str:
        """A place of a branch of a parallel block."""
        return self.canvas.place_of("objective", branch.name, part)

    def of(self, section: Section, *part: str) -> str:
        """A place of a section."""
        return self.canvas.place_of(*_element(section), *part)

    def stops(self, section: ElementarySection) -> list[str]:
        """Places to mark so that the activities of an objective stop."""
        return self.of_activities(section.activities, "Stop")

    # --- interruption ---

    def interruptions(self, section: Section) -> None:
        """One transition for each event and each position of the section's objectives that handles it."""
        pen = self.canvas.of(*_element(section), section.source)
        for name in dict.fromkeys(events_of(section)):
            event = Event(What.DECLARED, name)
            found = [p for p in self.positions(section, name) if p.put is not None]
            for number, position in enumerate(found, 1):
                read = [place for place in position.read if place not in position.take]
                read += self.of_handlers(position.happened, "happened")
                take = [*position.take, *self.of_handlers(position.once, "open")]
                put = [*(position.put or ()), *self.of_handlers(position.once, "happened")]
                pen.transition(f"EV{number}_{name}", take, put, read=read, event=event)

    def of_handlers(self, handlers: Iterable[str], part: str) -> list[str]:
        """Of each of some handlers that happen once the place that its template calls ``part``."""
        return [self.canvas.place_of("once", handler, part) for handler in handlers]

    def positions(self, section: Section, event: str) -> Iterator[Position]:
        """Where the objectives of a section may be when an event happens; one of these holds at a time."""

        def handled(place: str, put: Callable[[Interruption, int], Iterable[str]]) -> Iterator[Position]:
            for number, (own, before) in enumerate(section.handlers(event), 1):
                if own is None:
                    yield Position((place,), happened=before)
                else:
                    once = () if own.once is None else (own.once,)
                    yield Position((place,), (place,), tuple(put(own, number)), once, before)

        if self.around.in_branch and self.gated(section):
            yield from handled(self.of(section, "enter"), lambda own, _: self.enter(own.target))
        if isinstance(section, ElementarySection):
            stops = self.stops(section)
            yield from handled(self.of(section), lambda own, _: [*stops, *self.enter(own.target)])
            return
        halts = [self.of_branch(branch, "halt") for branch in section.branches]
        for inside in self.in_branches(section, event):
            if inside.put is not None:
                yield inside
                continue
            for whole in handled(
                self.of(section, "running"),
                lambda _, number: [self.of(section, called(event, number)), *halts],
            ):
                if (both := inside.beside(whole)).possible:
                    yield both

    def in_branches(self, section: ParallelSection, event: str) -> list[Position]:
        """Where those branches may be that handle an event somewhere."""
        handling = [
            list(self.inside(section, branch).in_branch(section, branch, event))
            for branch in section.branches
            if any(e == event for inner in branch.graph.sections for e in events_of(inner))
        ]
        positions_so_far = [Position(())]
        for number, positions in enumerate(handling, 1):
            both = (one.beside(other) for one in positions_so_far for other in positions)
            positions_so_far = [position for position in both if position.possible]
            if len(positions_so_far) > MAX_POSITIONS:
                count = len(positions_so_far) * prod(map(len, handling[number:]))
                message = (
                    f"parallel block {section.name}: {count} combinations of where its branches are when "
                )
                raise LimitError(f"{message}the event {event} happens, the limit is {MAX_POSITIONS}")
        return positions_so_far

    def in_branch(self, section: ParallelSection, branch: Branch, event: str) -> Iterator[Position]:
        """Positions of this graph, that of a branch of a section, its ends among them."""
        for inner in self.graph.sections:
            yield from self.positions(inner, event)
        for place in dict.fromkeys(end[-1] for end in Leaving(self.canvas, section).ends(branch)):
            yield Position((place,))

    def halt(self, pen: Pen, section: ParallelSection) -> None:
        """Halts every branch, wherever it is, then goes on to what the event, or the abort, leads to."""
        number = 0
        for branch in section.branches:
            halt = pen.place("halt", of=("objective", branch.name))
            pen.place("halted", of=("objective", branch.name))
            ways = self.inside(section, branch).halting(section, branch)
            for taken, put in ways:
                number += 1
                pen.transition(f"halt{number}", [halt, *taken], put, rank=self.first)
        all_halted = [self.of_branch(branch, "halted") for branch in section.branches]
        for number, interruption in section.numbered:
            place = pen.place(called(interruption.event, number))
            left = called(interruption.event, number, "left")
            pen.transition(left, [place, *all_halted], self.enter(interruption.target), rank=self.first)
        Leaving(self.canvas, section).decided(pen, self.of(section, "running"), self.enter, all_halted)
        if self.around.halted:
            place = pen.place("halting")
            pen.transition("halted", [place, *all_halted], [self.around.halted], rank=self.first)

    @property
    def first(self) -> int:
        """The rank of what goes on in control: before activities react, where something may abort."""
        return self.canvas.ranks.control

    def halting(self, section: ParallelSection, branch: Branch) -> Iterator[tuple[list[str], list[str]]]:
        """By position of this graph, that of a branch, the places that are taken and those that are put."""
        halted = self.of_branch(branch, "halted")
        for inner in self.graph.sections:
            if self.gated(inner):
                yield [self.of(inner, "enter")], [halted]
            if isinstance(inner, ElementarySection):
                yield [self.of(inner)], [*self.stops(inner), halted]
            else:
                yield (
                    [self.of(inner, "running")],
                    [self.of(inner, "halting"), *(self.of_branch(b, "halt") for b in inner.branches)],
                )
        for end in Leaving(self.canvas, section).ends(branch):
            yield list(end), [halted]
        if branch.graph.aborts:
            yield [self.of_branch(branch, "abort")], [halted]


def _element(section: Section) -> tuple[str, str]:
    return "objective" if isinstance(section, ElementarySection) else "parallel", section.name
