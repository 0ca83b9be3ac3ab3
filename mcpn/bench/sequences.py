"""Scripts of faults: events with the hours at which they happen."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

from mcpn.bench.runs import edge_of
from mcpn.bench.world import ControllerPlace, Places
from mcpn.errors import InputError, LimitError, Source
from mcpn.files import read_bounded
from mcpn.nets.events import Event, What
from mcpn.runtime.tables import Tables


def read_script(path: Path) -> list[tuple[float, str]]:
    """Reads a script: on each line the hours since the start and an event; ``#`` begins a comment.

    Args:
        path: The file.

    Returns:
        The events in the order in which they happen.

    Raises:
        InputError: A line is of another form.
    """
    try:
        lines = read_bounded(path).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path)), f"expected text in UTF-8: {error.reason}") from error
    found: list[tuple[float, str]] = []
    for number, line in enumerate(lines, 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            hours, event = float(words[0]), Event.parse(words[1])
        except (ValueError, IndexError):
            hours, event = -1.0, Event(What.NAMED, "")
        if len(words) != 2 or not 0 <= hours < inf or event.what is What.NAMED:
            message = f"found {line.strip()[:80]!r}, expected hours and an event, as in 0.5 GPS_EV_OOS"
            raise InputError.at(Source(str(path), number), message)
        found.append((hours, str(event)))
    return sorted(found, key=lambda step: step[0])


# --- Sequences of events that take every edge of a controller, to test a robot's own code with ------------

MOST_PLACES = 200_000
"""Places that may be looked at: with much hardware there are very many."""


@dataclass(frozen=True)
class Expected:
    """One event of a sequence, and what a controller does on it.

    Args:
        event: Its text.
        actions: The actions as texts, in order.
        outcome: How the mission has ended then.
    """

    event: str
    actions: tuple[str, ...]
    outcome: str | None


@dataclass(frozen=True)
class Sequences:
    """Sequences that take every edge.

    Args:
        each: The sequences, each from before the mission's start.
        edges: How many edges of sections they take: all that some run takes.
    """

    each: tuple[tuple[Expected, ...], ...]
    edges: int


def sequences(tables: Tables, most: int = MOST_PLACES) -> Sequences:
    """Finds sequences that take every edge of every section: each event in each state of it.

    From where it is, a sequence takes a shortest way to an edge that is not taken yet; where there is none,
    another one begins. So they are short, but need not be the shortest.

    Args:
        tables: The controller's.
        most: How many places may be looked at.

    Raises:
        LimitError: There are more.
    """
    places = Places(tables)
    search = _UntakenEdges(places, most)
    found: list[tuple[Expected, ...]] = []
    while True:
        place, steps = places.start, list[Expected]()
        while (way := search.way(place)) is not None:
            for event in way:
                search.take(place, event)
                step = places.after(place, event)
                assert step is not None, "it was possible"
                place, actions = step
                steps.append(Expected(event, tuple(map(str, actions)), place.outcome))
        if not steps:
            return Sequences(tuple(found), len(search.taken))
        found.append(tuple(steps))


class _UntakenEdges:
    """A search for edges that are not taken yet.

    Args:
        places: The controller's.
        most: How many places may be looked at.

    Attributes:
        taken: Edges that are taken.
    """

    def __init__(self, places: Places, most: int) -> None:
        self._places, self._most = places, most
        self.taken = set[tuple[str, int, str]]()
        self._done = set[ControllerPlace]()
        """Places behind which all edges are taken."""
        self._open: dict[ControllerPlace, list[str]] = {}
        """By place, events whose edges may not be taken yet."""
        self._next: dict[ControllerPlace, list[tuple[ControllerPlace, str]]] = {}
        """By place, those that one event leads to, with the first one that does."""

    def take(self, place: ControllerPlace, event: str) -> None:
        """Notes that an event was taken in a place."""
        edge = edge_of(self._places.tables, place, event)
        if edge is not None:
            self.taken.add(edge)

    def way(self, start: ControllerPlace) -> list[str] | None:
        """A shortest way from a place over an edge that is not taken yet."""
        origin: dict[ControllerPlace, tuple[ControllerPlace, str] | None] = {start: None}
        queue = deque([start])
        while queue:
            place = queue.popleft()
            if (event := self._untaken(place)) is not None:
                return [*_back(origin, place), event]
            for target, event in self._ahead(place):
                if target not in origin and target not in self._done:
                    origin[target] = place, event
                    queue.append(target)
            if len(origin) > self._most:
                raise LimitError(
                    f"more than {self._most} places of the controller looked at for an edge that is not "
                    "taken yet: the limit was hit"
                )
        self._done.update(origin)
        return None

    def _untaken(self, place: ControllerPlace) -> str | None:
        """The first event of a place whose edge is not taken yet."""
        left = self._open.get(place)
        if left is None:
            left = [] if place.outcome is not None else list(place.possible)
        if left:
            edges = ((event, edge_of(self._places.tables, place, event)) for event in left)
            left = [event for event, edge in edges if edge is not None and edge not in self.taken]
        self._open[place] = left
        return left[0] if left else None

    def _ahead(self, place: ControllerPlace) -> list[tuple[ControllerPlace, str]]:
        """The places that one event leads to from a place, each with the first event that does."""
        if place not in self._next:
            ahead: dict[ControllerPlace, str] = {}
            for event in place.possible if place.outcome is None else ():
                step = self._places.after(place, event)
                assert step is not None, "it is possible"
                ahead.setdefault(step[0], event)
            self._next[place] = list(ahead.items())
        return self._next[place]


def _back(
    origin: dict[ControllerPlace, tuple[ControllerPlace, str] | None], place: ControllerPlace
) -> list[str]:
    way = []
    while (before := origin[place]) is not None:
        place, event = before
        way.append(event)
    return way[::-1]


def files(found: Sequences, mission: str) -> Iterator[tuple[str, str]]:
    """What ``mcpn tests`` writes: by name, the text of each file but the controller's.

    Args:
        found: The sequences.
        mission: The mission's name.
    """
    yield "events.txt", "".join(f"{step.event}\n" for each in found.each for step in (_BEGIN, *each))
    lines = (f"taken: {'; '.join(step.actions)}".rstrip() for each in found.each for step in each)
    yield "expected.txt", "".join(f"{line}\n" for line in lines)
    rows = []
    for each in found.each:
        steps = (f"        ({s.event!r}, {list(s.actions)!r}, {s.outcome!r}),\n" for s in each)
        rows.append("    [\n" + "".join(steps) + "    ],\n")
    yield "test_controller.py", _PYTEST.format(mission=mission, edges=found.edges, rows="".join(rows))


_BEGIN = Expected("", (), None)

_PYTEST = '''\
"""Sequences of events that take each of the {edges} edges of the controller of {mission}, made by mcpn.

They test what the fixture ``robot`` gives: an object whose ``handle(event)`` returns the actions as texts,
and whose ``outcome`` is "success", "failure", "abort" or None. It is the runtime with controller.json; define
a fixture of this name in a conftest.py beside to test your own code, and delete this one.
"""

from pathlib import Path

import pytest

SEQUENCES = [
{rows}]


class Runtime:
    def __init__(self, controller):
        self.controller = controller

    def handle(self, event):
        return [str(action) for action in self.controller.handle(event)]

    @property
    def outcome(self):
        return self.controller.outcome


@pytest.fixture(scope="module")
def fresh():
    from mcpn.runtime import Controller

    controller = Controller.load(Path(__file__).with_name("controller.json"))
    return controller, controller.snapshot()


@pytest.fixture
def robot(fresh):
    controller, before = fresh
    controller.restore(before)
    return Runtime(controller)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_sequence(robot, sequence):
    for number, (event, actions, outcome) in enumerate(sequence, 1):
        assert (robot.handle(event), robot.outcome) == (actions, outcome), f"step {{number}}: {{event}}"
'''
