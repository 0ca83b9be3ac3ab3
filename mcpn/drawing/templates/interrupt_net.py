"""What interrupts sections of the objectives graph, and halts parallel blocks.

An event that interrupts an elementary objective is one more way out of it: like its failure it stops the
activities and enters what follows. One that interrupts a parallel block as a whole halts every branch: the
event's transition takes the place that says that the block runs, so that nothing begins in it any more, and
puts a token into each branch's place *halt*. Internal transitions then stop the objective that the branch is
in, drop one that is about to be entered, or take the branch's outcome; when all branches are halted, what
follows is entered. Where the block pauses, the places are called *pause*, and each branch notes in a place
*paused* where it goes on; when all are halted, what runs meanwhile is entered. It is a further *phase* of the
block, in which the branches stay where they are. By its success they are *resumed*; where it leads elsewhere,
they are *dropped*, and then that is entered. What runs meanwhile may be halted or pause itself. Branches that
decide the block's end halt the others in the same way, one that aborts among them
(:mod:`mcpn.drawing.templates.leaving`). Of all handlers of an event those of the branches count first: where
some branch is at a place that handles the event itself, these branches do so together and the block goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from math import prod
from typing import TypeAlias

from mcpn.drawing.templates.canvas import Pen
from mcpn.drawing.templates.facts import FactArcs
from mcpn.drawing.templates.halting import Halting
from mcpn.drawing.templates.interrupt_positions import Position, called, events_of
from mcpn.drawing.templates.leaving import Leaving
from mcpn.drawing.templates.level import element_of
from mcpn.drawing.templates.pausing import Pausing
from mcpn.errors import LimitError
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection, Section
from mcpn.mission.core.routes import Interrupted, Interruption
from mcpn.mission.model import TIMED_OUT

MAX_POSITIONS = 10_000
"""Combinations of where the branches of a block may be that handle one event, each with a transition."""

_Ways: TypeAlias = Iterable[tuple[list[str], Iterable[str]]]
"""For each combination of values of facts: the places that say so, and the places to mark."""


class Interrupting(Halting):
    """Draws what interrupts the sections of one level."""

    def interruptions(self, section: Section) -> None:
        """One transition for each event and each position of the section's objectives that handles it."""
        pen = self.canvas.of(*element_of(section), section.source)
        for name in dict.fromkeys(events_of(section)):
            event = Event(What.DECLARED, name)
            handled = [p for p in self.positions(section, name) if p.put is not None]
            for number, position in enumerate(handled, 1):
                read = [place for place in dict.fromkeys(position.read) if place not in position.take]
                read += self.of_handlers(position.happened, "happened")
                take = [*position.take, *self.of_handlers(position.once, "open")]
                happened = self.of_handlers(position.once, "happened")
                put = [*(position.put or ()), *happened, *self.canvas.resting]
                pen.transition(f"EV{number}_{name}", take, put, read=read, event=event)

    def of_handlers(self, handlers: Iterable[str], part: str) -> list[str]:
        """Of each of some handlers that happen once the place that its template calls ``part``."""
        return [self.canvas.place_of("once", handler, part) for handler in handlers]

    def positions(self, section: Section, event: str) -> Iterator[Position]:
        """Where the objectives of a section may be when an event happens; one of these holds at a time."""

        def handled(
            place: str, put: Callable[[Interruption, int], _Ways], interrupted: Interrupted = section
        ) -> Iterator[Position]:
            for number, (own, before) in enumerate(interrupted.handlers(event), 1):
                if own is None:
                    yield Position((place,), happened=before)
                    continue
                once = () if own.once is None else (own.once,)
                for facts, after in put(own, number):
                    yield Position((place, *facts), (place,), tuple(after), once, before)

        def left(own: Interruption) -> Iterator[tuple[list[str], list[str]]]:
            if own.pauses is not None:  # of a parallel block, which no stable marking finds at its gate
                return iter(())
            return ((way.read, places) for _, way, places in self.ways(section, own.target, own.cases, {}))

        if self.around.in_branch and self.gated(section):
            yield from handled(self.of(section, "enter"), lambda own, _: left(own))
        if isinstance(section, ElementarySection):
            stops = self.stops(section)

            def onward(own: Interruption, _: int) -> _Ways:
                return ((facts, [*stops, *places]) for facts, places in left(own))

            yield from handled(self.of(section), onward)
            return
        for phase, interrupted in enumerate((section, *section.pause_graphs)):

            def whole(own: Interruption, number: int, phase: int = phase) -> _Ways:
                return [([], self.stopping(section, phase, own, number))]

            for inside in self.in_regions(section, phase, event):
                if inside.put is not None:
                    yield inside
                    continue
                for outer in handled(self.active(section, phase), whole, interrupted):
                    if self.possible(both := inside.together_with(outer)):
                        yield both

    def in_regions(self, section: ParallelSection, phase: int, event: str) -> list[Position]:
        """Where those branches, or what runs while a block pauses, may be that handle an event somewhere."""
        handling = [
            [*region.level.every_position(event), *(Position((end,)) for end in region.ended)]
            for region in self.regions(section, phase)
            if any(e == event for inner in region.level.graph.sections for e in events_of(inner))
        ]
        positions_so_far = [Position(())]
        for number, positions in enumerate(handling, 1):
            both = (one.together_with(other) for one in positions_so_far for other in positions)
            positions_so_far = [position for position in both if self.possible(position)]
            if len(positions_so_far) > MAX_POSITIONS:
                count = len(positions_so_far) * prod(map(len, handling[number:]))
                message = (
                    f"parallel block {section.name}: {count} combinations of where its branches are when "
                )
                raise LimitError(f"{message}the event {event} happens, the limit is {MAX_POSITIONS}")
        return positions_so_far

    def possible(self, position: Position) -> bool:
        """Whether a marking may be so: no handler is both open and happened, and no fact has two values."""
        if not position.possible:
            return False
        roles = (self.canvas.roles.get(place, ("", "")) for place in {*position.read})
        values = [name.partition("=")[0] for kind, name in roles if kind == "fact"]
        return len(set(values)) == len(values)

    def every_position(self, event: str) -> Iterator[Position]:
        """Positions of this graph."""
        for inner in self.graph.sections:
            yield from self.positions(inner, event)

    def stopping(self, section: ParallelSection, phase: int, own: Interruption, number: int) -> list[str]:
        """The places that an event marks which interrupts a block as a whole."""
        if own.pauses is not None:
            pausing = self.of(section, f"pausing{phase}for{own.pauses + 1}")
            return [pausing, *self.tokens(section, phase, "pause")]
        word = f"meanwhile{phase}" if phase else "on"
        return [self.of(section, called(own.event, number, word)), *self.tokens(section, phase, "halt")]

    def halt(self, pen: Pen, section: ParallelSection) -> None:
        """Halts every branch, wherever it is, then goes on to what the event, or the abort, leads to."""
        self.each(pen, section, 0, "halt")
        all_halted = self.tokens(section, 0, "halted")
        for number, interruption in section.numbered:
            if interruption.pauses is not None:
                continue
            place = pen.place(called(interruption.event, number))
            left = called(interruption.event, number, "left")
            leading = self.ways(section, interruption.target, interruption.cases, {})
            self.onward(pen, left, [place, *all_halted], leading)
        if section.timed_out is not None:
            self.timed_out(pen, section, all_halted)
        self.left_by_facts(pen, section, all_halted)
        leaving = Leaving(self.canvas, section)
        leaving.decided(pen, self.of(section, "running"), partial(self.led, section), all_halted)
        if self.around.halted:
            place = pen.place("halting")
            pen.transition("halted", [place, *all_halted], [self.around.halted], rank=self.first)
        if section.pause_graphs or self.around.pauses:
            Pausing(self, pen, section).draw()

    def timed_out(self, pen: Pen, section: ParallelSection, all_halted: list[str]) -> None:
        """Halts every branch as the time of a block is over, then goes on to what that leads to."""
        late, event = pen.place("late"), Event(What.TIMEOUT, section.name)
        put = [late, *self.tokens(section, 0, "halt"), *self.canvas.resting]
        pen.transition("EV_TIMEOUT", [self.of(section, "running")], put, event=event)
        self.onward(pen, "timed_out", [late, *all_halted], self.led(section, TIMED_OUT))

    def onward(
        self, pen: Pen, part: str, halted: list[str], leading: Iterable[tuple[str, FactArcs, list[str]]]
    ) -> None:
        """Goes on to what has stopped a block leads to, once every branch has halted."""
        for case, way, entered in leading:
            name = f"{part}_{case}" if case else part
            pen.transition(name, halted, entered, read=way.read, rank=self.first)

    def becoming(self, section: Section) -> Iterator[tuple[str, str, list[str], int]]:
        """By outcome and word of its condition: places that say that facts have become so, and the rank."""
        for outcome, each in section.becoming:
            so = [self.canvas.fact(*said) for said in each.when]
            for number, said in enumerate(each.when):
                rank = self.canvas.ranks.becoming(section.name, outcome, number)
                word = f"{outcome.replace(' ', '')}_{number + 1}"
                yield outcome, word, [self.canvas.asking, self.canvas.became(*said), *so], rank

    def left_by_facts(self, pen: Pen, section: ParallelSection, all_halted: list[str]) -> None:
        """Halts every branch as facts become so, then goes on to what that leads to."""
        left = {outcome: pen.place(outcome.replace(" ", "")) for outcome, _ in section.becoming}
        halts = self.tokens(section, 0, "halt")
        for outcome, word, read, rank in self.becoming(section):
            put = [left[outcome], *halts]
            pen.transition(word, [self.of(section, "running")], put, read=read, rank=rank)
        for outcome, place in left.items():
            part = f"left_{outcome.replace(' ', '')}"
            self.onward(pen, part, [place, *all_halted], self.led(section, outcome))
