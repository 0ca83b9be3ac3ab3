"""Sequences of events that take every edge of a controller, to test a robot's own code with."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from mcpn.bench.places import ControllerPlace, Places
from mcpn.bench.runs import edge_of
from mcpn.errors import LimitError
from mcpn.runtime.tables import Tables

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
    places, taken, done = Places(tables), set[tuple[str, int, str]](), set[ControllerPlace]()
    found: list[tuple[Expected, ...]] = []
    while True:
        place, steps = places.start, list[Expected]()
        while (way := _way(places, place, taken, done, most)) is not None:
            for event in way:
                edge = edge_of(tables, place, event)
                if edge is not None:
                    taken.add(edge)
                step = places.after(place, event)
                assert step is not None, "it was possible"
                place, actions = step
                steps.append(Expected(event, tuple(map(str, actions)), place.outcome))
        if not steps:
            return Sequences(tuple(found), len(taken))
        found.append(tuple(steps))


def _way(
    places: Places,
    start: ControllerPlace,
    taken: set[tuple[str, int, str]],
    done: set[ControllerPlace],
    most: int,
) -> list[str] | None:
    """A shortest way from a place over an edge that is not taken yet.

    Args:
        places: The controller's.
        start: The place.
        taken: Edges that are taken.
        done: Places behind which all edges are taken; those that are found here are added.
        most: How many places may be looked at.
    """
    origin: dict[ControllerPlace, tuple[ControllerPlace, str] | None] = {start: None}
    queue = deque([start])
    while queue:
        place = queue.popleft()
        if place.outcome is not None:
            continue
        for event in place.possible:
            edge = edge_of(places.tables, place, event)
            if edge is not None and edge not in taken:
                return [*_back(origin, place), event]
            step = places.after(place, event)
            assert step is not None, "it is possible"
            if step[0] not in origin and step[0] not in done:
                origin[step[0]] = place, event
                queue.append(step[0])
        if len(origin) > most:
            raise LimitError(
                f"more than {most} places of the controller looked at for an edge that is not taken yet: "
                "the limit was hit"
            )
    done.update(origin)
    return None


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
