"""What plays a mission, seen as the interpreter sees it: the alternatives graph of a net."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import Protocol, TypeVar

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.nets.events import Event
from mcpn.runtime.tables import Inside
from mcpn.spaces.markings.graph import StateGraph
from mcpn.testing.judge.interpreter import Happening, Seen

Order = tuple[str | None, str, str, Mapping[str, str]]
"""An alternative that is selected: its objective, its activity, its name, the parameters that it is given."""


Key = TypeVar("Key", bound=Hashable)
"""Where a player is; it can be gone back to."""


class Player(Protocol[Key]):
    """A mission played by mcpn."""

    start: Key

    def seen(self, at: Key) -> Seen:
        """What can be seen there."""

    def possible(self, at: Key) -> set[Happening]:
        """The events that may happen there."""

    def after(self, at: Key, happened: Happening) -> tuple[Key, Iterable[Order]]:
        """Where an event leads, and the alternatives that are selected on the way, where orders are given."""


def happening(event: Event | None) -> Happening:
    """An event of a net in the interpreter's words."""
    assert event is not None
    return " ".join(filter(None, (event.what.value, event.reason))), event.element


def seen_of(
    said: Situation | Inside,
    out: Iterable[str],
    unnoticed: Iterable[str],
    facts: Mapping[str, str],
    outcome: str | None,
) -> Seen:
    """What a situation or a controller's state says."""
    return Seen(
        frozenset(said.objectives),
        frozenset(said.pending),
        frozenset(said.done),
        frozenset(said.mode.items()),
        frozenset(said.waiting.items()),
        frozenset(said.refused),
        frozenset(out),
        frozenset(unnoticed),
        frozenset(facts.items()),
        outcome,
    )


class OfGraph:
    """An alternatives graph.

    Args:
        mission_net: The net of the mission.
        graph: Its stable states.
    """

    start = 0

    def __init__(self, mission_net: MissionNet, graph: StateGraph) -> None:
        self.mission_net, self.graph = mission_net, graph
        self.edges: dict[int, dict[Happening, int]] = {}

    def seen(self, at: int) -> Seen:
        """What can be seen in a state."""
        said = situation(self.mission_net, self.graph.marking(at))
        return seen_of(said, said.out_of_service, said.unnoticed, said.facts, said.outcome)

    def possible(self, at: int) -> set[Happening]:
        """The events that may happen there."""
        return set(self.onward(at))

    def after(self, at: int, happened: Happening) -> tuple[int, Iterable[Order]]:
        """Where an event leads; a graph gives no orders."""
        return self.onward(at)[happened], ()

    def onward(self, at: int) -> dict[Happening, int]:
        """Each event that may happen in a state, and where it leads."""
        if at not in self.edges:
            transitions = self.graph.net.transitions
            found = [(happening(transitions[t].event), to) for t, to in self.graph.successors(at)]
            self.edges[at] = dict(found)
            assert len(self.edges[at]) == len(found), "one event leads to one state"
        return self.edges[at]
