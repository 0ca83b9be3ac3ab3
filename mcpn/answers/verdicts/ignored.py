"""Declared events that are ignored: what runs while nothing around it handles them.

An event that no block handles where it would come changes nothing, and in formulas it does not happen there.
So "after a leak the robot comes up" is met by a mission that handles no leak.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mcpn.answers.verdicts.unselectable import objectives_run
from mcpn.drawing.compose import MissionNet
from mcpn.mission.expansion.copies import Copies
from mcpn.mission.static.warnings import names_of_objectives
from mcpn.nets.events import Event, What
from mcpn.sentences import shortened
from mcpn.spaces.algebra import S, Space


@dataclass(frozen=True)
class Ignored:
    """A declared event that is ignored.

    Args:
        event: Its name.
        objectives: Those that run in some state in which it is ignored, in document order.
        required: Whether its declaration says that it must always be handled.
        words: The same for a reader, without the event: copies of one objective are said together.
    """

    event: str
    objectives: tuple[str, ...]
    required: bool
    words: str

    @property
    def sentence(self) -> str:
        """What is ignored, and while what runs."""
        return f"{self.event} is ignored while {self.words}"


def ignored_events(mission_net: MissionNet, space: Space[S]) -> Iterator[Ignored]:
    """The declared events that are ignored in some state in which an objective runs, in document order.

    Args:
        mission_net: The mission's net.
        space: Its stable states, or its markings.
    """
    graph, transitions = mission_net.graph, mission_net.net.transitions
    for declared in mission_net.mission.events:
        if declared.sets:
            continue  # it changes facts, and interrupts nothing
        event = Event(What.DECLARED, declared.name)
        own = [t for t, transition in enumerate(transitions) if transition.event == event]
        unhandled = space.stable - space.enabling(own) if own else space.stable
        running = objectives_run(mission_net, space, unhandled)
        names = tuple(section.name for section in graph.walk() if section.name in running)
        if names:
            words = _while(graph.copies, names, names_of_objectives(graph))
            yield Ignored(declared.name, names, declared.required, words)


def _while(copies: Copies, names: Sequence[str], every: Sequence[str]) -> str:
    told = copies.told(names, every)
    return f"{shortened(told)} {'runs' if len(told) == 1 else 'run'}"
