"""One mission composed with some templates, its markings, and what violates a property of them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import TemplateSet
from mcpn.mission.model import Mission
from mcpn.nets.petri import PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import EXPLICIT
from mcpn.spaces.engines import Choice
from mcpn.spaces.markings.graph import Mask, StateGraph

MOST_MARKINGS = 20_000
"""Markings of a mission that a property looks at; larger missions are passed over."""


class Violation(AssertionError):
    """A template breaks a promise.

    Args:
        message: Which, and where.
        runs: Transitions from the initial marking that show it; none where the arcs show it.
        net: The net that they are of.

    Attributes:
        message: The same.
        runs: The same.
    """

    def __init__(self, message: str, runs: Sequence[Sequence[str]] = (), net: PetriNet | None = None) -> None:
        self.message = message
        self.runs = tuple(tuple(run) for run in runs)
        super().__init__("\n".join([message, *run_lines(net, self.runs)]))


def run_lines(net: PetriNet | None, runs: Sequence[Sequence[str]]) -> list[str]:
    """Runs as lines: each event with a number, what fires inside the net after it below."""
    lines = []
    for number, run in enumerate(runs, 1):
        lines.append(f"run {number}:" if len(runs) > 1 else "run:")
        events = 0
        for name in run:
            event = None if net is None else net.transitions[net.transition_index[name]].event
            if event is not None:
                events += 1
                lines.append(f"  {events}. {event}")
            else:
                lines.append(f"       {name}")
    return lines


class Subject:
    """A mission composed with some templates; what is asked of it is built once.

    Args:
        mission: The mission.
        templates: The templates; the paper's by default.
        max_states: The most markings that it may have.

    Attributes:
        templates: The same.
        mission_net: Its net, with what places mean.
    """

    def __init__(
        self, mission: Mission, templates: TemplateSet | None = None, *, max_states: int = MOST_MARKINGS
    ) -> None:
        self.templates = templates
        self.mission_net: MissionNet = compose(mission, templates)
        self._spaces = MissionSpaces(self.mission_net, templates=templates)
        self._choice = Choice(EXPLICIT, max_states=max_states)

    @classmethod
    def known(cls, mission_net: MissionNet, markings: StateGraph) -> Subject:
        """A subject whose markings have been listed already."""
        subject = cls.__new__(cls)
        subject.templates, subject.mission_net, subject._spaces = (
            None,
            mission_net,
            MissionSpaces(mission_net),
        )
        subject._choice = Choice(EXPLICIT, max_states=MOST_MARKINGS)
        vars(subject)["markings"] = markings
        return subject

    @property
    def net(self) -> PetriNet:
        """Its net."""
        return self.mission_net.net

    @property
    def spaces(self) -> MissionSpaces:
        """Its spaces, built or not."""
        return self._spaces

    @cached_property
    def markings(self) -> StateGraph:
        """All its markings.

        Raises:
            UnsafeError: It is not 1-safe.
            LimitError: It has more than allowed.
        """
        space = self._spaces.markings(self._choice, tokens=False)
        assert isinstance(space, ArraySpace), "the explicit engine lists"
        return space.graph

    def reduced(self) -> StateGraph:
        """Its alternatives graph, of all interleavings.

        Raises:
            ConfluenceError: An event has two outcomes.
            DivergenceError: An internal run need not end.
        """
        space = self._spaces.reduced(self._choice)[0]
        assert isinstance(space, ArraySpace), "the explicit engine lists"
        return space.graph

    @cached_property
    def stable(self) -> Mask:
        """Which markings enable no internal transition."""
        internal = np.array([t.internal for t in self.net.transitions], np.bool_)
        stable = np.ones(self.markings.states, np.bool_)
        stable[self.markings.sources[internal[self.markings.labels]]] = False
        return stable

    def require(self, holds: Mask, message: str) -> None:
        """Sees that something holds in all markings.

        Raises:
            Violation: It does not, with a shortest run to a marking in which it does not.
        """
        if not holds.all():
            raise self.violation(int(np.flatnonzero(~holds)[0]), message, ~holds)

    def violation(self, state: int, message: str, where: Mask | None = None) -> Violation:
        """What is wrong in a marking, with a shortest run there, or to any of several."""
        goal = np.arange(self.markings.states) == state if where is None else where
        edges = self.markings.run_to(goal) or []
        names = [self.net.transitions[int(self.markings.labels[edge])].name for edge in edges]
        return Violation(message, [names], self.net)

    def after(self, alternatives: StateGraph, edge: int, message: str) -> Violation:
        """What is wrong after an edge of the alternatives graph, with a run that it ends."""
        graph = self.markings
        number = {graph.marking(state): state for state in np.flatnonzero(self.stable).tolist()}
        ends = (alternatives.sources[edge], alternatives.targets[edge])
        before, after = (number[alternatives.marking(int(state))] for state in ends)
        state = np.arange(graph.states)
        run = graph.run_to(state == before) or []
        label = alternatives.labels[edge]
        event = next(e for e in np.flatnonzero(graph.sources == before).tolist() if graph.labels[e] == label)
        inside = graph.run_to(state == after, int(graph.targets[event]), along=~self.stable) or []
        names = [self.net.transitions[int(graph.labels[e])].name for e in (*run, event, *inside)]
        return Violation(message, [names], self.net)
