"""A campaign: generated missions through every engine and both controllers, which must all say the same.

``MCPN_CAMPAIGN`` says how many missions (2,000 if not set), ``MCPN_CAMPAIGN_SEED`` which ones::

    MCPN_CAMPAIGN=20000 python -m pytest -m slow -s tests/test_campaign.py
"""

from __future__ import annotations

import os
import random
import sys
import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from mcpn.check.modes import Situation
from mcpn.controller.hierarchy import Hierarchy, hierarchical_controller
from mcpn.controller.machine import Action, Edge, Machine, controller
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import START, Event, What
from mcpn.space.alternatives import by_reduction
from mcpn.space.confluence import prove_confluent
from mcpn.space.explicit import explore
from mcpn.space.local.expand import expand
from mcpn.space.local.gluing import glue
from mcpn.space.local.placing import Making
from mcpn.space.symbolic import reach
from mcpn.testing import missions
from tests.net.promises import check_promises

LIMIT = 20_000
EVENTS = 200


def test_a_few_missions_agree_in_every_engine_and_controller() -> None:
    run_campaign(60, random.randrange(2**32))


@pytest.mark.slow
def test_campaign() -> None:
    run_campaign(int(os.environ.get("MCPN_CAMPAIGN", "2000")), int(os.environ.get("MCPN_CAMPAIGN_SEED", "1")))


def run_campaign(number: int, first: int) -> None:
    """Draws missions and judges each; prints how many were of which kind."""
    found: Counter[str] = Counter()
    began = time.monotonic()

    @seed(first)
    @settings(
        max_examples=number,
        phases=[Phase.generate, Phase.shrink],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(missions())
    def judged(mission: Mission) -> None:
        found["drawn"] += 1
        found[judge(mission, random.Random(found["drawn"]))] += 1

    try:
        judged()
    finally:
        took = time.monotonic() - began
        kinds = ", ".join(f"{n} {what} ({n / found['drawn']:.1%})" for what, n in found.items())
        sys.stdout.write(f"\nseed {first}: {kinds} in {took:.0f} s\n")


def judge(mission: Mission, choice: random.Random) -> str:
    """Holds every engine and both controllers against one another on a mission; says of what kind it is."""
    mission_net = compose(mission)
    net, usage = mission_net.net, mission_net.usage
    try:
        markings = explore(net, max_states=LIMIT)  # 1-safety is checked at each firing
    except LimitError:
        return "too large"
    check_promises(mission_net, markings)
    space = reach(net)
    assert space.reachable.count() == markings.states
    try:
        whole = by_reduction(markings)
    except (ConfluenceError, DivergenceError) as error:
        assert usage.contentions or usage.exchanges
        with pytest.raises(type(error)):
            prove_confluent(net, space=space)
        with pytest.raises((ConfluenceError, DivergenceError)):
            glue(usage, mission_net.graph, Making(most_listed=None))
        return "not confluent"
    prove_confluent(net, space=space)
    assert space.stable is not None
    assert space.stable.count() == whole.states
    composite = glue(usage, mission_net.graph, Making(most_listed=None))
    written = expand(composite, mission_net)
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(written, name), getattr(whole, name)), name
    lockstep(controller(mission_net, whole), hierarchical_controller(composite), mission_net, choice)
    return "confluent, may contend" if usage.contentions else "confluent, cannot contend"


# --- both controllers ------------------------------------------------------------------------------------


