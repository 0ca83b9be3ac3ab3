"""The losing region: states from which success is out of reach, and the critical events that lead into it.

Source: the paper, 7.2 ("studying the resource events that force the mission into a branch leading to
failure"). A state *loses* a goal where no run reaches it any more; without repairs, where no run without a
repair does. The goal of the mission is its success; the goal of an objective is that its present run
ends in success, so that a later retry is another run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Literal, TypeAlias

import numpy as np

from mcpn.check.modes import Mode, situation
from mcpn.mission.flatten import ElementarySection, Section
from mcpn.mission.handover import entries
from mcpn.net.compose import MissionNet
from mcpn.net.events import START, Event, What
from mcpn.space.graph import Ints, Mask, StateGraph

Kind: TypeAlias = Literal["objective", "pending", "done"]


@dataclass(frozen=True, eq=False)
class Goal:
    """Something that a mission may still reach, on one graph.

    Args:
        kind: What is to succeed.
        name: Its name.
        running: States in which it is not decided yet, shape (states,).
        won: States in which it is reached, or the event that reaches it may happen, shape (states,).
        along: Edges that stay within the present run, shape (edges,).
    """

    kind: Literal["mission", "objective"]
    name: str
    running: Mask
    won: Mask
    along: Mask


@dataclass(frozen=True)
class CriticalEvent:
    """Edges of one event that cross into a losing region from one functioning mode.

    Args:
        event: The event.
        objectives: Objectives that run before it.
        mode: The functioning mode before it.
        edges: How many edges of the graph.
    """

    event: Event
    objectives: tuple[str, ...]
    mode: Mode
    edges: int


class Outlook:
    """What the graph of a mission says of its chances.

    Args:
        mission_net: The mission's net.
        graph: Its alternatives graph, or its markings graph; regions agree on stable states.
    """

    def __init__(self, mission_net: MissionNet, graph: StateGraph) -> None:
        self.mission_net = mission_net
        self.graph = graph
        known = mission_net.by_role
        # Of a part of a mission, the net holds a part of the hardware.
        self.hardware = tuple(h.name for h in mission_net.mission.hardware if ("oos", h.name) in known)
        self.index: Mapping[str, int] = {name: number for number, name in enumerate(self.hardware)}

    # --- hardware --------------------------------------------------------------------------------------

    @cached_property
    def out(self) -> Mask:
        """Which hardware is out of service in which state, shape (states, hardware)."""
        columns = [self.graph.marked(*self.mission_net.by_role["oos", name]) for name in self.hardware]
        return np.stack(columns, axis=1) if columns else np.zeros((self.graph.states, 0), np.bool_)

    def _hardware_of(self, what: What) -> Ints:
        transitions = self.graph.net.transitions
        number = np.full(len(transitions), -1, np.int64)
        for t, transition in enumerate(transitions):
            if transition.event is not None and transition.event.what is what:
                number[t] = self.index.get(transition.event.element, -1)
        return number[self.graph.labels]

    @cached_property
    def failing(self) -> Ints:
        """The hardware that goes out of service at each edge, -1 for other edges, shape (edges,)."""
        return self._hardware_of(What.OUT_OF_SERVICE)

    @cached_property
    def repaired(self) -> Ints:
        """The hardware that is ready again at each edge, -1 for other edges, shape (edges,)."""
        return self._hardware_of(What.REPAIRED)

    def allowed(self, repairs: bool) -> Mask:
        """Edges that runs with, or without, repairs may take."""
        return np.ones(self.graph.edges, np.bool_) if repairs else self.repaired < 0

    # --- goals and moments -----------------------------------------------------------------------------

    @cached_property
    def mission(self) -> Goal:
        """Success of the mission."""
        success = self.graph.marked(self.mission_net.success)
        return Goal("mission", self.mission_net.mission.name, ~success, success, self.allowed(True))

    @cached_property
    def objectives(self) -> Mapping[str, Goal]:
        """Success of each elementary objective in its present run, by its name, in the mission's order."""
        return {section.name: self._objective(section.name) for section in self.mission_net.graph.walk()}

    def _objective(self, name: str) -> Goal:
        graph, running = self.graph, self.runs(name)
        succeeds, fails = self.fired(Event(What.SUCCESS, name)), self.fired(Event(What.FAILURE, name))
        won = np.zeros(graph.states, np.bool_)
        won[graph.sources[succeeds]] = True
        inside = running[graph.sources] & running[graph.targets] & ~succeeds & ~fails
        return Goal("objective", name, running, won, inside)

    def runs(self, objective: str) -> Mask:
        """States in which an elementary objective runs."""
        (place,) = self.mission_net.by_role["objective", objective]
        return self.graph.marked(place)

    def fired(self, event: Event) -> Mask:
        """Edges of an event."""
        transitions = self.graph.net.transitions
        named = np.array([t.event == event for t in transitions], np.bool_)
        return named[self.graph.labels]

    def ended(self, objective: str) -> Mask:
        """Edges with which an objective ends."""
        return self.fired(Event(What.SUCCESS, objective)) | self.fired(Event(What.FAILURE, objective))

    @cached_property
    def begun(self) -> Mask:
        """States in which the mission has begun."""
        starts = self.fired(START)
        before = np.zeros(self.graph.states, np.bool_)
        before[self.graph.sources[starts]] = True
        # Hardware may fail and recover before the mission begins, and internal steps may follow each event.
        return ~self.graph.reaching(before)

    def entered(self, section: Section) -> Mask:
        """States at the entry of a section: just entered, or so but for failures that came at once."""
        graph = self.graph
        waiting: tuple[Kind, ...] = ("objective", "pending")
        inside = self._marked(waiting, [first.name for first in entries(section)])
        running, again = inside, np.zeros(graph.edges, np.bool_)
        if isinstance(section, ElementarySection):
            # A retry ends one run and begins the next with one event.
            again = self.ended(section.name)
        else:
            for branch in section.branches:
                names = [branch.name, *(inner.name for inner in branch.graph.walk())]
                running = running | self._marked((*waiting, "done"), names)
        crossing = inside[graph.targets] & (again | ~running[graph.sources])
        entry = np.zeros(graph.states, np.bool_)
        entry[graph.targets[crossing]] = True
        return self._after_failures(entry)

    def _marked(self, kinds: Iterable[Kind], names: Iterable[str]) -> Mask:
        """States in which some place says one of these kinds of one of these elements."""
        found = np.zeros(self.graph.states, np.bool_)
        for kind, name in product(kinds, names):
            for place in self.mission_net.by_role.get((kind, name), ()):
                found |= self.graph.marked(place)
        return found

    def _after_failures(self, states: Mask) -> Mask:
        graph, along = self.graph, self.failing >= 0
        found = states.copy()
        while True:
            more = found.copy()
            more[graph.targets[found[graph.sources] & along]] = True
            if np.array_equal(more, found):
                return found
            found = more

    # --- losing regions --------------------------------------------------------------------------------

    def losing(self, goal: Goal, repairs: bool) -> Mask:
        """States in which a goal is still open and can no longer be reached.

        Args:
            goal: The goal.
            repairs: Whether hardware may be repaired.

        Returns:
            Shape (states,). Linear in the size of the graph.
        """
        return goal.running & ~self.graph.reaching(goal.won, goal.along & self.allowed(repairs))

    @cached_property
    def forced(self) -> Mask:
        """Edges of runs without repairs in which objectives fail only where they cannot succeed any more."""
        along = self.allowed(False)
        for name, goal in self.objectives.items():
            lost = self.losing(goal, repairs=False)
            along = along & ~(self.fired(Event(What.FAILURE, name)) & ~lost[self.graph.sources])
        return np.asarray(along, np.bool_)

    def crossing(self, goal: Goal, repairs: bool) -> Mask:
        """Edges that lead from a chance to reach the goal to none, shape (edges,)."""
        losing, graph = self.losing(goal, repairs), self.graph
        into = losing[graph.targets] & ~losing[graph.sources] & goal.running[graph.sources]
        return np.asarray(into & goal.along & self.allowed(repairs), np.bool_)

    def critical(self, goal: Goal, repairs: bool) -> list[CriticalEvent]:
        """Critical events, grouped by event, running objectives and functioning mode.

        Args:
            goal: What is lost.
            repairs: Whether hardware may be repaired.

        Returns:
            In the order of the net's transitions, then of the graph's states.
        """
        edges = np.flatnonzero(self.crossing(goal, repairs))
        ordered = edges[np.argsort(self.graph.labels[edges], kind="stable")]
        transitions, labels, sources = self.graph.net.transitions, self.graph.labels, self.graph.sources
        named = ((transitions[int(labels[e])].event, int(sources[e])) for e in ordered)
        # On a markings graph internal steps cross too, of which the event before them has decided.
        return self.grouped((event, state) for event, state in named if event is not None)

    def grouped(self, crossings: Iterable[tuple[Event, int]]) -> list[CriticalEvent]:
        """Critical events from single ones.

        Args:
            crossings: Events, each with the state that it happens in.
        """
        said = [p for kind in ("objective", "active") for p in self.mission_net.saying(kind)]
        columns = [self.graph.marked(p) for p in said]
        groups: dict[tuple[Event, bytes], list[int]] = {}
        for event, state in crossings:
            marks = bytes(bool(column[state]) for column in columns)
            groups.setdefault((event, marks), []).append(state)
        found = []
        for (event, _), states in groups.items():
            before = situation(self.mission_net, self.graph.marking(states[0]))
            found.append(CriticalEvent(event, before.objectives, before.mode, len(states)))
        return found
