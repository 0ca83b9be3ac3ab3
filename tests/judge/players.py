"""All that plays a mission in mcpn, seen alike: the engines' graphs, the simulator, controllers."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from typing import Any, Literal, TypeAlias

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.minimise import minimise
from mcpn.controller.modular import AnyController
from mcpn.controller.simulator import Simulation
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import Event
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.runtime.restoring import Saved
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import AlternativesGraph
from mcpn.spaces.stable.written_out import written_out
from mcpn.testing.judge.interpreter import Happening, Seen
from mcpn.testing.judge.lockstep import OfGraph as OfStates
from mcpn.testing.judge.lockstep import Order, Player, happening, seen_of

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
        self.events: dict[int, dict[Happening, Event]] = {}
        self.start = self.simulation.marking

    def seen(self, at: int) -> Seen:
        self.simulation.marking = at
        said = self.simulation.situation
        return seen_of(said, said.out_of_service, said.unnoticed, said.facts, said.outcome)

    def possible(self, at: int) -> set[Happening]:
        if at not in self.events:
            self.simulation.marking = at
            possible = self.simulation.possible
            self.events[at] = {happening(event): event for event in possible}
            assert len(self.events[at]) == len(possible), "one event is possible once"
        return set(self.events[at])

    def after(self, at: int, happened: Happening) -> tuple[int, Iterable[Order]]:
        assert happened in self.possible(at)
        self.simulation.marking = at
        assert self.simulation.take(self.events[at][happened]) is not None
        return self.simulation.marking, ()


Place: TypeAlias = tuple[Hashable, ...]
"""Where a controller is, without how many events it has taken."""


class OfController:
    """A controller in the runtime, put back by its snapshots; each state is once read from a text."""

    def __init__(self, mission_net: MissionNet, controller: AnyController) -> None:
        self.runtime = Runtime.from_document(document(controller, mission_net), log=1, clock=lambda: 0.0)
        self.texts: dict[Place, dict[Happening, str]] = {}
        self.saved: dict[Place, Saved] = {}
        self.first = self.runtime.saved()
        self.start = self.here()

    def here(self) -> Place:
        saved = self.runtime.saved()
        section = saved.section.name if saved.section else None
        sets = frozenset(saved.out_of_service), frozenset(saved.true), frozenset(saved.timers.items())
        place = saved.phase, section, saved.state, *sets
        if place not in self.saved:
            text = self.runtime.snapshot()
            self.runtime.resume(self.first)
            self.runtime.restore(text)
            self.saved[place] = self.runtime.saved()
            assert self.saved[place] == saved, "a snapshot says all"
        return place

    def seen(self, at: Place) -> Seen:
        it = self.runtime
        it.resume(self.saved[at])
        return seen_of(it.state, it.out_of_service, it.unnoticed, it.facts, it.outcome)

    def possible(self, at: Place) -> set[Happening]:
        if at not in self.texts:
            self.runtime.resume(self.saved[at])
            texts = self.runtime.possible
            self.texts[at] = {named(text): text for text in texts}
            assert len(self.texts[at]) == len(texts), "one text is one event"
        return set(self.texts[at])

    def after(self, at: Place, happened: Happening) -> tuple[Place, Iterable[Order]]:
        assert happened in self.possible(at)
        self.runtime.resume(self.saved[at])
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
