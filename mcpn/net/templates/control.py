"""The objectives graph as a net (paper, 6.3 and Fig. 9)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import product

from mcpn.mission.flatten import Branch, ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.handover import Awaited
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.events import START, Event, What
from mcpn.net.templates.activities import running_place
from mcpn.net.templates.canvas import Canvas, Pen

MAX_COMBINED = 6
"""Children of a parallel block up to which each combination of outcomes has a transition of its own."""


def draw_control(canvas: Canvas, graph: ObjectivesGraph) -> None:
    """Draws the mission's start, its objectives and parallel blocks, and its two ends.

    Args:
        canvas: Where to draw.
        graph: The objectives graph.
    """
    mission = canvas.usage.mission
    pen = canvas.of("mission", mission.name, mission.source)
    begin = pen.place("begin", initial=1)
    success = canvas.role(pen.place("success"), ("success", mission.name))
    failure = canvas.role(pen.place("failure"), ("failure", mission.name))
    control = _Control(canvas, graph, {SUCCEED: [success], FAIL: [failure]})
    pen.transition("EV_START", [begin], control.enter(graph.entry), event=START)
    control.draw()


class _Control:
    """Draws one level of the objectives graph.

    Args:
        canvas: Where to draw.
        graph: The mission's graph, or that of a branch of a parallel block.
        exits: Places to mark at the graph's own exits.
    """

    def __init__(self, canvas: Canvas, graph: ObjectivesGraph, exits: Mapping[str, list[str]]) -> None:
        self.canvas = canvas
        self.graph = graph
        self.exits = exits

    def draw(self) -> None:
        """Draws every section of the graph."""
        for section in self.graph.sections:
            if isinstance(section, ElementarySection):
                self.elementary(section)
            else:
                self.parallel(section)

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
        inner = [_Control(self.canvas, branch.graph, {}) for branch in section.branches]
        return [place for control in inner for place in control.enter(control.graph.entry)]

    def gated(self, section: Section) -> bool:
        """Whether the section must wait at its entry until activities are idle and resources are back."""
        handover = self.canvas.usage.handover
        if section.name in handover.awaited:
            return True
        return isinstance(section, ElementarySection) and any(
            a in handover.with_idle for a in section.activities
        )

    def gate(self, pen: Pen, section: Section) -> None:
        """The section's entry: it begins when all that it waits for is over."""
        gate = pen.place("enter")
        handover, left_out = self.canvas.usage.handover, self.canvas.left_out
        awaited = handover.awaited.get(section.name, Awaited())
        own: tuple[str, ...] = ()
        if isinstance(section, ElementarySection):
            self.canvas.role(gate, ("pending", section.name))
            own = tuple(a for a in section.activities if a in handover.with_idle)
        others = [a for a in awaited.activities if a not in own and ("activity", a) not in left_out]
        back = [
            self.canvas.resource(s, "available", owner)
            for s, owner in awaited.interfaces
            if ("software", s) not in left_out and ("activity", owner) not in left_out
        ]
        taken, idle = self.of_activities(own, "idle"), self.of_activities(others, "idle")
        pen.transition("begin", [gate, *taken], self.begin(section), read=[*idle, *back])

    def of_activities(self, activities: Iterable[str], part: str) -> list[str]:
        """The same place of each of some activities."""
        return [self.canvas.place_of("activity", a, part) for a in activities]

    def elementary(self, section: ElementarySection) -> None:
        """OK and FAIL stop the activities and enter what follows; OK only while all of them run."""
        usage, name = self.canvas.usage, section.name
        pen = self.canvas.of("objective", name, section.source)
        place = self.canvas.role(pen.place(), ("objective", name))
        if self.gated(section):
            self.gate(pen, section)
        stops = self.of_activities(section.activities, "Stop")
        running = [running_place(self.canvas, usage.activities[a]) for a in section.activities]
        for what, part, route, read in (
            (What.SUCCESS, "EV_OK", section.success, [p for p in running if p is not None]),
            (What.FAILURE, "EV_FAIL", section.failure, []),
        ):
            after = [*stops, *self.enter(route)]
            pen.transition(part, [place], after, read=read, event=Event(what, name))

    def parallel(self, section: ParallelSection) -> None:
        """Each child marks that it is done; when all are, internal transitions leave the block."""
        pen = self.canvas.of("parallel", section.name, section.source)
        if self.gated(section):
            self.gate(pen, section)
        combined = len(section.branches) <= MAX_COMBINED
        for branch in section.branches:
            ended = [pen.place(part, of=("objective", branch.name)) for part in ("ok", "fail")]
            if combined:
                ends = [[place] for place in ended]
            else:  # the outcome is taken note of at once, so another place says that the branch has ended
                outcomes, ended = ended, [pen.place("ended", of=("objective", branch.name))]
                ends = [[place, *ended] for place in outcomes]
            for place in ended:
                self.canvas.role(place, ("done", branch.name))
            _Control(self.canvas, branch.graph, dict(zip((SUCCEED, FAIL), ends, strict=True))).draw()
        if combined:
            self.leave_combined(pen, section)
        else:
            self.leave_one_by_one(pen, section)

    def leave_combined(self, pen: Pen, section: ParallelSection) -> None:
        """One transition per combination of outcomes; success if every mandatory child succeeded (4.2)."""
        for outcome in product((True, False), repeat=len(section.branches)):
            done = [self.done(branch, ok) for branch, ok in zip(section.branches, outcome, strict=True)]
            succeeded = all(
                ok or not branch.mandatory for branch, ok in zip(section.branches, outcome, strict=True)
            )
            digits = "".join("0" if ok else "1" for ok in outcome)
            route = section.success if succeeded else section.failure
            pen.transition(f"exit_{digits}", done, self.enter(route))

    def leave_one_by_one(self, pen: Pen, section: ParallelSection) -> None:
        """The same outcome for wide blocks, in linear size: children are taken note of in document order."""
        well, lost = [], []
        for number in range(1, len(section.branches)):
            well.append([pen.place(f"ok{number}")])
            lost.append([pen.place(f"fail{number}")])
        well = [[], *well, self.enter(section.success)]
        lost = [[], *lost, self.enter(section.failure)]
        for i, branch in enumerate(section.branches):
            name = f"note{i + 1}"
            after_failure = lost[i + 1] if branch.mandatory else well[i + 1]
            last = i == len(section.branches) - 1
            ended = [self.of_branch(b, "ended") for b in section.branches] if last else []
            pen.transition(f"{name}_0", [*well[i], self.done(branch, True), *ended], well[i + 1])
            pen.transition(f"{name}_1", [*well[i], self.done(branch, False), *ended], after_failure)
            if i:
                pen.transition(f"{name}_2", [*lost[i], self.done(branch, True), *ended], lost[i + 1])
                pen.transition(f"{name}_3", [*lost[i], self.done(branch, False), *ended], lost[i + 1])

    def done(self, branch: Branch, ok: bool) -> str:
        """The place that says that a branch has ended so."""
        return self.of_branch(branch, "ok" if ok else "fail")

    def of_branch(self, branch: Branch, part: str) -> str:
        """A place of a branch of a parallel block."""
        return self.canvas.place_of("objective", branch.name, part)


def _element(section: Section) -> tuple[str, str]:
    return "objective" if isinstance(section, ElementarySection) else "parallel", section.name
