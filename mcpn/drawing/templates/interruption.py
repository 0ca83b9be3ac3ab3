"""Positions of a section's objectives in which an event is handled, handlers that happen once, and pauses.

A handler that happens once has two places of its own: *open*, and *happened*. The transition of an event that
the handler handles consumes *open* and produces *happened*; the transition of the next handler outwards reads
*happened*. Sections hand both on as they do the status of hardware.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from mcpn.drawing.templates.canvas import Canvas, Pen
from mcpn.drawing.templates.facts import ways
from mcpn.mission.flatten import ElementarySection, ParallelSection, Section

if TYPE_CHECKING:
    from mcpn.drawing.templates.interrupting import Interrupting

L = TypeVar("L")


def draw_once(canvas: Canvas, handler: str) -> None:
    """Draws the status of a handler that happens once."""
    pen = canvas.of("once", handler, None)
    open_ = canvas.role(pen.place("open", initial=1), ("open", handler))
    happened = canvas.role(pen.place("happened"), ("happened", handler))
    canvas.unit([open_, happened])


class Surroundings(NamedTuple):
    """The blocks around a graph of objectives.

    Args:
        in_branch: Whether it is that of a branch of a parallel block.
        eventful: Whether some event interrupts the mission's section that it is in, or something there.
        running: Places that say that the blocks around run which an event may interrupt as a whole.
        halted: With such blocks around, the place that says that the branch is halted.
        pauses: Whether an event may stop all that is in it, which then goes on later.
    """

    in_branch: bool = False
    eventful: bool = False
    running: tuple[str, ...] = ()
    halted: str = ""
    pauses: bool = False


class Position(NamedTuple):
    """Where the objectives of a section may be when an event happens, and what the event does there.

    Args:
        read: Places that are marked there.
        take: Those of them that the event's transition consumes.
        put: Places that it marks; ``None`` where nothing handles the event.
        once: Handlers that happen once and do so there.
        happened: Those that have happened before.
    """

    read: tuple[str, ...]
    take: tuple[str, ...] = ()
    put: tuple[str, ...] | None = None
    once: tuple[str, ...] = ()
    happened: tuple[str, ...] = ()

    def together_with(self, other: Position) -> Position:
        """What the event does where both hold, each in a branch of its own."""
        put = None if self.put is other.put is None else (*(self.put or ()), *(other.put or ()))
        read, take = (*self.read, *other.read), (*self.take, *other.take)
        once, happened = (*self.once, *other.once), (*self.happened, *other.happened)
        return Position(read, take, put, tuple(dict.fromkeys(once)), tuple(dict.fromkeys(happened)))

    @property
    def possible(self) -> bool:
        """Whether no handler would have to be open and to have happened at the same time."""
        return not {*self.once} & {*self.happened}


def called(event: str, number: int, word: str = "on") -> str:
    """The name of what is drawn for one handler of an event; the innermost handler has no number."""
    return f"{word}_{event}" if number == 1 else f"{word}{number}_{event}"


def events_of(section: Section) -> Iterator[str]:
    """Names of events that interrupt a section, or something in it."""
    yield from (i.event for i in section.every_interruption)
    for graph in section.graphs if isinstance(section, ParallelSection) else ():
        for inner in graph.sections:
            yield from events_of(inner)


def may_halt(section: Section) -> bool:
    """Whether the end or time of a parallel block in a section, or facts, may stop branches."""
    if not isinstance(section, ParallelSection):
        return False
    inside = (inner for graph in section.graphs for inner in graph.sections)
    return section.early or section.stopped or any(map(may_halt, inside))


class Arcs(NamedTuple):
    """Arcs of a transition that halts, pauses, resumes or drops a branch, besides the token that says so."""

    taken: list[str]
    put: list[str]
    read: Sequence[str] = ()


class Region(NamedTuple, Generic[L]):
    """A region of a block, as in a state machine: a branch, or what runs while the block pauses.

    Args:
        level: Its graph.
        ends: By outcome, the places that are marked when a branch has ended; the last says that it has.
        place: Names its places.
    """

    level: L
    ends: list[tuple[str, ...]]
    place: Callable[[str], str]

    @property
    def ended(self) -> list[str]:
        """The places that say that it has ended."""
        return list(dict.fromkeys(end[-1] for end in self.ends))


class Pausing:
    """Draws the pauses of a block, or those of what is around it.

    Args:
        level: Where the block stands.
        pen: The block's.
        section: The block.
    """

    def __init__(self, level: Interrupting, pen: Pen, section: ParallelSection) -> None:
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
