"""Sequences of events that take every edge of a controller, to test a robot's own code with."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import inf

from mcpn.errors import LimitError
from mcpn.robot.runtime.actions import Action
from mcpn.robot.runtime.controller_tables import RuntimePosition, Tables
from mcpn.robot.runtime.documents import BEFORE, RUNNING

MOST_PLACES = 200_000
"""Places that may be looked at: with much hardware there are very many."""

FIRST_PATIENCE = 64
"""Bounds that a search raises before it looks at all places around; later as many as it then looked at."""


@dataclass(frozen=True, eq=False)
class Expected:
    """One event of a sequence, and what a controller does on it: one object, however often it is taken.

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
    search = _UntakenEdges(_PlaceGraph(tables, most))
    found: list[tuple[Expected, ...]] = []
    while True:
        place, steps = 0, list[Expected]()
        while (way := search.way(place)) is not None:
            for edge in way:
                steps.append(search.take(edge))
                place = edge.target
        if not steps:
            return Sequences(tuple(found), search.taken)
        found.append(tuple(steps))


@dataclass(eq=False, slots=True)
class _PlaceEdge:
    """An event in a place of the controller.

    Args:
        event: Its text.
        target: The place that it leads to.
        actions: What the controller orders.
        number: Of the edge of the section that it takes, if it is of one; several places share it.
        expected: The step as it is written, once it has been.
    """

    event: str
    target: int
    actions: tuple[Action, ...]
    number: int | None
    expected: Expected | None = None


class _PlaceGraph:
    """The places of a controller by numbers, each followed once, as far as they are asked for.

    Args:
        tables: The controller's.
        most: How many places there may be.
    """

    def __init__(self, tables: Tables, most: int) -> None:
        self._tables, self._most = tables, most
        self._numbers: dict[tuple[str, str, int, frozenset[str], frozenset[str]], int] = {}
        self._places: list[RuntimePosition] = []
        self._edges: dict[tuple[str, int, str], int] = {}
        gone, true = frozenset(tables.out_of_service), frozenset(tables.true_at_first)
        self._number(RuntimePosition(BEFORE, None, 0, gone, true))

    def __len__(self) -> int:
        return len(self._places)

    def outcome(self, place: int) -> str | None:
        """How the mission has ended there."""
        phase = self._places[place].phase
        return None if phase in (BEFORE, RUNNING) else phase

    def leaves(self, place: int, edge: _PlaceEdge) -> bool:
        """Whether an edge of a place leads out of the section that runs there."""
        return self._places[edge.target].section is not self._places[place].section

    def follow(self, place: int) -> list[_PlaceEdge]:
        """What may happen in a place, in the order of the events; to be asked once."""
        at = self._places[place]
        events = () if self.outcome(place) else sorted(self._tables.possible(at))
        return [self._edge(at, event) for event in events]

    def _edge(self, at: RuntimePosition, event: str) -> _PlaceEdge:
        step = self._tables.after(at, event)
        assert step is not None, "it is possible"
        number = None
        if at.section is not None and event in at.section.number:
            number = self._edges.setdefault((at.section.name, at.state, event), len(self._edges))
        return _PlaceEdge(event, self._number(step[0]), step[1], number)

    def _number(self, at: RuntimePosition) -> int:
        name = at.section.name if at.section else ""
        gone, true = frozenset(at.gone), frozenset(at.true)
        number = self._numbers.setdefault((at.phase, name, at.state, gone, true), len(self._places))
        if number == len(self._places):
            self._places.append(RuntimePosition(at.phase, at.section, at.state, gone, true))
            if number == self._most:
                raise LimitError(
                    f"more than {self._most} places of the controller looked at for an edge that is not "
                    "taken yet: the limit was hit"
                )
        return number


