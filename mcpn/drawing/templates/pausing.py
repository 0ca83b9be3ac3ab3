"""The pauses of a block: phases that wait for what runs meanwhile, and go on or are given up after it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from mcpn.drawing.templates.canvas import Pen
from mcpn.drawing.templates.facts import ways
from mcpn.drawing.templates.halting import Halting
from mcpn.drawing.templates.interrupt_positions import called
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection


class Pausing:
    """Draws the pauses of a block, or those of what is around it.

    Args:
        level: Where the block stands.
        pen: The block's.
        section: The block.
    """

    def __init__(self, level: Halting, pen: Pen, section: ParallelSection) -> None:
        self.level = level
        self.pen = pen
        self.section = section
        self.waiting = [
            (phase, pauses + 1)
            for phase, interrupted in enumerate((section, *section.pause_graphs))
            for pauses in dict.fromkeys(i.pauses for i in interrupted.interruptions if i.pauses is not None)
        ]
        """Phases that pause, each with the phase that runs meanwhile."""

    def draw(self) -> None:
        """Draws all."""
        level, pen, section = self.level, self.pen, self.section
        dropped = pen.place("dropped")
        for phase in range(len(section.pause_graphs) + 1):
            if phase:
                level.each(pen, section, phase, "halt")
            if level.around.pauses or any(phase == before for before, _ in self.waiting):
                for word in ("pause", "resume", "drop"):
                    level.each(pen, section, phase, word)
                self.stopped(phase, dropped)
            if phase:
                self.meanwhile(phase)
        if level.around.halted:
            taken = [pen.place("then_halted"), dropped]
            pen.transition("gone_halted", taken, [level.around.halted], rank=level.first)
        for exit_, _ in section.pause_exits:
            place, left = pen.place(self.then(exit_)), f"gone_{exit_.replace(' ', '')}"
            for number, way, entered in level.led(section, exit_):
                part = f"{left}_{number}" if number else left
                pen.transition(part, [place, dropped], entered, read=way.read, rank=level.first)

    @staticmethod
    def then(exit_: str) -> str:
        """What is called after an outcome of what runs while the block pauses."""
        return f"then_{exit_.replace(' ', '')}"

    def stopped(self, phase: int, dropped: str) -> None:
        """What follows when a phase has been stopped, or given up."""
        level, pen, section, rank = self.level, self.pen, self.section, self.level.first
        all_halted = level.tokens(section, phase, "halted")
        inside = (inner for region in level.regions(section, phase) for inner in region.level.graph.sections)
        for inner in inside:
            if isinstance(inner, ElementarySection):
                pen.own(level.of(inner, "paused"))
        if level.around.pauses:
            pausing = pen.own(level.of_phase(section, phase, "pausing"))
            paused = pen.own(level.of_phase(section, phase, "paused"))
            pen.transition(f"paused{phase}", [pausing, *all_halted], [paused, level.around.halted], rank=rank)
        for before, after in self.waiting:
            if before == phase:
                begun = level.meanwhile(section, after)
                entered = [level.active(section, after), *begun.enter(begun.graph.entry)]
                pausing = pen.place(f"pausing{phase}for{after}")
                waiting = pen.place(f"waiting{phase}for{after}")
                part = f"paused{phase}for{after}"
                pen.transition(part, [pausing, *all_halted], [waiting, *entered], rank=rank)
        dropping = pen.own(level.of_phase(section, phase, "dropping"))
        if phase:
            self.back(f"drop{phase}", phase, [dropping, *all_halted], level.given_up)
        else:
            pen.transition("drop", [dropping, *all_halted], [dropped], rank=rank)

    def back(
        self,
        part: str,
        phase: int,
        taken: list[str],
        how: Callable[[ParallelSection, int], list[str]],
        put: Iterable[str] = (),
        read: list[str] | None = None,
    ) -> None:
        """What follows the end of a phase: that before it, which waits for it, goes on or is given up."""
        for before, after in self.waiting:
            if after == phase:
                waiting = self.level.of(self.section, f"waiting{before}for{phase}")
                follows, name = [*how(self.section, before), *put], f"{part}_back{before}"
                self.pen.transition(name, [*taken, waiting], follows, read=read, rank=self.level.first)

    def meanwhile(self, phase: int) -> None:
        """What runs while the block pauses, and how it ends."""
        level, pen, section = self.level, self.pen, self.section
        pause_graph, then = section.pause_graphs[phase - 1], partial(level.of, section)
        running = pen.place(f"meanwhile{phase}")
        halted = level.tokens(section, phase, "halted")
        self.back(f"over{phase}", phase, [pen.place(f"over{phase}"), running], level.going_on)
        for exit_, _ in section.pause_exits:
            (place,) = level.meanwhile(section, phase).exits[exit_]
            taken, put = [pen.own(place), running], [then(self.then(exit_))]
            self.back(f"{exit_.replace(' ', '')}of{phase}", phase, taken, level.given_up, put)
        for number, i in pause_graph.numbered:
            if i.pauses is None:
                place = pen.place(called(i.event, number, f"meanwhile{phase}"))
                what = f"parallel {section.name}"
                for case, way in enumerate(ways(level.canvas, i.target, i.cases, {}, what), 1):
                    part = called(i.event, number, f"left{phase}case{case}")
                    put = [then(self.then(way.target))]
                    self.back(part, phase, [place, *halted], level.given_up, put, way.read)
        if level.around.halted:
            place, put = pen.own(level.of_phase(section, phase, "halting")), [then("then_halted")]
            self.back(f"halted{phase}", phase, [place, *halted], level.given_up, put)
