"""Drawn missions among drivers that do anything: what runs is the functioning mode, always."""

from __future__ import annotations

import asyncio
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.simulator import Simulation
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.robot.drivers.mapping import OTHER, DriverSpec, Plan, check_plan
from mcpn.robot.drivers.running import RobotRun
from mcpn.robot.runtime.actions import START
from mcpn.robot.runtime.controller import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.testing import missions
from tests.draws import composed
from tests.drivers import fake
from tests.shares import returns_early

HERE = Path(__file__)
MOST_EVENTS = 40
LONGEST = 100
"""Turns of the loop: a driver tells what it tells within a few."""


def plan_of(tables: Tables) -> Plan:
    """Every activity ends as it likes and tells of hardware and declared events what it likes."""
    ends = {"true": "success", OTHER: "failure"}
    words = {event: event for event in sorted(tables.known) if not event.startswith(("OBJ_", START))}
    named = {activity for row in tables.laws.objectives.values() for activity in row["activities"]}
    activities: dict[tuple[str, str | None], DriverSpec] = {
        (name, None): DriverSpec(
            ("activities", name),
            "python",
            function=f"{fake.__name__}:act",
            lines=words,
            ends=ends if name in named else {},
        )
        for name in tables.laws.activities
    }
    return Plan(HERE, {}, activities, {}, {}, ("*",), {}, {})


@given(missions(max_events=1), st.integers(0, 2**32))
def test_what_runs_is_the_functioning_mode(mission: Mission, seed: int) -> None:
    found = composed(mission)
    try:
        tables = Tables(document(generate(found, max_states=2000), found))
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    plan = plan_of(tables)
    check_plan(plan, tables)
    fake.begin(seed, [event for event in sorted(tables.known) if not event.startswith(("OBJ_", START))])
    controller = Controller(tables)
    beside = Simulation(found)  # the mission's net, by its plain definition

    def after() -> None:
        step = controller.log[-1]
        assert beside.take(Event.parse(step.event)) is not None, step
        if controller.count >= MOST_EVENTS:
            runner.end()

    async def run() -> None:
        going, idle, count = asyncio.create_task(runner.run()), 0, 0
        while not going.done():
            await asyncio.sleep(0)
            idle = 0 if runner.busy or controller.count != count else idle + 1
            count = controller.count
            if idle:
                assert {name: of.alternative for name, of in runner.running.items()} == controller.mode
            if idle > LONGEST:  # nobody has anything more to say
                for objective in controller.state.objectives:
                    activities = tables.laws.objectives[objective]["activities"]
                    assert not activities or not controller.state.waiting.keys().isdisjoint(activities)
                runner.end()
                idle = 0
        await going

    runner = RobotRun(controller, tables, plan, after=after)
    asyncio.run(run())
    assert fake.LIVE == {}
    assert runner.running == {}
    ends = [step.event for step in controller.log if not step.taken and step.event.startswith("OBJ_")]
    assert ends == []  # what an objective ends with is never refused: it is kept, or no longer counts
