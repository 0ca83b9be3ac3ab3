"""What interrupts sections of the objectives graph, and halts parallel blocks.

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

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from math import prod
from typing import TypeAlias

from mcpn.errors import LimitError
from mcpn.mission.flatten import Branch, ElementarySection, Interruption, ParallelSection, Section
from mcpn.net.events import Event, What
from mcpn.net.templates.canvas import Pen
from mcpn.net.templates.interruption import Position, called, events_of
from mcpn.net.templates.leaving import Leaving
from mcpn.net.templates.level import Level, element_of

MAX_POSITIONS = 10_000
"""Combinations of where the branches of a block may be that handle one event, each with a transition."""

_Ways: TypeAlias = Iterable[tuple[list[str], Iterable[str]]]
"""For each combination of values of facts: the places that say so, and the places to mark."""


class Interrupting(Level):
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
                put = [*(position.put or ()), *self.of_handlers(position.once, "happened")]
                pen.transition(f"EV{number}_{name}", take, put, read=read, event=event)

    def of_handlers(self, handlers: Iterable[str], part: str) -> list[str]:
        """Of each of some handlers that happen once the place that its template calls ``part``."""
        return [self.canvas.place_of("once", handler, part) for handler in handlers]

    def positions(self, section: Section, event: str) -> Iterator[Position]:
        """Where the objectives of a section may be when an event happens; one of these holds at a time."""

        def handled(place: str, put: Callable[[Interruption, int], _Ways]) -> Iterator[Position]:
            for number, (own, before) in enumerate(section.handlers(event), 1):
                if own is None:
                    yield Position((place,), happened=before)
                    continue
                once = () if own.once is None else (own.once,)
                for facts, after in put(own, number):
                    yield Position((place, *facts), (place,), tuple(after), once, before)

        def left(own: Interruption) -> Iterator[tuple[list[str], list[str]]]:
            return ((way.read, places) for _, way, places in self.ways(section, own.target, own.cases, {}))

        if self.around.in_branch and self.gated(section):
            yield from handled(self.of(section, "enter"), lambda own, _: left(own))
        if isinstance(section, ElementarySection):
            stops = self.stops(section)

            def onward(own: Interruption, _: int) -> _Ways:
                return ((facts, [*stops, *places]) for facts, places in left(own))

            yield from handled(self.of(section), onward)
            return
        halts = [self.of_branch(branch, "halt") for branch in section.branches]
        for inside in self.in_branches(section, event):
            if inside.put is not None:
                yield inside
                continue
            for whole in handled(
                self.of(section, "running"),
                lambda _, number: [([], [self.of(section, called(event, number)), *halts])],
            ):
                if self.possible(both := inside.beside(whole)):
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
            leading = self.ways(section, interruption.target, interruption.cases, {})
            for case, way, entered in leading:
                part = left + (f"_{case}" if case else "")
                pen.transition(part, [place, *all_halted], entered, read=way.read, rank=self.first)
        leaving = Leaving(self.canvas, section)
        leaving.decided(pen, self.of(section, "running"), partial(self.led, section), all_halted)
        if self.around.halted:
            place = pen.place("halting")
            pen.transition("halted", [place, *all_halted], [self.around.halted], rank=self.first)

    def halting(self, section: ParallelSection, branch: Branch) -> Iterator[tuple[list[str], list[str]]]:
        """By position of this graph, that of a branch, the places that are taken and those that are put."""
        halted = self.of_branch(branch, "halted")
        for inner in self.graph.sections:
            if self.gated(inner):
                yield [self.of(inner, "enter")], [halted]
            if isinstance(inner, ElementarySection):
                if inner.setting("start"):
                    yield [self.of(inner, "starts")], [halted]
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