class TwoLevels:
    """A controller in two levels, run as :mod:`mcpn.controller.hierarchy` says."""

    def __init__(self, hierarchy: Hierarchy) -> None:
        self.hierarchy = hierarchy
        self.sections = {section.name: section for section in hierarchy.sections}
        self.out: set[str] = set()
        self.place = "begin"
        self.state = 0

    def events(self) -> set[Event]:
        """Events that it reacts to now."""
        if self.place == "begin":
            return {START}
        if self.place not in self.sections:
            return set()
        return {self.renamed(edge.event) for edge in self.edges()}

    def edges(self) -> list[Edge]:
        machine = self.hierarchy.types[self.sections[self.place].type]
        return [edge for edge in machine.edges if edge.source == self.state]

    def renamed(self, event: Event) -> Event:
        names = self.sections[self.place].names
        hardware = event.what in (What.OUT_OF_SERVICE, What.REPAIRED)
        return replace(event, element=names["hardware" if hardware else "objectives"][event.element])

    def react(self, event: Event) -> list[Action]:
        """Takes an event and says the actions, in the mission's names."""
        if event.what is What.OUT_OF_SERVICE:
            self.out.add(event.element)
        if event.what is What.REPAIRED:
            self.out.discard(event.element)
        if event == START and self.place == "begin":
            return self.enter(self.hierarchy.initial)
        for edge in self.edges() if self.place in self.sections else []:
            if self.renamed(edge.event) == event:
                section = self.sections[self.place]
                self.state = edge.target
                actions = self.in_names(edge.actions)
                outcome = self.hierarchy.types[section.type].states[edge.target].outcome
                if outcome:
                    actions += self.enter(section.success if outcome == "success" else section.failure)
                return actions
        return []

    def enter(self, name: str) -> list[Action]:
        self.place = name
        if name not in self.sections:
            return []
        section = self.sections[name]
        machine = self.hierarchy.types[section.type]
        own = {old for old, new in section.names["hardware"].items() if new in self.out}
        for edge in machine.edges:
            if edge.event == START and set(machine.states[edge.source].out_of_service) == own:
                self.state = edge.target
                return self.in_names(edge.actions)
        raise AssertionError(f"section {name} cannot be entered with {own} out of service")

    def in_names(self, actions: tuple[Action, ...]) -> list[Action]:
        names = self.sections[self.place].names
        found = []
        for action in actions:
            way = action.alternative
            if way is not None:
                way = names["alternatives"][f"{action.activity}.{way}"].split(".", 1)[1]
            found.append(Action(action.verb, names["activities"][action.activity], way))
        return found

    def situation(self) -> Situation:
        if self.place not in self.sections:
            outcome = {"succeed": "success", "fail": "failure"}.get(self.place)
            return Situation(out_of_service=tuple(sorted(self.out)), outcome=outcome)
        section = self.sections[self.place]
        names = section.names
        found = self.hierarchy.types[section.type].states[self.state]

        def modes(mode: dict[str, str]) -> dict[str, str]:
            new = (names["alternatives"][f"{a}.{w}"].split(".", 1) for a, w in mode.items())
            return dict(sorted((a, w) for a, w in new))

        return replace(
            found,
            objectives=tuple(names["objectives"][o] for o in found.objectives),
            pending=tuple(names["objectives"][o] for o in found.pending),
            done=(),
            mode=modes(found.mode),
            waiting=modes(found.waiting),
            refused=tuple(sorted(names["activities"][a] for a in found.refused)),
            out_of_service=tuple(sorted(self.out)),
        )


def joined(actions: list[Action], requested: set[str]) -> list[Action]:
    """The actions of a junction joined as ``papers/notes.md`` says."""
    stops = [a.activity for a in actions if a.verb == "stop"]
    starts = [a.activity for a in actions if a.verb == "start"]
    both = {a for a in stops if a in starts and a in requested}
    return [a for a in actions if a.verb == "select" or a.activity not in both]


def is_of_hardware(event: Event) -> bool:
    return event.what in (What.OUT_OF_SERVICE, What.REPAIRED)


def lockstep(flat: Machine, two: Hierarchy, mission_net: MissionNet, choice: random.Random) -> None:
    """Drives both controllers by the same random events, ends begun anew."""
    edges: dict[int, dict[Event, Edge]] = {}
    for edge in flat.edges:
        edges.setdefault(edge.source, {})[edge.event] = edge
    requested = {a.name for a in mission_net.mission.activities if a.produces}
    state, levels = flat.initial, TwoLevels(two)
    for _ in range(EVENTS):
        at = edges.get(state, {})
        ahead = levels.events()
        assert {e for e in at if not is_of_hardware(e)} == {e for e in ahead if not is_of_hardware(e)}
        if not at or (flat.states[state].outcome and choice.random() < 0.3):
            state, levels = flat.initial, TwoLevels(two)
            continue
        edge = at[choice.choice(sorted(at))]
        before, state = flat.states[state], edge.target
        after = flat.states[state]
        taken = joined(levels.react(edge.event), requested)
        there = levels.situation()
        assert there == replace(
            after,
            done=(),
            mode=dict(sorted(after.mode.items())),
            waiting=dict(sorted(after.waiting.items())),
            refused=tuple(sorted(after.refused)),
            out_of_service=tuple(sorted(after.out_of_service)),
        )
        # A producer that goes on is told nothing, unless its alternative changes.
        expected = [
            a
            for a in taken
            if a.verb != "select"
            or before.mode.get(a.activity) != a.alternative
            or any(s.verb == "start" and s.activity == a.activity for s in taken)
        ]
        assert sorted(map(str, expected)) == sorted(map(str, edge.actions))
