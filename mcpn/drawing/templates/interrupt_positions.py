"""Positions of a section's objectives in which an event is handled, and handlers that happen once.

A handler that happens once has two places of its own: *open*, and *happened*. The transition of an event that
the handler handles consumes *open* and produces *happened*; the transition of the next handler outwards reads
*happened*. Sections hand both on as they do the status of hardware.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from mcpn.drawing.templates.canvas import Canvas
from mcpn.mission.core.objectives_graph import ParallelSection, Section


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
