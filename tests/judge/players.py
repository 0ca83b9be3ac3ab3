"""All that plays a mission in mcpn, seen alike: the engines' graphs, the simulator, controllers."""

from __future__ import annotations

import json
from collections.abc import Hashable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from typing import Any, Literal, Protocol, TypeVar

from mcpn.answers.spaces import spaces_of
from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.controller.generate import generate
from mcpn.controller.minimise import minimise
from mcpn.controller.modular import AnyController
from mcpn.controller.simulator import Simulation
from mcpn.controller.targets.json import document
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.nets.events import Event
from mcpn.runtime import Controller as Runtime
from mcpn.runtime.restoring import snapshot_text
from mcpn.runtime.tables import Inside
from mcpn.spaces.engines import Engine
from mcpn.spaces.stable.alternatives import AlternativesGraph, written_out
from tests.judge.interpreter import Happening, Seen

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
FORMS: tuple[Literal["flat", "hierarchical"], ...] = ("flat", "hierarchical")
MODULAR = "modular controller"

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
    return event.what.value, event.element


@cache
def named(text: str) -> Happening:
    """An event by the name that controllers give it."""
    return happening(Event.parse(text))


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
    """The alternatives graph of an engine."""

    start = 0

    def __init__(self, mission_net: MissionNet, engine: Engine, max_states: int) -> None:
        self.mission_net = mission_net
        space = spaces_of(mission_net).space(engine, "alternatives")
        listed = getattr(space, "graph", None)
        self.graph = (
            listed if isinstance(listed, AlternativesGraph) else written_out(space, engine, max_states)
        )
        self.edges: dict[int, dict[Happening, int]] = {}

    def seen(self, at: int) -> Seen:
        said = situation(self.mission_net, self.graph.marking(at))
        return seen_of(said, said.out_of_service, said.unnoticed, said.facts, said.outcome)

    def possible(self, at: int) -> set[Happening]:
        return set(self.onward(at))

    def after(self, at: int, happened: Happening) -> tuple[int, Iterable[Order]]:
        return self.onward(at)[happened], ()

    def onward(self, at: int) -> dict[Happening, int]:
        if at not in self.edges:
            transitions = self.graph.net.transitions
            found = [(happening(transitions[t].event), to) for t, to in self.graph.successors(at)]
            self.edges[at] = dict(found)
            assert len(self.edges[at]) == len(found), "one event leads to one state"
        return self.edges[at]


class OfSimulator:
    """The simulator, which runs the net event by event."""

    def __init__(self, mission_net: MissionNet) -> None:
        self.simulation = Simulation(mission_net)
        self.start = self.simulation.marking

    def seen(self, at: int) -> Seen:
        self.simulation.marking = at
        said = self.simulation.situation
        return seen_of(said, said.out_of_service, said.unnoticed, said.facts, said.outcome)

    def possible(self, at: int) -> set[Happening]:
        self.simulation.marking = at
        return set(map(happening, self.simulation.possible))

    def after(self, at: int, happened: Happening) -> tuple[int, Iterable[Order]]:
        self.simulation.marking = at
        (event,) = (e for e in self.simulation.possible if happening(e) == happened)
        assert self.simulation.take(event) is not None
        return self.simulation.marking, ()


class OfController:
    """A controller in the runtime, put back by its snapshots."""

    def __init__(self, mission_net: MissionNet, controller: AnyController) -> None:
        self.runtime = Runtime.from_document(document(controller, mission_net), log=1, clock=lambda: 0.0)
        self.texts: dict[str, dict[Happening, str]] = {}
        self.start = self.here()

    def here(self) -> str:
        return snapshot_text(json.loads(self.runtime.snapshot()) | {"count": 0})

    def seen(self, at: str) -> Seen:
        self.runtime.restore(at)
        it = self.runtime
        return seen_of(it.state, it.out_of_service, it.unnoticed, it.facts, it.outcome)

    def possible(self, at: str) -> set[Happening]:
        if at not in self.texts:
            self.runtime.restore(at)
            texts = self.runtime.possible
            self.texts[at] = {named(text): text for text in texts}
            assert len(self.texts[at]) == len(texts), "one text is one event"
        return set(self.texts[at])

    def after(self, at: str, happened: Happening) -> tuple[str, Iterable[Order]]:
        assert happened in self.possible(at)
        self.runtime.restore(at)
        actions = self.runtime.handle(self.texts[at][happened])
        orders = [
            (a.objective, a.activity or "", a.alternative or "", {p.name: p.value for p in a.parameters})
            for a in actions
            if a.verb == "select"
        ]
        return self.here(), orders


def graphs(mission_net: MissionNet, max_states: int) -> Iterator[tuple[str, Player[Any]]]:
    """The alternatives graph of every engine.

    Raises:
        ConfluenceError: The engine says that internal evolution is not confluent.
        LimitError: There are too many states.
    """
    for engine in ENGINES:
        yield engine, OfGraph(mission_net, engine, max_states)


def controllers(mission_net: MissionNet, max_states: int) -> Iterator[tuple[str, Player[Any]]]:
    """The simulator, and every form of controller, minimised and not; the modular one if there is one."""
    yield "simulator", OfSimulator(mission_net)
    for form in FORMS:
        controller = generate(mission_net, form, max_states=max_states)
        yield f"{form} controller", OfController(mission_net, controller)
        yield f"{form} controller, minimised", OfController(mission_net, minimise(controller))
    with suppress(LimitError):
        yield MODULAR, OfController(mission_net, generate(mission_net, "modular"))
