"""What the nodes of behaviour trees and of ROS 2 are said to do around a controller, over the runtime."""

from __future__ import annotations

import random
from collections.abc import Iterator

from mcpn.controller.generate import Form
from mcpn.mission.model import Mission
from mcpn.mission.passes import core
from mcpn.robot.runtime import Action, Controller, Refused
from mcpn.robot.runtime.controller_tables import Tables
from tests.controller.traces import canonical

START = "MISSION_EV_START"
FORMS: tuple[Form, ...] = ("hierarchical", "modular", "flat")


class Modelled:
    """What the node is said to do, over the runtime: an independent telling of the header's comment."""

    def __init__(self, mission: Mission, tables: Tables) -> None:
        self.tables = tables
        self.told: list[str] = []
        robots = core(mission)
        self.fixed = {each.name for each in (*robots.common_causes, *robots.crashes)}
        self.takes = {
            (activity.name, way.name): [k for k in way.consumes if k not in self.fixed]
            for activity in robots.activities
            for way in activity.alternatives
        }
        self.hardware = {each.name for each in robots.hardware}
        self.crashes = {each.name for each in robots.crashes}
        self.controller = Controller(tables, log=1)
        self.running = False
        self.started: list[str] = []
        self.timed: list[str] = []

    def take(self, event: str) -> tuple[str, list[str]]:
        try:
            actions = self.controller.handle(event)
        except Refused as refused:
            return ("refused" if refused.known else "unknown"), []
        for action in actions:
            self._note(action)
        return "taken", [str(action) for action in actions]

    def _note(self, action: Action) -> None:
        verb, what, *_ = str(action).split()
        if verb == "start":
            self.started.append(what)
        elif verb == "stop":
            self.started.remove(what)
        elif verb == "arm":
            self.timed.append(what)
        elif verb == "disarm":
            self.timed.remove(what)

    def line(self, event: str) -> str:
        if not event:
            return canonical(self.halt())
        if not self.running and event != START:
            self.told.append(event)
            return canonical("told: |")
        actions: list[str] = []
        if not self.running:
            lost = self.controller.out_of_service
            self.controller, self.running = Controller(self.tables, log=1), True
            self.started, self.timed = [], []
            for name in sorted(lost ^ self.controller.out_of_service):
                if name in self.hardware and name not in self.crashes:
                    actions += self.take(f"{name}_EV_{'OOS' if name in lost else 'RD'}")[1]
            for each in self.told:
                actions += self.take(each)[1]
            self.told = []
        status, more = self.take(event)
        actions += more
        c = self.controller
        mode = " ".join(sorted(f"{a}.{way}" for a, way in c.mode.items()))
        if c.outcome is not None:
            self.running = False
        said = f"{status}: {'; '.join(actions)} | {mode} | {' '.join(c.possible)} | {c.outcome or '-'}"
        return canonical(said)

    def halt(self) -> str:
        actions: list[str] = []
        if self.running:
            actions += [f"disarm {name}" for name in self.timed]
            modes = [(a, self.controller.mode[a]) for a in reversed(self.started)]
            actions += [f"stop {a}" for a, _ in modes]
            held = [k for mode in modes for k in self.takes[mode] if k in self.hardware]
            actions += [f"release {k}" for k in dict.fromkeys(held)]
        self.running = False
        return f"halted: {'; '.join(actions)} |"

    def events(self, rng: random.Random, steps: int) -> Iterator[str]:
        """Events at random, impossible ones and halts among them; none before the start that would end it."""
        every = sorted(self.tables.known)
        for _ in range(steps):
            chosen = rng.random()
            if not self.running:
                yield rng.choice([e for e in every if e != START]) if chosen < 0.5 else START
            elif chosen < 0.01:
                yield ""
            elif chosen < 0.05:
                yield rng.choice([*every, "no_such_EV"])
            else:
                yield rng.choice(self.controller.possible)
