"""All that plays a mission in mcpn, seen alike: the engines' graphs, the simulator, controllers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from typing import Any, Literal

from mcpn.answers.spaces import spaces_of
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
from mcpn.spaces.engines import Engine
from mcpn.spaces.stable.alternatives import AlternativesGraph, written_out
from mcpn.testing.judge.interpreter import Happening, Seen
from mcpn.testing.judge.players import OfGraph as OfStates
from mcpn.testing.judge.players import Order, Player, happening, seen_of

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")
FORMS: tuple[Literal["flat", "hierarchical"], ...] = ("flat", "hierarchical")
MODULAR = "modular controller"


@cache
def named(text: str) -> Happening:
    """An event by the name that controllers give it."""
    return happening(Event.parse(text))


class OfGraph(OfStates):
    """The alternatives graph of an engine."""

    def __init__(self, mission_net: MissionNet, engine: Engine, max_states: int) -> None:
        space = spaces_of(mission_net).space(engine, "alternatives")
        graph = getattr(space, "graph", None)
        if not isinstance(graph, AlternativesGraph):
            graph = written_out(space, engine, max_states)
        super().__init__(mission_net, graph)


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
