"""The objectives graph as a net (paper, 6.3 and Fig. 9)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from functools import partial

from mcpn.drawing.templates.activities import running_place
from mcpn.drawing.templates.canvas import Alike, Canvas, Pen
from mcpn.drawing.templates.copied import Copying
from mcpn.drawing.templates.facts import draw_facts
from mcpn.drawing.templates.interrupt_net import Interrupting
from mcpn.drawing.templates.interrupt_positions import draw_once
from mcpn.drawing.templates.leaving import Leaving
from mcpn.drawing.templates.stencil import NotCopied, Stencil
from mcpn.events import START, Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT


def draw_control(canvas: Canvas, graph: ObjectivesGraph) -> None:
    """Draws the mission's start, its objectives and parallel blocks, and its ends.

    Args:
        canvas: Where to draw.
        graph: The objectives graph.
    """
    mission = canvas.usage.core
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
        draw_once(canvas, handler)
    draw_facts(canvas)
    _draw_asking(canvas, pen)
    for resting in canvas.resting:
        pen.transition("rested", [pen.own(resting)], [], rank=canvas.ranks.rested)
    control = _Control(canvas, graph, exits)
    pen.transition("EV_START", [begin], control.enter(graph.entry), event=START)
    if canvas.alike is None:
        control.draw()
    else:
        _draw_by_type(control, canvas.alike)


def _draw_by_type(control: _Control, alike: Alike) -> None:
    """Draws what is no copy, and notes which sections are copies of which."""
    canvas, sections = control.canvas, control.graph.sections
    routes = {section.name: list(dict.fromkeys(section.routes)) for section in sections}
    kinds: dict[str, Hashable] = {}
    for section in sections:
        where = tuple(routes[section.name].index(route) for route in section.routes)
        kinds[section.name] = alike(section), where
    count, stencils = Counter(kinds.values()), dict[Hashable, Stencil | None]()
    for section in sections:
        if (kind := kinds[section.name]) not in stencils:
            stencils[kind] = _stencil(canvas, section, routes[section.name]) if count[kind] > 1 else None
    copied = {section.name for section in sections if stencils[kinds[section.name]] is not None}
    if not copied:
        control.draw()
        return
    copying, led = Copying(canvas), {control.graph.entry: None}
    for section in sections:
        if (stencil := stencils[kinds[section.name]]) is None:
            control.draw_section(section)
            led |= dict.fromkeys(routes[section.name])
        else:
            copying.copy(stencil, section)
            led |= dict.fromkeys(route for route in routes[section.name] if route not in copied)
    for route in led:
        copying.led(route, control.enter(route))
    canvas.finish = copying.finish


def _stencil(canvas: Canvas, section: Section, routes: Sequence[str]) -> Stencil | None:
    """What is drawn of a section; ``None`` where it cannot be copied."""
    marks, blank = {route: f"\0{number}" for number, route in enumerate(routes)}, canvas.blank()
    alone = ObjectivesGraph((section,), section.name)
    control = _Control(blank, alone, {route: [mark] for route, mark in marks.items()})
    control.draw()
    # A section may lead to itself: it is entered as it is where others lead to it.
    entered = _Control(blank, alone, {}).enter(section.name)
    try:
        return Stencil(blank, section, list(marks.values()), entered)
    except NotCopied:
        return None


def _draw_asking(canvas: Canvas, pen: Pen) -> None:
    """Draws when facts are asked what is left as they have become so: once in each reaction."""
    said = [(fact.name, value) for fact in canvas.facts for value in fact.values]
    if watched := [each for each in said if each in canvas.usage.world.watched]:
        ranks, asking = canvas.ranks, pen.own(canvas.asking)
        unasked, asked = pen.place("unasked", initial=1), pen.place("asked")
        for number, (name, value) in enumerate(watched):
            read, rank = [canvas.became(name, value)], ranks.asking + number
            pen.transition(("ask", name, value), [unasked], [asking], read=read, rank=rank)
        pen.transition("asked", [asking], [asked], rank=ranks.asked)
        pen.transition("forgotten", [asked], [unasked], rank=ranks.forgotten)


class _Control(Interrupting):
    """Draws one level of the objectives graph."""

    def draw(self) -> None:
        """Draws every section of the graph."""
        for section in self.graph.sections:
            self.draw_section(section)

    def draw_section(self, section: Section) -> None:
        """Draws one of them."""
        if isinstance(section, ElementarySection):
            self.elementary(section)
        else:
            self.parallel(section)
        if not self.around.in_branch:
            self.interruptions(section)

    def gate(self, pen: Pen, section: Section) -> None:
        """The section's entry: it begins when nothing else is left to fire, and its activities are idle."""
        gate = pen.place("enter")
        own: tuple[str, ...] = ()
        if isinstance(section, ElementarySection):
            self.canvas.role(gate, ("pending", section.name))
            own = tuple(a for a in section.activities if a in self.canvas.usage.handover.with_idle)
        taken, read = self.of_activities(own, "idle"), list(self.around.running)
        ranks = self.canvas.ranks
        rank = ranks.entering_branches if self.around.in_branch else ranks.entering
        pen.transition("begin", [gate, *taken], self.begin(section), read=read, rank=rank)

    def elementary(self, section: ElementarySection) -> None:
        """Each end stops the activities and enters what follows; OK only while all of them run."""
        usage, name = self.canvas.usage, section.name
        pen = self.canvas.of("objective", name, section.source)
        place = self.canvas.role(pen.place(), ("objective", name))
        if self.gated(section):
            self.gate(pen, section)
        if changes := section.setting("start"):
            starts, rank = pen.place("starts"), self.canvas.ranks.starting(name)
            for number, way, _ in self.ways(section, section.success, (), changes):
                onward = self.come_to(section) if self.around.in_branch else self.begun(section)
                begun = [*way.produce, *onward]
                pen.transition(f"start{number}", [starts, *way.consume], begun, read=way.read, rank=rank)
        stops = self.stops(section)
        running = [running_place(self.canvas, usage.activities[a]) for a in section.activities]
        for event, part, outcome, read in (
            (Event(What.SUCCESS, name), "EV_OK", "success", [p for p in running if p is not None]),
            *((Event(What.FAILURE, name, why), "EV_FAIL", to, []) for why, to in section.failures),
            (Event(What.TIMEOUT, name), "EV_TIMEOUT", TIMED_OUT, []),
        ):
            if (outcome, section.timed_out) == (TIMED_OUT, None):
                continue
            for number, way, entered in self.led(section, outcome, section.setting(outcome)):
                after = [*stops, *entered, *way.produce, *self.canvas.resting]
                asked, called = [*read, *way.read], "_".join(filter(None, (f"{part}{number}", event.reason)))
                pen.transition(called, [place, *way.consume], after, read=asked, event=event)
        for outcome, word, so, rank in self.becoming(section):
            for number, way, entered in self.led(section, outcome):
                called, asked = f"{word}_{number}" if number else word, list(dict.fromkeys((*so, *way.read)))
                pen.transition(called, [place], [*stops, *entered], read=asked, rank=rank)

    def parallel(self, section: ParallelSection) -> None:
        """Each child marks that it is done; when all are, internal transitions leave the block."""
        pen = self.canvas.of("parallel", section.name, section.source)
        if self.gated(section):
            self.gate(pen, section)
        running = [pen.place("running")] if self.eventful(section) else []
        leaving = Leaving(self.canvas, section)
        for branch in section.branches:
            ended = [pen.place(part, element=("objective", branch.name)) for part in ("ok", "fail")]
            # Else outcomes are taken note of one by one, and another place says that it has ended.
            if not leaving.combined:
                ended = [pen.place("ended", element=("objective", branch.name))]
            for place in ended:
                self.canvas.role(place, ("done", branch.name))
            if branch.graph.aborts:
                pen.place("abort", element=("objective", branch.name))
            self.inside(section, branch).draw()
        for number in range(1, len(section.pause_graphs) + 1):
            self.meanwhile(section, number).draw()
        leaving.all_ended(pen, running, partial(self.led, section), self.halted(section))
        if self.halted(section):
            self.halt(pen, section)
