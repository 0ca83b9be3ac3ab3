"""Stateful tests: every controller of a mission beside its net, whatever is asked of them in what order."""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path
from typing import ClassVar

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.minimise import minimise
from mcpn.controller.modular import AnyController
from mcpn.controller.simulator import Simulation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.events import Event
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.runtime import Refused
from mcpn.robot.runtime.controller_tables import Tables
from tests.conftest import ULYSSE
from tests.controller.oracle import NetRobot
from tests.controller.test_exits import WATCH
from tests.controller.test_lockstep import plain


@cache
def made(path: Path) -> tuple[MissionNet, list[Tables]]:
    """The tables of a mission's controllers: flat and hierarchical, minimised and not; modular."""
    net = compose(read_mission(path))
    tables = [generate(net, "flat"), generate(net, "hierarchical")]
    controllers: list[AnyController] = [*tables, *map(minimise, tables), generate(net, "modular")]
    return net, [Tables(document(controller, net)) for controller in controllers]


class Beside(RuleBasedStateMachine):
    """The plain net, the simulator and five runtimes."""

    mission: ClassVar[Path] = ULYSSE

    @initialize(seed=st.integers(0, 2**32))
    def begin(self, seed: int) -> None:
        self.net, tables = made(self.mission)
        self.seed = seed
        self.robot = NetRobot(self.net, random.Random(seed))
        self.simulation = Simulation(self.net)
        self.runtimes = [Runtime(each) for each in tables]
        self.events: list[str] = []

    def take(self, event: str) -> None:
        expected = self.robot.handle(event)
        change = self.simulation.take(Event.parse(event))
        assert change is not None
        self.events.append(event)
        for runtime in self.runtimes:
            assert plain(runtime.handle(event)) == expected

    @precondition(lambda self: bool(self.robot.possible))
    @rule(data=st.data())
    def event(self, data: st.DataObject) -> None:
        self.take(data.draw(st.sampled_from(sorted(self.robot.possible))))

    @rule(data=st.data())
    def impossible(self, data: st.DataObject) -> None:
        known = {str(t.event) for t in self.net.net.transitions if t.event}
        event = data.draw(st.sampled_from([*sorted(known - self.robot.possible.keys()), "no_such_EV"]))
        assert self.simulation.take(Event.parse(event)) is None
        for runtime in self.runtimes:
            with pytest.raises(Refused):
                runtime.handle(event)

    @precondition(lambda self: bool(self.events))
    @rule()
    def undo(self) -> None:
        """The simulator takes one back; the others are made anew and led there."""
        self.simulation.undo()
        events = self.events[:-1]
        _, tables = made(self.mission)
        self.robot = NetRobot(self.net, random.Random(self.seed))
        self.runtimes = [Runtime(each) for each in tables]
        for event in events:
            self.robot.handle(event)
            for controller in self.runtimes:
                controller.handle(event)
        self.events = events

    @rule()
    def snapshot(self) -> None:
        for number, runtime in enumerate(self.runtimes):
            other = Runtime(runtime._tables)
            other.restore(runtime.snapshot())
            self.runtimes[number] = other

    @invariant()
    def same(self) -> None:
        possible = sorted(self.robot.possible)
        assert sorted(map(str, self.simulation.possible)) == possible
        assert self.simulation.situation.mode == self.robot.mode
        for runtime in self.runtimes:
            assert list(runtime.possible) == possible
            assert dict(runtime.mode) == self.robot.mode
            assert runtime.outcome == self.robot.outcome


TestBeside = Beside.TestCase
TestBeside.settings = settings(max_examples=15, stateful_step_count=25, deadline=None)


class BesideInterrupted(Beside):
    """The same of a mission whose sections events leave by exits of their own."""

    mission = WATCH


TestBesideInterrupted = BesideInterrupted.TestCase
TestBesideInterrupted.settings = settings(max_examples=15, stateful_step_count=25, deadline=None)
