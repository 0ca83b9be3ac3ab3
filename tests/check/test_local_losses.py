"""Cut sets by composition against those of the whole graph, contention inside sections included."""

from __future__ import annotations

import time
from dataclasses import replace

from hypothesis import given, settings

from mcpn.check.causes import find_causes, find_causes_locally
from mcpn.check.cutsets import Losses, Moment
from mcpn.check.local_losses import LocalLosses, local_mission
from mcpn.check.losing import CriticalEvent, Outlook
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.flatten import flatten
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Parallel, Robot
from mcpn.mission.usage import Usage
from mcpn.net.compose import MissionNet, compose
from mcpn.space.alternatives import direct
from mcpn.testing import missions
from tests.check.oracle import fragile_missions


def agree(found: MissionNet, max_states: int) -> None:
    try:
        whole = Losses(Outlook(found, direct(found.net, max_states=max_states)))
    except (LimitError, ConfluenceError):
        return
    local = LocalLosses(found.usage)
    assert local.hardware == whole.hardware
    goal = whole.outlook.mission

    def same(one: int, other: int) -> None:
        assert local.families.members(one) == whole.families.members(other)  # type: ignore[arg-type]

    for moment in (Moment.START, Moment.WHENEVER, Moment.SOMETIME):
        same(local.mission_at(moment), whole.cut_sets(goal, moment))
    for section in found.graph.sections:
        if whole.entry(section.name).any():
            same(local.mission_entering(section.name), whole.cut_sets(goal, Moment.ENTRY, section.name))
    for moment in (Moment.ENTRY, Moment.WHENEVER, Moment.SOMETIME):
        functions = local.objective_at(moment)
        for name, objective in whole.outlook.objectives.items():
            if objective.running.any():
                same(functions[name], whole.cut_sets(objective, moment, name))


def situations(found: list[CriticalEvent]) -> set[tuple[str, tuple[str, ...], tuple[tuple[str, str], ...]]]:
    return {(c.event, c.objectives, tuple(sorted(c.mode.items()))) for c in found}


def agree_on_reports(found: MissionNet, max_states: int) -> None:
    """What is reported by composition is what is reported on the whole graph."""
    try:
        outlook = Outlook(found, direct(found.net, max_states=max_states))
    except (LimitError, ConfluenceError):
        return
    whole, local = find_causes(found, outlook), find_causes_locally(found)
    assert situations(local.mission.critical) == situations(whole.mission.critical)
    assert local.mission.cut_sets == whole.mission.cut_sets
    for name, goal in whole.objectives.items():
        if outlook.objectives[name].running.any():
            assert local.objectives[name].cut_sets == goal.cut_sets
            assert situations(local.objectives[name].critical) == situations(goal.critical)
    entered = {s.section: s for s in local.survival}
    for survival in whole.survival:
        if survival.section in entered:
            assert replace(survival, run=None) == entered[survival.section]


def test_ulysse(ulysse_net: MissionNet) -> None:
    agree(ulysse_net, 1000)
    agree_on_reports(ulysse_net, 1000)


@settings(max_examples=100)
@given(missions(max_objectives=3, max_sections=6, max_hardware=3) | fragile_missions(max_hardware=4))
def test_composition_reports_what_the_whole_reports(mission: Mission) -> None:
    agree_on_reports(compose(mission), 1000)


@settings(max_examples=150)
@given(missions(max_objectives=3, max_sections=6, max_hardware=3) | fragile_missions(max_hardware=4))
def test_composition_gives_the_cut_sets_of_the_whole(mission: Mission) -> None:
    agree(compose(mission), 1500)


@given(missions(max_sections=10))
def test_the_mission_of_a_section_is_that_section(mission: Mission) -> None:
    usage = Usage(mission, flatten(mission))
    for section in usage.graph.sections:
        (alone,) = flatten(local_mission(usage, section)).sections
        assert repr(alone).replace(repr(alone.success), "").replace(repr(alone.failure), "")
        assert (alone.name, alone.success, alone.failure) == (section.name, "succeed", "fail")


def long_mission(sections: int, ways: int) -> Mission:
    """Sections in a row, the odd ones with two branches that share a chain of software; own hardware each."""
    hardware, activities, blocks = [], [], []
    for i in range(sections):
        own = [Hardware(name=f"h{i}_{k}") for k in range(ways)]
        hardware += own
        alternatives = tuple(Alternative(name=f"way{h.name}", consumes=(h.name,)) for h in own)
        activities.append(Activity(name=f"a{i}", alternatives=alternatives))
        free = Activity(name=f"free{i}", alternatives=(Alternative(name="free"),))
        activities.append(free)
        alone = Objective(name=f"x{i}", activities=(f"a{i}",))
        beside = Objective(name=f"y{i}", activities=(f"free{i}",))
        blocks.append(Parallel(name=f"p{i}", blocks=(alone, beside)) if i % 2 else alone)
    robot = Robot(name="r", hardware=tuple(hardware), activities=tuple(activities))
    return Mission(name="long", robots=(robot,), blocks=tuple(blocks))


def test_thirty_resources_in_ten_sections_take_seconds() -> None:
    mission = long_mission(10, 3)
    started = time.process_time()
    local = LocalLosses(Usage(mission, flatten(mission)))
    # Closed form: a section is lost with its three resources, the mission with any section.
    expected = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(10)]
    assert local.families.members(local.mission) == expected
    for number in range(10):
        entering = local.mission_entering(f"p{number}" if number % 2 else f"x{number}")
        assert local.families.members(entering) == expected[number:]
    # Once the last objective has succeeded and only the one beside it runs, no loss does harm.
    assert local.families.members(local.mission_at(Moment.WHENEVER)) == []
    assert local.families.members(local.mission_at(Moment.SOMETIME)) == expected
    assert time.process_time() - started < 10