class _UntakenEdges:
    """Shortest ways to edges that are not taken yet: learning depth-first search (Bonet and Geffner, 2005).

    As edges are taken, the way from a place to the next one that is not only grows. So a bound from below
    that was found for a place holds for ever. A search walks on to where the bound is smaller by one; where
    there is no such place it raises the bound and goes back. Bounds that rise for long are asked of a
    breadth-first search, which finds out where there is nothing left.

    Args:
        graph: The places of the controller.
    """

    def __init__(self, graph: _PlaceGraph) -> None:
        self._graph = graph
        self._taken = set[int]()
        self._ahead: dict[int, list[_PlaceEdge]] = {}
        """By place that was followed, its edges."""
        self._targets: dict[int, list[int]] = {}
        """Where they lead."""
        self._open: dict[int, list[_PlaceEdge]] = {}
        """By place, edges that may not be taken yet, the first one last."""
        self._least = list[float]()
        """By place, how far the next edge that is not taken is at least."""
        self._patience = FIRST_PATIENCE

    @property
    def taken(self) -> int:
        """How many edges of sections were taken."""
        return len(self._taken)

    def take(self, edge: _PlaceEdge) -> Expected:
        """Takes an edge; says what is expected of it."""
        if edge.number is not None:
            self._taken.add(edge.number)
        if edge.expected is None:
            actions = tuple(map(str, edge.actions))
            edge.expected = Expected(edge.event, actions, self._graph.outcome(edge.target))
        return edge.expected

    def way(self, start: int) -> list[_PlaceEdge] | None:
        """A shortest way from a place over an edge that is not taken yet."""
        way = list[_PlaceEdge]()
        raised, place, bounds = 0, start, self._least
        while True:
            if (edge := self._untaken(place)) is not None:
                way.append(edge)
                return way
            each = [bounds[target] for target in self._targets[place]]
            nearest = min(each, default=inf)
            if nearest == inf and not way:
                return None
            if nearest < bounds[place]:
                way.append(self._ahead[place][each.index(nearest)])
                place = way[-1].target
                continue
            bounds[place] = nearest + 1
            raised += 1
            if way:
                way.pop()
            if raised >= self._patience:
                raised, self._patience = 0, max(self._measure(start), FIRST_PATIENCE)
                way.clear()
            place = way[-1].target if way else start

    def _measure(self, start: int) -> int:
        """Bounds all places by their distance from one; returns how many were looked at."""
        steps = {start: 0}
        queue = deque([start])
        far = inf
        while queue:
            place = queue.popleft()
            if self._untaken(place) is not None:
                far = steps[place]
                break
            for target in self._targets[place]:
                if target not in steps and self._least[target] < inf:
                    steps[target] = steps[place] + 1
                    queue.append(target)
        for place, step in steps.items():
            self._least[place] = max(self._least[place], far - step)
        return len(steps)

    def _untaken(self, place: int) -> _PlaceEdge | None:
        """The first edge of a place that is not taken yet."""
        left = self._open.get(place)
        if left is None:
            left = self._follow(place)
        while left and left[-1].number in self._taken:
            left.pop()
        return left[-1] if left else None

    def _follow(self, place: int) -> list[_PlaceEdge]:
        """Follows a place, whose edges none has asked for; those of its section, the first one last."""
        graph = self._graph
        ahead = self._ahead[place] = graph.follow(place)
        self._targets[place] = [edge.target for edge in ahead]
        self._least += [0] * (len(graph) - len(self._least))
        left = [edge for edge in reversed(ahead) if edge.number is not None]
        # What stays in the section comes first: few sequences come back to it.
        left.sort(key=lambda edge: not graph.leaves(place, edge))
        self._open[place] = left
        return left


def files(found: Sequences, mission: str) -> Iterator[tuple[str, str]]:
    """What ``mcpn tests`` writes: by name, the text of each file but the controller's.

    Args:
        found: The sequences.
        mission: The mission's name.
    """
    yield "events.txt", "".join(f"{step.event}\n" for each in found.each for step in (_BEGIN, *each))
    line, row = cache(_line), cache(_row)  # by identity: steps are shared, and are many
    yield "expected.txt", "".join(line(step) for each in found.each for step in each)
    rows = (f"    [\n{''.join(map(row, each))}    ],\n" for each in found.each)
    yield "test_controller.py", _PYTEST.format(mission=mission, edges=found.edges, rows="".join(rows))


def _line(step: Expected) -> str:
    """What a program that reads events prints of a step."""
    return f"taken: {'; '.join(step.actions)}".rstrip() + "\n"


def _row(step: Expected) -> str:
    """A step as Python."""
    return f"        ({step.event!r}, {list(step.actions)!r}, {step.outcome!r}),\n"


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
    from mcpn.robot.runtime import Controller

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
